// Playback of an episode, of a policy or the user: forwards, backwards, picture by picture.
import { all } from './choose.js';
import { find, make, options, paint, seedIn } from './draw.js';
import { readValues, showFields } from './fields.js';
import { on, send } from './link.js';
import * as plots from './plots.js';

const STEP = 50; // milliseconds

let playback = null;
let wanted = 0;
let requested = null; // number of the requested picture
let shown = -1;
let running = false;
let due = 0;
let move = () => {};
let folders = [];
let waiting = false; // for an episode

// Requests one picture at a time; then the newest wanted one.
function request() {
  if (!playback || requested !== null || wanted === shown) return;
  requested = wanted;
  send({ do: 'frame', n: wanted });
}

function go(frame) {
  if (!playback) return;
  wanted = Math.max(0, Math.min(playback.frames - 1, frame));
  find('playback-scrub').value = wanted;
  showStatus();
  move(wanted);
  request();
}

function showStatus() {
  const phase = playback.phase[wanted];
  const reward = playback.reward[wanted];
  const [x, y, z] = playback.tcp[wanted];
  const parts = [
    `step ${wanted} of ${playback.frames - 1}`,
    phase === null ? null : `phase ${playback.phases[phase]}`,
    reward === null ? null : `reward ${reward.toFixed(3)}`,
    `tool ${x.toFixed(3)}, ${y.toFixed(3)}, ${z.toFixed(3)}`,
    `gripper ${playback.gripper[wanted].toFixed(3)}`,
  ];
  const text = parts.filter(Boolean).join('; ');
  find('playback-status').textContent = text;
  find('playback-scrub').setAttribute('aria-valuetext', text);
}

export function stop() {
  running = false;
  find('playback-run').textContent = 'Run';
}

function run() {
  if (!playback) return;
  running = !running;
  find('playback-run').textContent = running ? 'Pause' : 'Run';
  if (running && wanted === playback.frames - 1) go(0);
  due = performance.now();
  if (running) requestAnimationFrame(advance);
}

function advance(now) {
  if (!running) return;
  const step = STEP / Number(find('playback-speed').value);
  if (now - due > 500) due = now;
  const steps = Math.floor((now - due) / step);
  if (steps > 0) {
    due += steps * step;
    go(wanted + steps);
    if (wanted === playback.frames - 1) stop();
  }
  requestAnimationFrame(advance);
}

async function picture(header, files) {
  await Promise.all([paint(find('playback-human'), files[0]), paint(find('playback-sensors'), files[1])]);
  shown = header.n;
  find('playback-human').dataset.frame = shown;
  requested = null;
  request();
}

export function opened(message) {
  waiting = false;
  playback = message;
  requested = null;
  shown = -1;
  location.hash = '#watch';
  showTask(message.id);
  find('playback-instruction').textContent = message.instruction;
  find('task-shown').textContent = message.id;
  for (const id of ['playback-back', 'playback-run', 'playback-on', 'playback-scrub']) find(id).disabled = false;
  find('playback-scrub').max = message.frames - 1;
  const result = message.result;
  const answer = result.first_answer_correct === null ? 'no answer'
    : result.first_answer_correct ? 'first answer right' : 'first answer wrong';
  const at = message.answered === null ? '' : ` in step ${message.answered}`;
  find('playback-result').replaceChildren(
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

// The request has failed.
export function failed() {
  if (waiting) find('playback-result').textContent = '';
  waiting = false;
}

function submit() {
  const seed = seedIn(find('watch-seed'));
  if (seed === undefined) {
    find('watch-seed').reportValidity();
    return;
  }
  stop();
  find('playback-result').textContent = 'Playing …';
  waiting = true;
  const id = find('watch-task').value;
  send({ do: 'watch', id, source: find('watch-source').value, seed, ...readValues('watch-values') });
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
  for (const id of ['watch-source', 'grid-source']) {
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
    send({ do: 'stored', folder: number('stored-folder'), task: number('stored-task'), episode: number('stored-episode') });
  });
  find('stored-folder').addEventListener('change', showStored);
  find('stored-task').addEventListener('change', showEpisodes);
  find('playback-scrub').addEventListener('input', (event) => {
    stop();
    go(Number(event.target.value));
  });
  find('playback-back').addEventListener('click', () => { stop(); go(wanted - 1); });
  find('playback-on').addEventListener('click', () => { stop(); go(wanted + 1); });
  find('playback-run').addEventListener('click', run);
  on('picture playback', picture);
}
