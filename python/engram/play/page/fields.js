// Fields for pins, constants and options of a task.
import { find, make } from './draw.js';

function field(group, item, hint, placeholder) {
  const name = `${group}-${item.name}`;
  return make('label', { for: name },
    make('span', {}, item.name),
    make('input', { id: name, 'data-name': item.name, 'data-group': group, autocomplete: 'off', placeholder }),
    make('small', {}, hint));
}

const unit = (item) => (item.unit ? ` ${item.unit}` : '');
const bounds = (item) => (item.low === null || item.low === undefined ? '' : `, ${item.low} to ${item.high ?? '…'}`);

export function showFields(task) {
  find('pins').replaceChildren(...task.draws.map((draw) => field('pins', draw,
    `${draw.description}${bounds(draw)}${unit(draw)}${draw.width > 1 ? `; ${draw.width} numbers` : ''}`, 'drawn')));
  find('constants').replaceChildren(...task.changeable.map((one) => field('constants', one,
    `${one.description}${bounds(one)}${unit(one)}${one.names ? '; ' + one.names.join(', ') : ''}`,
    Array.isArray(one.value) ? one.value.join(', ') : String(one.value))));
  find('options').replaceChildren(...task.options.map((one) => field('options', one,
    `${one.description}${bounds(one)}`, String(one.value))));
}

const value = (text) => (text !== '' && Number.isFinite(Number(text)) ? Number(text) : text);

// What stands in the fields, by group; several values are separated by commas.
export function readValues() {
  const values = { pins: {}, constants: {}, options: {} };
  for (const input of document.querySelectorAll('.values input')) {
    const text = input.value.trim();
    if (text === '') continue;
    const parts = text.split(',').map((part) => value(part.trim()));
    values[input.dataset.group][input.dataset.name] = parts.length > 1 ? parts : parts[0];
  }
  return values;
}
