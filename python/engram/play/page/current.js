// The chosen task, which all views share and the header names.
import { find } from './draw.js';

let id = null;

export const current = () => id;

export function setCurrent(task) {
  id = task;
  find('task-shown').textContent = task ?? '';
}
