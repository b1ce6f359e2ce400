// Keys: see the list in page.html.
import { Vector3 } from 'three';

const FASTER = 10 ** 0.1;

export function bindKeys(view) {
  const help = document.getElementById('help'), { player } = view;
  const flip = name => document.getElementById(name).click();
  const look = (x, y, z) => view.stage && view.frame(new Vector3(x, y, z));
  const actions = {
    ' ': () => player.toggle(),
    ArrowRight: () => player.step(1),
    ArrowLeft: () => player.step(-1),
    ArrowUp: () => player.pace(player.rate * FASTER),
    ArrowDown: () => player.pace(player.rate / FASTER),
    Home: () => player.seek(view.run.begin),
    End: () => player.seek(view.run.end),
    n: () => view.choose(view.chosen + 1),
    p: () => view.choose(view.chosen - 1),
    a: () => view.stage && view.frame(),
    f: () => flip('follow'),
    l: () => flip('loop'),
    t: () => view.theme.toggle(),
    '?': () => help.showModal(),
    1: () => look(-1, 0, 0.001),
    2: () => look(0, -1, 0.001),
    3: () => look(0, -0.001, 1),
  };
  document.getElementById('keys').onclick = () => help.showModal();
  window.addEventListener('keydown', event => {
    const { tagName } = event.target, key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (help.open || event.ctrlKey || event.metaKey || event.altKey) return;
    if (tagName === 'SELECT' || (tagName === 'BUTTON' && key === ' ')) return;
    if (!actions[key]) return;
    event.preventDefault();
    actions[key]();
  });
}
