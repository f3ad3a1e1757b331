// Small helpers for elements and pictures.
export const find = (id) => document.getElementById(id);

export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, '');
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

export function options(select, values, chosen) {
  select.replaceChildren(...values.map(([value, words]) => make('option', { value, selected: value === chosen }, words)));
}

// Draws a file into a canvas; resolves when it is drawn.
export async function paint(canvas, file) {
  const image = await createImageBitmap(file);
  if (canvas.width !== image.width || canvas.height !== image.height) {
    canvas.width = image.width;
    canvas.height = image.height;
  }
  canvas.getContext('2d', { alpha: false }).drawImage(image, 0, 0);
  image.close();
}

export const percent = (rate) => (rate === null || rate === undefined ? '–' : Math.round(100 * rate) + ' %');

// Success rates, one below the other.
export function rates(rows) {
  const list = make('dl', { class: 'rates' });
  for (const [name, rate] of rows) {
    const bar = make('span', { class: 'rate', role: 'img', 'aria-label': `${name}: ${percent(rate)}` }, make('i'));
    bar.firstChild.style.width = `${100 * (rate ?? 0)}%`;
    list.append(make('dt', {}, name), make('dd', {}, bar), make('dd', {}, percent(rate)));
  }
  return list;
}

// Value of a field for a seed; null if it is empty, undefined if it is no seed.
export function seedIn(input) {
  if (input.value.trim() === '') return null;
  return input.validity.valid ? input.value.trim() : undefined;
}
