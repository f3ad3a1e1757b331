// Keys, mouse, touch and gamepad become an action: 3 numbers of translation, 3 of rotation, gripper.
import { find, make } from './draw.js';

// Directions of the human view over the table: away from the viewer, and to the right.
const AWAY = [-0.63, -0.77];
const RIGHT = [-0.77, 0.63];
// right, away, up, then turns about z, y and x; a positive number turns the hand the negative way.
const KEYS = {
  KeyW: [1, 1], ArrowUp: [1, 1], KeyS: [1, -1], ArrowDown: [1, -1],
  KeyD: [0, 1], ArrowRight: [0, 1], KeyA: [0, -1], ArrowLeft: [0, -1],
  KeyR: [2, 1], PageUp: [2, 1], KeyF: [2, -1], PageDown: [2, -1],
  KeyJ: [3, -1], KeyL: [3, 1], KeyI: [4, -1], KeyK: [4, 1], KeyU: [5, -1], KeyO: [5, 1],
};
const PAD = [
  ['↺', 'Turn left', 'KeyJ'], ['↑', 'Away', 'KeyW'], ['↻', 'Turn right', 'KeyL'], ['⤒', 'Up', 'KeyR'], ['⤸', 'Tip forwards', 'KeyI'], ['⤹', 'Tip backwards', 'KeyK'],
  ['←', 'Left', 'KeyA'], ['↓', 'Near', 'KeyS'], ['→', 'Right', 'KeyD'], ['⤓', 'Down', 'KeyF'], ['⇄', 'Gripper', 'Space'], ['…', 'Let time pass', 'KeyT'],
];
const DRAG = 90; // pixels of a drag at full strength
const WHEEL = 120; // milliseconds that a turn of the wheel lasts
const DEAD = 0.15; // of a stick

const held = new Set();
let open = true;
let drag = null;
let wheel = 0;
let wheelEnds = 0;
let sticks = [0, 0, 0, 0, 0, 0];
let changed = () => {};

export function action() {
  const motion = [0, 0, 0, 0, 0, 0];
  for (const code of held) if (KEYS[code]) motion[KEYS[code][0]] += KEYS[code][1];
  if (drag) for (let i = 0; i < 6; ++i) motion[i] += drag.motion[i];
  if (wheel) motion[2] += wheel;
  for (let i = 0; i < 6; ++i) motion[i] = Math.max(-1, Math.min(1, motion[i] + sticks[i]));
  const strength = Number(find('strength').value);
  const [right, away, up, yaw, pitch, roll] = motion.map((value) => value * strength);
  const numbers = [
    right * RIGHT[0] + away * AWAY[0], right * RIGHT[1] + away * AWAY[1], up, roll, pitch, yaw,
  ].map((value) => Math.round(Math.max(-1, Math.min(1, value)) * 1000) / 1000 + 0);
  return { a: [...numbers, open ? 1 : -1], held: held.has('KeyT') || motion.some((value) => value !== 0) };
}

export function release() {
  held.clear();
  drag = null;
  wheel = 0;
  changed();
}

export function toggleGripper() {
  open = !open;
  changed();
}

function press(code) {
  if (code === 'Space') toggleGripper();
  else if (!held.has(code)) {
    held.add(code);
    changed();
  }
}

function lift(code) {
  if (held.delete(code)) changed();
}

function keys(stage, commands) {
  stage.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const known = event.code in KEYS || event.code === 'Space' || event.code === 'KeyT';
    if (!known && !(event.code in commands)) return;
    event.preventDefault();
    if (event.repeat) return;
    if (known) press(event.code);
    else commands[event.code]();
  });
  stage.addEventListener('keyup', (event) => lift(event.code));
  stage.addEventListener('blur', release);
  window.addEventListener('blur', release);
}

function mouse(stage) {
  const end = () => {
    drag = null;
    changed();
  };
  stage.addEventListener('pointerdown', (event) => {
    if (event.button !== 0) return;
    stage.focus({ preventScroll: true });
    stage.setPointerCapture(event.pointerId);
    drag = { x: event.clientX, y: event.clientY, motion: [0, 0, 0, 0, 0, 0] };
  });
  stage.addEventListener('pointermove', (event) => {
    if (!drag) return;
    const x = Math.max(-1, Math.min(1, (event.clientX - drag.x) / DRAG));
    const y = Math.max(-1, Math.min(1, (drag.y - event.clientY) / DRAG));
    drag.motion = event.shiftKey ? [0, 0, y, x, 0, 0] : [x, y, 0, 0, 0, 0];
    changed();
  });
  stage.addEventListener('pointerup', end);
  stage.addEventListener('pointercancel', end);
  stage.addEventListener('wheel', (event) => {
    if (document.activeElement !== stage) return;
    event.preventDefault();
    wheel = event.deltaY < 0 ? 1 : -1;
    changed();
    clearTimeout(wheelEnds);
    wheelEnds = setTimeout(() => {
      wheel = 0;
      changed();
    }, WHEEL);
  }, { passive: false });
}

function pad() {
  for (const [sign, name, code] of PAD) {
    const button = make('button', { type: 'button', 'aria-label': name, title: name }, sign);
    button.addEventListener('pointerdown', (event) => {
      button.setPointerCapture(event.pointerId);
      press(code);
    });
    for (const kind of ['pointerup', 'pointercancel']) button.addEventListener(kind, () => lift(code));
    button.addEventListener('contextmenu', (event) => event.preventDefault());
    button.addEventListener('keydown', (event) => {
      if ((event.code === 'Space' || event.code === 'Enter') && !event.repeat) press(code);
    });
    button.addEventListener('keyup', () => lift(code));
    button.addEventListener('blur', () => lift(code));
    find('pad').append(button);
  }
}

const pressed = new Map();

function buttonOnce(pads, index, call) {
  const now = Boolean(pads.buttons[index]?.pressed);
  if (now && !pressed.get(index)) call();
  pressed.set(index, now);
}

function gamepad(commands) {
  const stick = (value) => (Math.abs(value) < DEAD ? 0 : value);
  setInterval(() => {
    const pads = [...navigator.getGamepads()].find(Boolean);
    if (!pads) return;
    const [x, y, turn, lifted] = pads.axes.map(stick);
    const now = [x ?? 0, -(y ?? 0), -(lifted ?? 0), turn ?? 0, 0, 0];
    if (now.some((value, i) => value !== sticks[i])) {
      sticks = now;
      changed();
    }
    buttonOnce(pads, 0, toggleGripper);
    buttonOnce(pads, 1, commands.KeyN);
    buttonOnce(pads, 9, commands.Enter);
  }, 25);
}

// commands: functions by key code. whenChanged: called when the action has changed.
export function begin(commands, whenChanged) {
  changed = whenChanged;
  const stage = find('stage');
  keys(stage, commands);
  mouse(stage);
  pad();
  gamepad(commands);
  find('strength').addEventListener('input', () => changed());
}
