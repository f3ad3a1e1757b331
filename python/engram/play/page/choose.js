// All tasks, one card for each family; those that need memory come first.
import { find, make, options, rates } from './draw.js';
import { breakable, familyName, searchable, variantName, withoutPlaces } from './names.js';

const GAP = 0.05; // between sweep and oracle; where it is less, success does not show memory

let tasks = [];
const details = new Map();
const chosen = new Map(); // ids by family

export async function described(id) {
  if (!details.has(id)) {
    details.set(id, fetch(`task/${id}.json`).then((answer) => {
      if (!answer.ok) throw new Error(`task ${id}: ${answer.status}`);
      return answer.json();
    }));
  }
  return details.get(id);
}

// In the order of the page: families whose tasks need memory first, short tasks first.
export const all = () => tasks;

// In words: the RL tasks are another benchmark's, with other actions and ends.
const isRl = (task) => task.split === 'rl';

function variantWords(task) {
  const name = variantName(task);
  if (isRl(task)) return name ? `RL ${name}` : 'RL';
  return name ? `Variant ${name}` : 'One variant';
}

const needsMemory = (task) => task.sweep === null || task.oracle === null || task.oracle - task.sweep > GAP;

function inOrder(list) {
  const families = new Map();
  for (const task of list) {
    if (!families.has(task.family)) families.set(task.family, []);
    families.get(task.family).push(task);
  }
  const byName = new Intl.Collator('en', { numeric: true });
  const groups = [...families.values()].map((members) =>
    members.sort((a, b) => isRl(a) - isRl(b) || needsMemory(b) - needsMemory(a) || a.horizon - b.horizon || byName.compare(a.id, b.id)));
  return groups.sort((a, b) => needsMemory(b[0]) - needsMemory(a[0]) || b[0].canonical - a[0].canonical
    || Math.ceil(a[0].horizon / 100) - Math.ceil(b[0].horizon / 100)).flat();
}

function seconds(task) {
  const time = task.horizon / 20;
  return time < 10 ? `${time.toFixed(1)} s` : `${Math.round(time)} s`;
}

function card(members) {
  const { family } = members[0];
  const picture = make('img', { width: 320, height: 240, loading: 'lazy', decoding: 'async' });
  const parts = {
    instruction: make('p', { class: 'instruction-text' }),
    id: make('p', { class: 'id' }),
    facts: make('p', { class: 'facts' }),
    rates: make('div'),
  };
  let task = members[0];
  const go = (view) => () => {
    document.dispatchEvent(new CustomEvent('chosen', { detail: { id: task.id, view } }));
  };
  const buttons = ['Play', 'Watch'].map((word) =>
    make('button', { type: 'button', onclick: go(word.toLowerCase()) }, word));
  const show = (id) => {
    task = members.find((one) => one.id === id);
    picture.src = `picture/${task.id}.jpg`;
    picture.alt = `A moment of ${task.id}`;
    parts.instruction.textContent = withoutPlaces(task.instruction);
    parts.instruction.title = parts.instruction.textContent;
    parts.id.replaceChildren(...breakable(task.id));
    parts.facts.textContent = `${task.memory_type} memory, ${task.own ? 'your own' : task.split}, ${seconds(task)}: ${task.phases.join(' → ')}`;
    parts.rates.replaceChildren(rates([
      ['guessing', task.chance], ['without memory', task.sweep], ['oracle', task.oracle],
    ]));
    for (const button of buttons) button.setAttribute('aria-label', `${button.textContent} ${task.id}`);
  };
  const select = make('select', {
    'aria-label': `Variant of ${familyName(family)}`,
    onchange: (event) => {
      chosen.set(family, event.target.value);
      show(event.target.value);
    },
  });
  const before = members.find((one) => one.id === chosen.get(family)) ?? members[0];
  options(select, members.map((one) => [one.id, variantWords(one)]), before.id);
  select.disabled = members.length === 1;
  show(before.id);
  return make('article', { class: 'card', 'aria-label': familyName(family) }, picture,
    make('div', { class: 'words' }, make('h4', {}, familyName(family)), parts.instruction, parts.id,
      parts.facts, parts.rates, make('div', { class: 'buttons' }, select, ...buttons)));
}

function section(title, note, list) {
  const families = new Map();
  for (const task of list) families.set(task.family, [...(families.get(task.family) ?? []), task]);
  return make('section', { 'aria-label': title }, make('h3', {}, title), note && make('p', { class: 'note' }, note),
    make('div', { class: 'cards' }, ...[...families.values()].map(card)));
}

function show() {
  const form = find('filter').elements;
  const words = searchable(form.words.value).split(/\s+/).filter(Boolean);
  const shown = tasks.filter((task) => {
    const text = searchable(`${task.id} ${familyName(task.family)} ${task.split} ${task.memory_type} ${task.instruction}`);
    return words.every((word) => text.includes(word))
      && (!form.split.value || task.split === form.split.value)
      && (!form.memory.value || task.memory_type === form.memory.value);
  });
  const needed = new Set(tasks.filter(needsMemory).map((task) => task.family));
  const own = shown.filter((task) => task.own);
  const [first, rest] = [true, false].map((wanted) =>
    shown.filter((task) => !task.own && needed.has(task.family) === wanted));
  find('families').replaceChildren(...[
    own.length && section('Your own tasks', null, own),
    first.length && section('These tasks need memory', null, first),
    rest.length && section('These can be solved without memory', 'Trying everything succeeds as often as knowing. Only the first answer shows whether something was remembered.', rest),
  ].filter(Boolean));
  find('count').textContent = `${shown.length} of ${tasks.length} tasks`;
  find('no-task').hidden = shown.length > 0;
}

export async function begin() {
  tasks = inOrder(await (await fetch('tasks.json')).json());
  const form = find('filter');
  const kinds = (key) => [['', 'all'], ...[...new Set(tasks.map((task) => task[key]))].map((kind) => [kind, kind])];
  options(form.elements.split, kinds('split'), '');
  options(form.elements.memory, kinds('memory_type').sort(), '');
  form.addEventListener('input', show);
  form.addEventListener('submit', (event) => event.preventDefault());
  find('clear').addEventListener('click', () => {
    form.reset();
    show();
    form.elements.words.focus();
  });
  show();
}
