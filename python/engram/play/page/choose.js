// All tasks, by family; pictures and rates are fetched when their card comes into view.
import { find, make, options, rates } from './draw.js';

let tasks = [];
const details = new Map();

export async function described(id) {
  if (!details.has(id)) {
    details.set(id, fetch(`task/${id}.json`).then((answer) => {
      if (!answer.ok) throw new Error(`task ${id}: ${answer.status}`);
      return answer.json();
    }));
  }
  return details.get(id);
}

export const all = () => tasks;

const watcher = new IntersectionObserver((entries) => {
  for (const entry of entries) {
    if (!entry.isIntersecting) continue;
    watcher.unobserve(entry.target);
    fill(entry.target);
  }
}, { rootMargin: '100px' });

async function fill(card) {
  const task = await described(card.dataset.id);
  const image = card.querySelector('img');
  image.src = `picture/${task.id}.jpg`;
  const ceilings = task.ceilings ?? {};
  card.querySelector('.phases').textContent = task.phases.map((phase) => phase.name).join(' → ');
  card.querySelector('.card-rates').replaceChildren(rates([
    ['chance', task.chance],
    ['sweep', ceilings.sweep?.success_once],
    ['oracle', ceilings.oracle?.success_once],
  ]));
}

function card(task) {
  const go = (view) => () => {
    document.dispatchEvent(new CustomEvent('chosen', { detail: { id: task.id, view } }));
  };
  const seconds = task.horizon / 20;
  const element = make('article', { class: 'card', 'data-id': task.id, 'aria-label': task.id },
    make('img', { alt: `A moment of ${task.id}`, width: 320, height: 240 }),
    make('div', {},
      make('h4', {}, task.id),
      make('p', { class: 'instruction-text' }, task.instruction),
      make('p', {}, `${task.split}, ${task.memory_type}; ${task.horizon} steps, ${seconds} s`),
      make('p', { class: 'phases' }, '…'),
      make('span', { class: 'card-rates' }),
      make('span', { class: 'buttons' },
        make('button', { type: 'button', 'aria-label': `Play ${task.id}`, onclick: go('play') }, 'Play'),
        make('button', { type: 'button', 'aria-label': `Watch ${task.id}`, onclick: go('watch') }, 'Watch'))));
  watcher.observe(element);
  return element;
}

function show() {
  const form = find('filter').elements;
  const words = form.words.value.toLowerCase().split(/\s+/).filter(Boolean);
  const shown = tasks.filter((task) => {
    const text = `${task.id} ${task.family} ${task.split} ${task.memory_type} ${task.instruction}`.toLowerCase();
    return words.every((word) => text.includes(word))
      && (!form.split.value || task.split === form.split.value)
      && (!form.memory.value || task.memory_type === form.memory.value);
  });
  const families = new Map();
  for (const task of shown) {
    if (!families.has(task.family)) families.set(task.family, []);
    families.get(task.family).push(task);
  }
  watcher.disconnect();
  find('families').replaceChildren(...[...families].map(([family, members]) =>
    make('section', { 'aria-label': family },
      make('h3', {}, family),
      make('div', { class: 'cards' }, ...members.map(card)))));
  find('count').textContent = `${shown.length} of ${tasks.length} tasks`;
}

export async function begin() {
  tasks = await (await fetch('tasks.json')).json();
  const form = find('filter');
  const kinds = (key) => [['', 'all'], ...[...new Set(tasks.map((task) => task[key]))].map((kind) => [kind, kind])];
  options(form.elements.split, kinds('split'), '');
  options(form.elements.memory, kinds('memory_type'), '');
  form.addEventListener('input', show);
  form.addEventListener('submit', (event) => event.preventDefault());
  show();
}
