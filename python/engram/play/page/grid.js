// Sixteen environments in one picture; frames tell how each of them goes.
import { all } from './choose.js';
import { find, options, paint, seedIn } from './draw.js';
import { readValues, showFields } from './fields.js';
import { on, say } from './link.js';

let columns = 4;
let running = false;

export const stats = { frames: 0 };

function submit() {
  const seed = seedIn(find('wall-seed'));
  if (seed === undefined) {
    find('wall-seed').reportValidity();
    return;
  }
  const id = find('wall-task').value;
  say({ do: 'wall', id, source: find('wall-source').value, seed, ...readValues('wall-values') });
  say({ do: 'speed', of: 1, turns: false });
  say({ do: 'run', on: true });
}

export function enter() { showFields('wall-values', find('wall-task').value); }

export function choose(id) { find('wall-task').value = id; }

async function picture(header, files) {
  say({ do: 'seen', n: 0 });
  const canvas = find('wall-view');
  await paint(canvas, files[0]);
  const context = canvas.getContext('2d', { alpha: false });
  const width = canvas.width / columns;
  const height = canvas.height / (header.success.length / columns);
  header.success.forEach((success, i) => {
    if (!success && !header.over[i]) return;
    context.strokeStyle = success ? '#35d07f' : '#ff6b5e';
    context.lineWidth = 5;
    context.strokeRect((i % columns) * width + 3, Math.floor(i / columns) * height + 3, width - 6, height - 6);
  });
  const right = header.success.filter(Boolean).length;
  const before = header.played ? `; before: ${header.succeeded} of ${header.played}` : '';
  find('wall-told').textContent = `step ${header.elapsed}, seeds from ${header.seed}: ${right} of ${header.success.length} have succeeded${before}`;
  ++stats.frames;
}

export function begin() {
  options(find('wall-task'), all().map((task) => [task.id, task.id]));
  find('wall-task').addEventListener('change', enter);
  find('wall-form').addEventListener('submit', (event) => {
    event.preventDefault();
    submit();
  });
  find('wall-run').addEventListener('click', () => say({ do: 'run', on: !running }));
  on('picture wall', picture);
}

export function setRunning(on) {
  running = on;
  find('wall-run').disabled = false;
  find('wall-run').textContent = on ? 'Pause' : 'Go on';
}

export function setColumns(count) { columns = count; }
