// An episode of somebody else's, or the one just played: forwards, backwards, picture by picture.
import { all } from './choose.js';
import { find, make, options, paint, seedIn } from './draw.js';
import { readValues, showFields } from './fields.js';
import { on, say } from './link.js';
import * as plots from './plots.js';

const STEP = 50; // milliseconds

let film = null;
let wanted = 0;
let asked = null; // the picture that is on its way
let shown = -1;
let running = false;
let due = 0;
let move = () => {};
let folders = [];
let waits = false; // for an episode to be played

// One picture is on its way at a time; then the newest wish is the next.
function ask() {
  if (!film || asked !== null || wanted === shown) return;
  asked = wanted;
  say({ do: 'frame', n: wanted });
}

function go(frame) {
  if (!film) return;
  wanted = Math.max(0, Math.min(film.frames - 1, frame));
  find('film-scrub').value = wanted;
  tell();
  move(wanted);
  ask();
}

function tell() {
  const phase = film.phase[wanted];
  const reward = film.reward[wanted];
  const [x, y, z] = film.tcp[wanted];
  const words = [
    `step ${wanted} of ${film.frames - 1}`,
    phase === null ? null : `phase ${film.phases[phase]}`,
    reward === null ? null : `reward ${reward.toFixed(3)}`,
    `tool ${x.toFixed(3)}, ${y.toFixed(3)}, ${z.toFixed(3)}`,
    `gripper ${film.gripper[wanted].toFixed(3)}`,
  ];
  const text = words.filter(Boolean).join('; ');
  find('film-told').textContent = text;
  find('film-scrub').setAttribute('aria-valuetext', text);
}

export function stop() {
  running = false;
  find('film-run').textContent = 'Run';
}

function run() {
  if (!film) return;
  running = !running;
  find('film-run').textContent = running ? 'Pause' : 'Run';
  if (running && wanted === film.frames - 1) go(0);
  due = performance.now();
  if (running) requestAnimationFrame(advance);
}

function advance(now) {
  if (!running) return;
  const step = STEP / Number(find('film-speed').value);
  if (now - due > 500) due = now;
  const steps = Math.floor((now - due) / step);
  if (steps > 0) {
    due += steps * step;
    go(wanted + steps);
    if (wanted === film.frames - 1) stop();
  }
  requestAnimationFrame(advance);
}

async function picture(header, files) {
  await Promise.all([paint(find('film-human'), files[0]), paint(find('film-sensors'), files[1])]);
  shown = header.n;
  find('film-human').dataset.frame = shown;
  asked = null;
  ask();
}

export function opened(message) {
  waits = false;
  film = message;
  asked = null;
  shown = -1;
  location.hash = '#watch';
  showTask(message.id);
  find('film-instruction').textContent = message.instruction;
  find('task-shown').textContent = message.id;
  for (const id of ['film-back', 'film-run', 'film-on', 'film-scrub']) find(id).disabled = false;
  find('film-scrub').max = message.frames - 1;
  const result = message.result;
  const answer = result.first_answer_correct === null ? 'no answer'
    : result.first_answer_correct ? 'first answer right' : 'first answer wrong';
  const at = message.answered === null ? '' : ` in step ${message.answered}`;
  find('film-result').replaceChildren(
    make('strong', { class: result.success ? 'good' : 'bad' }, result.success ? 'Success' : 'No success'),
    make('p', {}, `${message.id}, seed ${message.seed}`),
    make('p', {}, `${result.steps} steps, reward ${result.return.toFixed(2)}; ${answer}${at}` +
      (message.success.length ? `; success in step ${message.success[0]}` : '')));
  move = plots.show(find('plots'), message);
  find('watch-head').focus?.();
  go(0);
}

export function enter() { showFields('watch-values', find('watch-task').value); }

function showTask(id) {
  find('watch-task').value = id;
  enter();
}

export function watch(id) {
  showTask(id);
  submit();
}

// Nothing comes of what was asked for.
export function failed() {
  if (waits) find('film-result').textContent = '';
  waits = false;
}

function submit() {
  const seed = seedIn(find('watch-seed'));
  if (seed === undefined) {
    find('watch-seed').reportValidity();
    return;
  }
  stop();
  find('film-result').textContent = 'Playing …';
  waits = true;
  const id = find('watch-task').value;
  say({ do: 'watch', id, source: find('watch-source').value, seed, ...readValues('watch-values') });
}

function showStored() {
  const folder = folders[Number(find('stored-folder').value)];
  options(find('stored-task'), folder.tasks.map((task, i) => [i, task.id]));
  showEpisodes();
}

function showEpisodes() {
  const task = folders[Number(find('stored-folder').value)].tasks[Number(find('stored-task').value)];
  options(find('stored-episode'), task.episodes.map((one, i) => [i, `${i}: seed ${one.seed}, ${one.steps} steps, ${one.success ? 'success' : 'no success'}`]));
}

export function sources(message) {
  folders = message.folders;
  for (const id of ['watch-source', 'wall-source']) {
    options(find(id), message.sources.map((name) => [name, name === 'process' ? "the policy's process" : name]));
  }
  find('stored-form').hidden = folders.length === 0;
  if (folders.length) {
    options(find('stored-folder'), folders.map((folder, i) => [i, `${folder.name}: ${folder.kind}`]));
    showStored();
  }
}

export function begin() {
  options(find('watch-task'), all().map((task) => [task.id, task.id]));
  find('watch-task').addEventListener('change', enter);
  find('watch-form').addEventListener('submit', (event) => {
    event.preventDefault();
    submit();
  });
  find('stored-form').addEventListener('submit', (event) => {
    event.preventDefault();
    stop();
    const number = (id) => Number(find(id).value);
    say({ do: 'stored', folder: number('stored-folder'), task: number('stored-task'), episode: number('stored-episode') });
  });
  find('stored-folder').addEventListener('change', showStored);
  find('stored-task').addEventListener('change', showEpisodes);
  find('film-scrub').addEventListener('input', (event) => {
    stop();
    go(Number(event.target.value));
  });
  find('film-back').addEventListener('click', () => { stop(); go(wanted - 1); });
  find('film-on').addEventListener('click', () => { stop(); go(wanted + 1); });
  find('film-run').addEventListener('click', run);
  on('picture film', picture);
}
