// A run that goes on: the server sends what is new, base64 of { length, record, numbers }.

const FRESH = 1000;                     // [ms] between two layings of plots and trails
const SILENT = 3;                       // [s] without anything new after which that is said

export function listen(view) {
  const { run, told } = view.run.live, state = document.body.dataset, said = document.getElementById('news');
  let laid = 0, heard = performance.now();
  const lay = () => {
    laid = performance.now();
    view.arrows?.scale();
    view.choose(view.chosen);
  };
  const source = new EventSource(`events?run=${run}&after=${told}`);
  source.onmessage = event => {
    const { record, numbers } = JSON.parse(event.data), { instants } = view.run;
    view.run.append(record, bytesOf(numbers));
    view.player.grown();
    heard = performance.now();
    if (heard - laid > FRESH || view.run.instants < instants) lay();
  };
  const tell = () => {
    const silence = Math.floor((performance.now() - heard) / 1000);
    const news = { on: silence < SILENT ? '' : `nothing new for ${silence} s`, lost: 'connection lost' }[state.live] ?? '';
    if (said.textContent !== news) said.textContent = news;
  };
  const become = live => {
    state.live = live;
    tell();
  };
  source.addEventListener('end', () => {
    source.close();
    become('ended');
    document.getElementById('about').textContent += ' · ended';
    lay();
  });
  source.addEventListener('begin', () => {          // another run: all of the page is of the one before
    source.close();
    location.reload();
  });
  source.onopen = () => become('on');
  source.onerror = () => become('lost');
  setInterval(tell, 1000);
}

function bytesOf(text) {
  return Uint8Array.from(atob(text), letter => letter.charCodeAt(0)).buffer;
}
