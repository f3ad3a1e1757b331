// Views of the page, their navigation and notices.
import * as choose from './choose.js';
import { current, setCurrent } from './current.js';
import { find } from './draw.js';
import { connect, on, send } from './link.js';
import * as play from './play.js';
import * as grid from './grid.js';
import * as watch from './watch.js';

const VIEWS = ['choose', 'play', 'watch', 'grid'];
let view = 'choose';
let notice = 0;

function show() {
  const wish = location.hash.slice(1);
  const next = VIEWS.includes(wish) ? wish : 'choose';
  if (view === 'play' && next !== 'play') play.pause();
  if (view === 'watch' && next !== 'watch') watch.pause();
  if (view === 'grid' && next !== 'grid') grid.leave();
  if (view !== next) window.scrollTo(0, 0);
  const changed = view !== next;
  view = next;
  for (const name of VIEWS) find(name).hidden = name !== view;
  for (const link of document.querySelectorAll('nav a')) {
    if (link.hash === `#${view}`) link.setAttribute('aria-current', 'page');
    else link.removeAttribute('aria-current');
  }
  if (!changed) return;
  if (next === 'play') play.enter();
  if (next === 'watch') watch.enter();
  if (next === 'grid') grid.enter();
}

function showNotice(text) {
  find('notice').textContent = text;
  find('notice').hidden = false;
  clearTimeout(notice);
  notice = setTimeout(() => { find('notice').hidden = true; }, 10000);
}

function showConnection(text, button) {
  const box = find('connection');
  box.querySelector('span').textContent = text;
  box.querySelector('button').hidden = !button;
  box.hidden = false;
}

document.addEventListener('chosen', (event) => {
  const { id, view: wish } = event.detail;
  setCurrent(id);
  if (wish === 'play') play.renew();
  location.hash = `#${wish}`;
  show();
  if (wish === 'watch') watch.watch();
});

document.addEventListener('review', () => watch.review());

on('running', (message) => {
  if (view === 'grid') grid.setRunning(message.on);
  else play.ran(message.on);
});
on('playback', (message) => {
  play.leave();
  watch.opened(message);
  show();
});
on('opened', (message) => {
  watch.leave();
  play.opened(message);
});
on('building', (message) => watch.building(message));
on('grid', () => {
  play.leave();
  watch.leave();
  grid.opened();
});
on('error', (message) => {
  watch.failed();
  grid.failed();
  showNotice(message.message);
});
on('busy', () => showConnection('engram is being played in another tab.', true));
on('taken', () => showConnection('Another tab has taken over. Close this one, or', true));
on('closed', (code) => {
  if (code !== 4001) showConnection('The server has ended. Start `engram play` again for a new address.', false);
});
find('connection').querySelector('button').addEventListener('click', () => {
  if (find('connection').textContent.includes('taken over')) location.reload();
  else send({ do: 'take' });
});

await choose.begin();
play.begin();
watch.begin();
grid.begin();
on('hello', (message) => {
  find('connection').hidden = true;
  watch.sources(message);
  grid.setColumns(message.columns);
  play.setChoices(message.choices);
  // The task that the command names, unless the page has gone on to another view.
  if (message.task !== null && current() === null && ['', '#play'].includes(location.hash)) {
    document.dispatchEvent(new CustomEvent('chosen', { detail: { id: message.task, view: 'play' } }));
  }
  document.body.dataset.ready = 'yes';
});
window.addEventListener('hashchange', show);
globalThis.engramPlay = { play: play.stats, grid: grid.stats };
show();
connect();
