// Fields for pins, constants and options of a task.
import { described } from './choose.js';
import { find, make } from './draw.js';

const unit = (item) => (item.unit ? ` ${item.unit}` : '');
const bounds = (item) => (item.low === null || item.low === undefined ? '' : `, ${item.low} to ${item.high ?? '…'}`);

function field(place, group, item, hint, placeholder) {
  const name = `${place.id}-${group}-${item.name}`;
  return make('label', { for: name },
    make('span', {}, item.name),
    make('input', { id: name, 'data-name': item.name, 'data-group': group, autocomplete: 'off', placeholder }),
    make('small', {}, hint));
}

function group(summary, note, fields) {
  if (fields.length === 0) return null;
  return make('details', {}, make('summary', {}, summary), note && make('p', { class: 'note' }, note),
    make('div', { class: 'values' }, ...fields));
}

function show(place, task) {
  const groups = [
    group('Pins: fixed values of random variables', 'Empty fields are random.',
      task.draws.map((draw) => field(place, 'pins', draw,
        `${draw.description}${bounds(draw)}${unit(draw)}${draw.width > 1 ? `; ${draw.width} numbers` : ''}`, 'random'))),
    group('Constants of the task', 'Changed constants make another task; rates do not apply to it.',
      task.changeable.map((one) => field(place, 'constants', one,
        `${one.description}${bounds(one)}${unit(one)}${one.names ? '; ' + one.names.join(', ') : ''}`,
        Array.isArray(one.value) ? one.value.join(', ') : String(one.value)))),
    group('Options of the task', null,
      task.options.map((one) => field(place, 'options', one, `${one.description}${bounds(one)}`, String(one.value)))),
  ];
  place.replaceChildren(make('details', {}, make('summary', {}, 'Change the task: pins, constants, options'),
    ...groups.filter(Boolean)));
}

// Shows the fields of a task in the element with that id, unless it shows them already.
export async function showFields(where, id) {
  const place = find(where);
  if (place.dataset.task === id) return;
  place.dataset.task = id;
  place.replaceChildren();
  const task = await described(id);
  if (place.dataset.task === id) show(place, task);
}

const value = (text) => (text !== '' && Number.isFinite(Number(text)) ? Number(text) : text);

// Values of those fields, by group; several values are separated by commas.
export function readValues(where) {
  const values = { pins: {}, constants: {}, options: {} };
  for (const input of find(where).querySelectorAll('input')) {
    const text = input.value.trim();
    if (text === '') continue;
    const parts = text.split(',').map((part) => value(part.trim()));
    values[input.dataset.group][input.dataset.name] = parts.length > 1 ? parts : parts[0];
  }
  return values;
}
