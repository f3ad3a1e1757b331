// Episode that the user plays. Before its end, the server sends only pictures and step numbers.
import * as input from './input.js';
import * as question from './question.js';
import { described } from './choose.js';
import { current } from './current.js';
import { find, make, paint, percent, rates, seedIn } from './draw.js';
import { on, send } from './link.js';
import { readValues, showFields } from './fields.js';

const SLOW_BELOW = 120; // steps; shorter episodes start at a quarter of real time
const MOST_LATENCIES = 400;
const LATE = 200; // milliseconds from a key to its picture; people notice more

let id = null;
let horizon = 1;
let running = false;
let ended = true;
let abandoned = false; // another view has replaced the episode
let number = 0; // of the last input
let last = '';
let speedChosen = false;
let byName = false; // the player names answers, where a task has a list
const sentAt = new Map(); // times by input number
export const stats = { latencies: [], frames: [], dropped: 0, last: -1 };

// The view is shown: with a new episode if there is none of the chosen task.
export async function enter() {
  find('play-empty').hidden = current() !== null;
  find('play-table').hidden = current() === null;
  if (current() !== null && (current() !== id || abandoned)) await choose(current());
}

// The next time that the view is shown, a new episode begins.
export function renew() { abandoned = true; }

async function choose(task) {
  id = task;
  ended = true;
  showButtons();
  const description = await described(task);
  await showFields('play-values', task);
  if (id !== task) return;
  showChoices(description);
  if (!speedChosen) find('speed').value = description.horizon < SLOW_BELOW ? '0.25' : '1';
  fresh();
}

// Whether answers can be named is the task's; whether they are, the player's.
function showChoices(description) {
  const box = find('choices');
  box.disabled = description.choices === null;
  box.checked = byName && !box.disabled;
  find('by-name').title = box.disabled ? 'This task has no list of answers' : '';
}

export function setChoices(on) { byName = on; }

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
  send({ do: 'play', id, seed, choices: find('choices').checked, ...readValues('play-values') });
  sendSpeed();
}

function toggle() {
  if (ended) fresh();
  else send({ do: 'run', on: !running });
}

function step() {
  if (running || ended || question.isOpen()) return;
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
  find('step').disabled = running || ended || question.isOpen();
}

export function opened(message) {
  question.close();
  ended = false;
  abandoned = false;
  running = false;
  sentAt.clear();
  stats.latencies.length = 0;
  find('late').textContent = '';
  horizon = message.horizon;
  find('instruction').textContent = message.instruction;
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
    showLate();
  });
}

function showLate() {
  const sorted = [...stats.latencies].sort((a, b) => a - b);
  const late = sorted.length >= 5 && sorted[Math.floor(sorted.length / 2)] > LATE;
  find('late').textContent = late ? 'Pictures are late: this machine or the connection is slow.' : '';
}

export function ran(on) {
  if (ended) return;
  running = on;
  last = '';
  if (running) find('result').replaceChildren();
  if (running) act();
  showButtons();
}

// Another view has replaced the episode; if it was unfinished, a new one begins when this is shown.
export function leave() {
  question.close();
  if (ended) return;
  ended = true;
  abandoned = true;
  running = false;
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
  const heading = score.episodes === 0 ? 'No episode counted yet'
    : `${score.successes} of ${score.episodes} ${score.episodes === 1 ? 'episode' : 'episodes'}`;
  const rows = [['guessing', score.chance], ['without memory', score.sweep], ['you', score.rate], ['oracle', score.oracle]];
  const parts = [make('p', {}, make('strong', {}, heading), ' ', make('span', { class: 'beads', 'aria-hidden': 'true' }, beads))];
  parts.push(rates(rows));
  if (score.first_answers > 0) {
    parts.push(make('p', { class: 'note' }, `First answers right: ${score.first_right} of ${score.first_answers}; guessing: ${percent(score.answer_chance)}`));
  }
  const left = score.of - score.episodes;
  if (score.memory !== null) {
    parts.push(make('p', { class: 'note' }, `Memory score ${score.memory.toFixed(2)}: 0 is as good as without memory, 1 as the oracle.`));
  } else if (score.episodes > 0 && left > 0) {
    parts.push(make('p', { class: 'note' }, `${left} more ${left === 1 ? 'episode' : 'episodes'} until the rate says something.`));
  }
  parts.push(make('details', {}, make('summary', {}, 'What these are'),
    make('p', { class: 'note' }, 'Guessing (chance): plays well, and guesses the hidden thing once. Without memory (sweep): the best known policy that remembers nothing and tries everything. Oracle: is told what is hidden. Your last ten episodes count, each seed once.')));
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
  find('review').addEventListener('click', () => document.dispatchEvent(new CustomEvent('review')));
  find('speed').addEventListener('change', () => {
    speedChosen = true;
    sendSpeed();
  });
  document.addEventListener('visibilitychange', () => { if (document.hidden) pause(); });
  on('picture play', picture);
  on('ended', finished);
  question.begin();
  on('question', (message) => {
    question.open(message);
    showButtons();
  });
  on('chosen', () => {
    question.close();
    showButtons();
    find('stage').focus({ preventScroll: true });
  });
  find('choices').addEventListener('change', () => {
    byName = find('choices').checked;
    fresh();
  });
  on('saved', (message) => {
    find('save').disabled = true;
    find('result').append(make('p', {}, `Saved: ${message.file} (${message.episodes} in the folder)`));
  });
}
