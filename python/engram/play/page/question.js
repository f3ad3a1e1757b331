// A question with a list of answers, which the server asks while time stands still.
import { find, make } from './draw.js';
import { send } from './link.js';

let asked = null;
let named = []; // indices of the choices, in order

export const isOpen = () => asked !== null;

export function close() {
  asked = null;
  find('question').hidden = true;
}

function answer() {
  send({ do: 'choose', choices: named });
}

function show() {
  find('named').textContent = named.map((index) => asked.choices[index]).join(', then ');
  for (const [index, button] of [...find('answers').children].entries()) {
    const used = !asked.repeats && named.includes(index);
    button.disabled = used || named.length >= asked.most;
    button.setAttribute('aria-pressed', named.includes(index));
  }
  find('answer').disabled = named.length < asked.least;
  find('take-back').disabled = named.length === 0;
}

function name(index) {
  named.push(index);
  if (asked.most === 1) answer();
  show();
}

export function open(message) {
  asked = message;
  named = [];
  const several = asked.most > 1;
  const count = asked.least === asked.most ? `${asked.most}` : `${asked.least} to ${asked.most}`;
  find('question-text').textContent = several ? `${asked.question} (${count})` : asked.question;
  find('answers').replaceChildren(...asked.choices.map((text, index) =>
    make('button', { type: 'button', onclick: () => name(index) }, text)));
  find('compose').hidden = !several;
  find('named').hidden = !several;
  find('question').hidden = false;
  show();
  find('answers').firstChild.focus({ preventScroll: true });
}

export function begin() {
  find('answer').addEventListener('click', answer);
  find('take-back').addEventListener('click', () => {
    named.pop();
    show();
  });
}
