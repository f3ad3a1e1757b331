// Playback of an episode, of a policy or the user: forwards, backwards, picture by picture.
import { all } from './choose.js';
import { current, setCurrent } from './current.js';
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
let resultShown = false;
let asked = null; // the last request
let lost = null; // the request of an episode that another view has replaced

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
  if (wanted === playback.frames - 1) tell();
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

function showOnly(id) {
  for (const one of ['watch-empty', 'watch-building', 'playback']) find(one).hidden = one !== id;
  find('playback-instruction').hidden = id !== 'playback';
}

// The result is shown at the end, or on request.
function tell() {
  if (resultShown) return;
  resultShown = true;
  const { result, answered, success } = playback;
  const answer = result.first_answer_correct === null ? 'no answer'
    : result.first_answer_correct ? 'first answer right' : 'first answer wrong';
  const at = answered === null ? '' : ` in step ${answered}`;
  const notes = [
    playback.cut && `Only the first ${result.steps} of ${playback.horizon} steps are shown.`,
    playback.differs && 'It ended otherwise than in the folder: the policy is another one, or acts differently each time.',
  ];
  find('playback-result').replaceChildren(
    make('strong', { class: result.success ? 'good' : 'bad' }, result.success ? 'Success' : 'No success'),
    make('p', {}, `${playback.id}, seed ${playback.seed}`),
    make('p', {}, `${result.steps} steps, reward ${result.return.toFixed(2)}; ${answer}${at}` +
      (success.length ? `; success in step ${success[0]}` : '')),
    ...notes.filter(Boolean).map((note) => make('p', { class: 'note' }, note)));
}

export function opened(message) {
  playback = message;
  lost = null;
  requested = null;
  shown = -1;
  resultShown = false;
  setCurrent(message.id);
  enter();
  find('playback-instruction').textContent = message.instruction;
  find('playback-scrub').max = message.frames - 1;
  find('playback-result').replaceChildren(
    make('p', {}, `${message.id}, seed ${message.seed}`),
    make('p', { class: 'note' }, 'The result is shown at the end. ',
      make('button', { type: 'button', id: 'playback-tell', onclick: tell }, 'Show it now')));
  move = plots.show(find('plots'), message);
  showOnly('playback');
  go(0);
}

// The view is shown, with the chosen task; an episode of another one is put away.
export function enter() {
  if (current() !== null) find('watch-task').value = current();
  showFields('watch-values', find('watch-task').value);
  const shown = playback?.id ?? lost?.id;
  if (shown && shown !== find('watch-task').value) {
    stop();
    playback = lost = null;
    showOnly('watch-empty');
  }
  if (lost) ask(lost.request);
}

// Remembers what was asked for. The last episode that was played may be another one soon.
function keep(id, more) {
  if (asked && asked.do !== 'review') lost = { id, request: asked.do === 'watch' ? { ...asked, ...more } : asked };
}

// The view is left: what is still played in the background is asked for again when it is shown.
export function pause() {
  stop();
  if (find('watch-building').hidden) return;
  send({ do: 'stop' });
  keep(current());
  showOnly(playback ? 'playback' : 'watch-empty');
}

// Another view has replaced the episode; it is asked for again when this one is shown.
export function leave() {
  if (playback) keep(playback.id, { seed: playback.seed });
  stop();
  playback = null;
  showOnly('watch-empty');
}

function ask(message) {
  stop();
  asked = message;
  lost = null;
  wait('Playing …');
  send(message);
}

export function watch() { submit(); }

// The episode that the user has played.
export function review() {
  location.hash = '#watch';
  ask({ do: 'review' });
}

function wait(text) {
  find('watch-building').textContent = text;
  showOnly('watch-building');
}

export function building(message) {
  wait(`Playing: step ${message.steps} of ${message.most} …`);
}

// The request has failed, or another view was opened: what was shown is shown again.
export function failed() {
  if (!find('watch-building').hidden) showOnly(playback ? 'playback' : 'watch-empty');
}

function submit() {
  const seed = seedIn(find('watch-seed'));
  if (seed === undefined) {
    find('watch-seed').reportValidity();
    return;
  }
  const id = find('watch-task').value;
  setCurrent(id);
  ask({ do: 'watch', id, source: find('watch-source').value, seed, ...readValues('watch-values') });
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
  find('watch-task').addEventListener('change', (event) => {
    setCurrent(event.target.value);
    enter();
  });
  find('watch-form').addEventListener('submit', (event) => {
    event.preventDefault();
    submit();
  });
  find('stored-form').addEventListener('submit', (event) => {
    event.preventDefault();
    const number = (id) => Number(find(id).value);
    ask({ do: 'stored', folder: number('stored-folder'), task: number('stored-task'), episode: number('stored-episode') });
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
