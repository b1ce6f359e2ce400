// A run that goes on: the server sends what is new, base64 of { length, record, numbers }.

const FRESH = 1000;                     // [ms] between two layings of plots and trails

export function listen(view) {
  let laid = 0;
  const source = new EventSource(`events?after=${view.run.live.told}`);
  source.onmessage = event => {
    const { record, numbers } = JSON.parse(event.data);
    view.run.append(record, bytesOf(numbers));
    view.player.grown();
    if (performance.now() - laid < FRESH) return;
    laid = performance.now();
    view.arrows?.scale();
    view.choose(view.chosen);
  };
  source.addEventListener('end', () => {
    source.close();
    document.body.dataset.live = 'ended';
    document.getElementById('about').textContent += ' · ended';
    view.arrows?.scale();
    view.choose(view.chosen);
  });
  source.onopen = () => { document.body.dataset.live = 'on'; };
  source.onerror = () => { document.body.dataset.live = 'lost'; };
}

function bytesOf(text) {
  return Uint8Array.from(atob(text), letter => letter.charCodeAt(0)).buffer;
}
