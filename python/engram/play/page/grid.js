// Grid of sixteen environments in one picture; frames mark success and end.
import { all } from './choose.js';
import { current, setCurrent } from './current.js';
import { find, options, paint, seedIn } from './draw.js';
import { readValues, showFields } from './fields.js';
import { on, send } from './link.js';

let columns = 4;
let running = false;
let asked = false; // the server plays for this view, or will
let open = false; // and has said so

export const stats = { frames: 0 };

function submit() {
  const seed = seedIn(find('grid-seed'));
  if (seed === undefined) {
    find('grid-seed').reportValidity();
    return;
  }
  const id = find('grid-task').value;
  setCurrent(id);
  asked = true;
  send({ do: 'grid', id, source: find('grid-source').value, seed, ...readValues('grid-values') });
  send({ do: 'speed', of: 1, turns: false });
  send({ do: 'run', on: true });
}

function showView(on) {
  open = on;
  find('grid-view').hidden = !on;
  find('grid-empty').hidden = on;
  find('grid-state').hidden = !on;
  if (!on) find('grid-status').textContent = '';
}

// The view is shown, with the chosen task.
export function enter() {
  if (current() !== null) find('grid-task').value = current();
  showFields('grid-values', find('grid-task').value);
}

export function opened() { showView(asked); }

// The request has failed; what was there before goes on.
export function failed() { asked = open; }

// Another view is shown: nothing more is played for this one.
export function leave() {
  if (asked) send({ do: 'leave' });
  asked = false;
  showView(false);
}

async function picture(header, files) {
  send({ do: 'seen', n: 0 });
  if (!open) return;
  const canvas = find('grid-view');
  await paint(canvas, files[0]);
  const context = canvas.getContext('2d', { alpha: false });
  const width = canvas.width / columns;
  const height = canvas.height / (header.success.length / columns);
  header.success.forEach((success, i) => {
    if (!success && !header.ended[i]) return;
    context.strokeStyle = success ? '#35d07f' : '#ff6b5e';
    context.lineWidth = 5;
    context.strokeRect((i % columns) * width + 3, Math.floor(i / columns) * height + 3, width - 6, height - 6);
  });
  const right = header.success.filter(Boolean).length;
  const before = header.played ? `; before: ${header.succeeded} of ${header.played}` : '';
  find('grid-status').textContent = `step ${header.elapsed}, seeds from ${header.seed}: ${right} of ${header.success.length} have succeeded${before}`;
  ++stats.frames;
}

export function begin() {
  options(find('grid-task'), all().map((task) => [task.id, task.id]));
  find('grid-task').addEventListener('change', (event) => {
    setCurrent(event.target.value);
    leave();
    enter();
  });
  find('grid-form').addEventListener('submit', (event) => {
    event.preventDefault();
    submit();
  });
  find('grid-run').addEventListener('click', () => send({ do: 'run', on: !running }));
  on('picture grid', picture);
}

export function setRunning(on) {
  running = on;
  find('grid-run').textContent = on ? 'Pause' : 'Go on';
}

export function setColumns(count) { columns = count; }
