// Views, and what holds for all of them.
import * as choose from './choose.js';
import { find } from './draw.js';
import { connect, on, say } from './link.js';
import * as play from './play.js';
import * as wall from './wall.js';
import * as watch from './watch.js';

const VIEWS = ['choose', 'play', 'watch', 'wall'];
let view = 'choose';
let notice = 0;

function show() {
  const wish = location.hash.slice(1);
  const next = VIEWS.includes(wish) ? wish : 'choose';
  if (view === 'play' && next !== 'play') play.pause();
  if (view === 'watch' && next !== 'watch') watch.stop();
  if (view === 'wall' && next !== 'wall') say({ do: 'leave' });
  if (view !== next) window.scrollTo(0, 0);
  if (next === 'watch') watch.enter();
  if (next === 'wall') wall.enter();
  view = next;
  for (const name of VIEWS) find(name).hidden = name !== view;
  for (const link of document.querySelectorAll('nav a')) {
    if (link.hash === `#${view}`) link.setAttribute('aria-current', 'page');
    else link.removeAttribute('aria-current');
  }
}

function tell(words) {
  find('notice').textContent = words;
  find('notice').hidden = false;
  clearTimeout(notice);
  notice = setTimeout(() => { find('notice').hidden = true; }, 10000);
}

function away(words, button) {
  const box = find('away');
  box.querySelector('span').textContent = words;
  box.querySelector('button').hidden = !button;
  box.hidden = false;
}

document.addEventListener('chosen', async (event) => {
  const { id, view: wish } = event.detail;
  location.hash = `#${wish}`;
  show();
  wall.choose(id);
  if (wish === 'watch') watch.watch(id);
  else await play.choose(id);
});

on('running', (message) => {
  if (view === 'wall') wall.setRunning(message.on);
  else play.ran(message.on);
});
on('film', (message) => {
  play.leave();
  watch.opened(message);
});
on('wall', (message) => {
  play.leave();
  find('task-shown').textContent = message.id;
});
on('error', (message) => {
  watch.failed();
  tell(message.message);
});
on('busy', () => away('engram is being played in another tab.', true));
on('taken', () => away('Another tab has taken over. Close this one, or', true));
on('closed', (code) => {
  if (code !== 4001) away('The server has ended. Start `engram play` again for a new address.', false);
});
find('away').querySelector('button').addEventListener('click', () => {
  if (find('away').textContent.includes('taken over')) location.reload();
  else say({ do: 'take' });
});

await choose.begin();
play.begin();
watch.begin();
wall.begin();
on('hello', (message) => {
  find('away').hidden = true;
  watch.sources(message);
  wall.setColumns(message.columns);
  document.body.dataset.ready = 'yes';
});
window.addEventListener('hashchange', show);
globalThis.engramPlay = { play: play.stats, wall: wall.stats };
show();
connect();
