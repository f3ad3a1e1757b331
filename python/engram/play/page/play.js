// Episode that the user plays. Before its end, the server sends only pictures and step numbers.
import * as input from './input.js';
import { described } from './choose.js';
import { find, make, paint, percent, rates, seedIn } from './draw.js';
import { on, send } from './link.js';
import { readValues, showFields } from './fields.js';

const SLOW_BELOW = 120; // steps; shorter episodes start at a quarter of real time
const MOST_LATENCIES = 400;

let id = null;
let horizon = 1;
let running = false;
let ended = true;
let number = 0; // of the last input
let last = '';
let speedChosen = false;
const sentAt = new Map(); // times by input number
export const stats = { latencies: [], frames: [], dropped: 0, last: -1 };

export const playing = () => id;

export async function choose(task) {
  id = task;
  const description = await described(task);
  await showFields('play-values', task);
  if (!speedChosen) find('speed').value = description.horizon < SLOW_BELOW ? '0.25' : '1';
  fresh();
}

export function pause() {
  if (running) send({ do: 'run', on: false });
}

function sendSpeed() {
  const value = find('speed').value;
  send({ do: 'speed', of: value === 'turns' ? 1 : Number(value), turns: value === 'turns' });
}

function fresh() {
  if (!id) return;
  const seed = seedIn(find('seed'));
  if (seed === undefined) {
    find('seed').reportValidity();
    return;
  }
  last = '';
  send({ do: 'play', id, seed, ...readValues('play-values') });
  sendSpeed();
}

function toggle() {
  if (ended) fresh();
  else send({ do: 'run', on: !running });
}

function step() {
  if (running || ended) return;
  const { a } = input.action();
  send({ do: 'step', a, n: ++number });
}

function act() {
  const now = input.action();
  const text = JSON.stringify(now);
  if (text === last || !id || ended) return;
  last = text;
  if (running) sentAt.set(++number, performance.now());
  else ++number;
  send({ do: 'act', ...now, n: number });
}

function showButtons() {
  find('run').textContent = ended ? 'New episode' : running ? 'Pause' : find('clock').dataset.step === '0' ? 'Start' : 'Go on';
  find('run').disabled = !id;
  find('again').hidden = ended;
  find('again').disabled = !id;
  find('step').disabled = running || ended;
}

function opened(message) {
  ended = false;
  running = false;
  sentAt.clear();
  horizon = message.horizon;
  find('instruction').textContent = message.instruction;
  find('task-shown').textContent = message.id;
  find('result').replaceChildren(make('p', { class: 'note' }, 'Look at the scene, then press Start, or Enter in the picture.'));
  find('after').hidden = true;
  showScore(message.score);
  showClock(0);
  showButtons();
  find('stage').focus({ preventScroll: true });
}

function showClock(now) {
  find('clock').dataset.step = now;
  find('clock').textContent = `step ${now} of ${horizon}`;
  find('time').max = horizon;
  find('time').value = now;
}

async function picture(header, files) {
  send({ do: 'seen', n: header.n });
  await Promise.all([paint(find('human'), files[0]), paint(find('sensors'), files[1])]);
  showClock(header.n);
  if (header.n === 1) showButtons();
  requestAnimationFrame(() => {
    const now = performance.now();
    stats.frames.push(now);
    if (stats.frames.length > 4000) stats.frames.splice(0, 2000);
    stats.last = header.n;
    for (const [sent, when] of sentAt) {
      if (sent > header.input) continue;
      sentAt.delete(sent);
      stats.latencies.push(now - when);
    }
    if (stats.latencies.length > MOST_LATENCIES) stats.latencies.splice(0, stats.latencies.length - MOST_LATENCIES);
    showLatency();
  });
}

function showLatency() {
  const sorted = [...stats.latencies].sort((a, b) => a - b);
  if (sorted.length < 5) return;
  const at = (share) => Math.round(sorted[Math.floor(share * (sorted.length - 1))]);
  find('latency').textContent = `key to picture ${at(0.5)} ms, ${at(0.95)} ms`;
}

export function ran(on) {
  if (ended) return;
  running = on;
  last = '';
  if (running) act();
  showButtons();
}

// Another view is shown; an unfinished episode is abandoned.
export function leave() {
  if (ended) return;
  ended = true;
  running = false;
  find('result').replaceChildren(make('p', { class: 'note' }, 'The episode was abandoned.'));
  showButtons();
}

function finished(message) {
  ended = true;
  running = false;
  input.release();
  const outcome = message.success ? ['good', 'Success'] : message.failed ? ['bad', 'Failed'] : ['bad', 'Time is over'];
  const answer = message.answered === null ? 'The task has no single answer.'
    : !message.answered ? 'No answer was given.'
      : message.first_answer_correct ? 'The first answer was right.' : 'The first answer was wrong.';
  find('result').replaceChildren(
    make('strong', { class: outcome[0] }, outcome[1]),
    make('p', {}, answer),
    make('p', {}, `${message.steps} steps, reward ${message.return.toFixed(2)}, seed ${message.seed}`));
  if (!message.counted) {
    find('result').append(make('p', { class: 'note' }, 'It does not count: its seed was played before, or the task was changed.'));
  }
  find('after').hidden = false;
  find('save').disabled = !message.savable;
  find('save').title = message.savable ? '' : 'Demonstrations are successes in the unchanged task';
  showScore(message.score);
  showButtons();
  find('run').focus({ preventScroll: true });
}

function showScore(score) {
  const beads = score.results.map((right) => (right ? '●' : '○')).join('');
  const heading = score.episodes === 0 ? `Score of ${score.of} episodes: none yet`
    : `${score.successes} of ${score.episodes} episodes`;
  const rows = [['chance', score.chance], ['sweep', score.sweep], ['you', score.rate], ['oracle', score.oracle]];
  const parts = [make('p', {}, make('strong', {}, heading), ' ', make('span', { class: 'beads', 'aria-hidden': 'true' }, beads))];
  parts.push(rates(rows));
  if (score.first_answers > 0) {
    parts.push(make('p', { class: 'note' }, `first answers right: ${score.first_right} of ${score.first_answers}; guessing: ${percent(score.answer_chance)}`));
  }
  if (score.memory !== null) {
    const done = score.episodes >= score.of ? '' : `, preliminary until ${score.of} episodes`;
    parts.push(make('p', { class: 'note' }, `memory score ${score.memory.toFixed(2)} (0: sweep, no memory; 1: oracle)${done}`));
  }
  find('score').replaceChildren(...parts);
}

export function begin() {
  input.begin({
    Enter: toggle,
    KeyN: fresh,
    Period: step,
    KeyH: () => { find('keys').open = !find('keys').open; },
  }, act);
  find('run').addEventListener('click', () => {
    toggle();
    find('stage').focus({ preventScroll: true });
  });
  find('again').addEventListener('click', fresh);
  find('step').addEventListener('click', step);
  find('save').addEventListener('click', () => send({ do: 'save' }));
  find('review').addEventListener('click', () => send({ do: 'review' }));
  find('speed').addEventListener('change', () => {
    speedChosen = true;
    sendSpeed();
  });
  document.addEventListener('visibilitychange', () => { if (document.hidden) pause(); });
  on('opened', opened);
  on('picture play', picture);
  on('ended', finished);
  on('saved', (message) => {
    find('save').disabled = true;
    find('result').append(make('p', {}, `Saved: ${message.file} (${message.episodes} in the folder)`));
  });
}
