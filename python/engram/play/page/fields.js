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
    group('Pins: what is drawn', 'What stands here is not drawn. Leave fields empty to have them drawn.',
      task.draws.map((draw) => field(place, 'pins', draw,
        `${draw.description}${bounds(draw)}${unit(draw)}${draw.width > 1 ? `; ${draw.width} numbers` : ''}`, 'drawn'))),
    group('Constants of the task', 'Another number makes another task; rates do not apply to it.',
      task.changeable.map((one) => field(place, 'constants', one,
        `${one.description}${bounds(one)}${unit(one)}${one.names ? '; ' + one.names.join(', ') : ''}`,
        Array.isArray(one.value) ? one.value.join(', ') : String(one.value)))),
    group('Options of the task', null,
      task.options.map((one) => field(place, 'options', one, `${one.description}${bounds(one)}`, String(one.value)))),
  ];
  place.replaceChildren(...groups.filter(Boolean));
}

// Shows the fields of a task under the element with that id, unless they are there.
export async function showFields(where, id) {
  const place = find(where);
  if (place.dataset.task === id) return;
  place.dataset.task = id;
  place.replaceChildren();
  const task = await described(id);
  if (place.dataset.task === id) show(place, task);
}

const value = (text) => (text !== '' && Number.isFinite(Number(text)) ? Number(text) : text);

// What stands in those fields, by group; several values are separated by commas.
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
