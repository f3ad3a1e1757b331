// Curves of an episode, one picture per column, with a cursor.
const WIDTH = 640;
const HEIGHT = 90;
const BAND = 22;
const NS = 'http://www.w3.org/2000/svg';

function svg(tag, attributes, text) {
  const element = document.createElementNS(NS, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  if (text !== undefined) element.textContent = text;
  return element;
}

function line(values, low, high) {
  const last = Math.max(1, values.length - 1);
  let path = '';
  let pen = 'M';
  values.forEach((value, i) => {
    if (value === null) {
      pen = 'M';
      return;
    }
    const y = HEIGHT - 6 - ((value - low) / (high - low)) * (HEIGHT - 12);
    path += `${pen}${((i / last) * WIDTH).toFixed(1)} ${y.toFixed(1)}`;
    pen = 'L';
  });
  return path;
}

function plot(title, series, height) {
  const figure = document.createElement('figure');
  const caption = document.createElement('figcaption');
  const words = document.createElement('strong');
  words.textContent = title;
  caption.append(words);
  const image = svg('svg', { viewBox: `0 0 ${WIDTH} ${height}`, role: 'img', 'aria-label': title, preserveAspectRatio: 'none' });
  figure.append(caption, image);
  for (const [name, kind] of series) {
    const item = document.createElement('span');
    item.append(`${kind ? { a: '— ', b: '– – ', c: '· · ' }[kind] : ''}${name}`);
    caption.append(item);
  }
  return [figure, image];
}

const DASHES = { a: '', b: '7 4', c: '2 3' };

function curves(title, series, bounds) {
  const all = series.flatMap(([, values]) => values.filter((value) => value !== null));
  let [low, high] = bounds ?? [1e9, -1e9];
  for (const value of all) [low, high] = [Math.min(low, value), Math.max(high, value)];
  if (high - low < 1e-6) [low, high] = [low - 0.5, high + 0.5];
  const kinds = ['a', 'b', 'c'];
  const range = ` (${low.toFixed(2)} to ${high.toFixed(2)})`;
  const [figure, image] = plot(title + range, series.length > 1 ? series.map(([name], i) => [name, kinds[i]]) : [], HEIGHT);
  image.append(svg('line', { class: 'axis', x1: 0, x2: WIDTH, y1: HEIGHT - 1, y2: HEIGHT - 1 }));
  series.forEach(([, values], i) => image.append(svg('path', { class: kinds[i], d: line(values, low, high), 'stroke-dasharray': DASHES[kinds[i]] })));
  return [figure, image, HEIGHT];
}

function band(names, track) {
  const [figure, image] = plot('Phase', [], BAND);
  figure.querySelector('figcaption').append(...names.map((name, i) => {
    const item = document.createElement('span');
    item.innerHTML = `<svg class="key" width="12" height="12" aria-hidden="true"><rect width="12" height="12" class="phase${i % 4}"/></svg> `;
    item.append(name);
    return item;
  }));
  const width = WIDTH / Math.max(1, track.length - 1);
  for (let start = 0; start < track.length;) {
    let end = start;
    while (end < track.length && track[end] === track[start]) ++end;
    if (track[start] !== null) {
      image.append(svg('rect', { class: `phase${track[start] % 4}`, x: start * width, width: (end - start) * width, y: 0, height: BAND }));
    }
    start = end;
  }
  return [figure, image, BAND];
}

// Fills the place; returns a function that moves the cursors to a picture.
export function show(place, playback) {
  const rows = [
    band(playback.phases, playback.phase),
    curves('Reward of the step', [['reward', playback.reward]]),
    curves('Tool, m', ['x', 'y', 'z'].map((name, i) => [name, playback.tcp.map((row) => row[i])])),
    curves('Gripper, m', [['opening', playback.gripper]], [0, 0.08]),
  ];
  const cursors = rows.map(([, image, height]) => {
    const cursor = svg('line', { class: 'cursor', y1: 0, y2: height, 'vector-effect': 'non-scaling-stroke' });
    image.append(cursor);
    return cursor;
  });
  place.replaceChildren(...rows.map(([figure]) => figure));
  return (frame) => {
    const x = (frame / Math.max(1, playback.frames - 1)) * WIDTH;
    for (const cursor of cursors) {
      cursor.setAttribute('x1', x);
      cursor.setAttribute('x2', x);
    }
  };
}
