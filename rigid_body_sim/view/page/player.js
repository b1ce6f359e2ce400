// Time: plays, pauses, goes to an instant; the controls below the picture.


export class Player {
  constructor(run, changed) {
    this.run = run;
    this.changed = changed;
    this.now = run.begin;
    this.playing = false;
    for (const name of ['play', 'time', 'clock', 'speed', 'speed-text', 'loop', 'live', 'live-label'])
      this[name.replace(/-(.)/, (_, letter) => letter.toUpperCase())] = document.getElementById(name);
    this.span();
    this.play.onclick = () => this.toggle();
    this.time.oninput = () => this.seek(Number(this.time.value));
    this.speed.oninput = () => this.pace(10 ** Number(this.speed.value));
    this.loop.onchange = () => changed();
    this.pace(startingPace(run.end - run.begin));
    if (run.live) {
      this.liveLabel.hidden = false;
      this.liveLabel.onchange = () => this.grown();
    }
  }

  // The time slider spans the run, which may have grown.
  span() {
    this.time.min = this.run.begin;
    this.time.max = Math.max(this.run.end, this.run.begin + 1e-9);
    this.length = this.run.end - this.run.begin;
    this.digits = this.length > 0 ? Math.min(6, Math.max(0, 3 - Math.floor(Math.log10(this.length)))) : 3;
  }

  get followsLive() { return Boolean(this.run.live) && this.live.checked; }

  grown() {
    this.span();
    if (this.followsLive) this.seek(this.run.end, true);
    else this.changed();
  }

  pace(rate) {
    this.rate = Math.min(100, Math.max(0.01, rate));
    this.speed.value = Math.log10(this.rate);
    this.speedText.textContent = `${Number(this.rate.toPrecision(2))} ×`;
    this.changed();
  }

  seek(time, live = false) {
    if (this.run.live && !live) this.live.checked = false;
    this.now = Math.min(Math.max(time, this.run.begin), this.run.end);
    this.changed();
  }

  // One recorded instant back (-1) or on (+1).
  step(way) {
    this.set(false);
    const { k, s } = this.run.moment(this.now);
    const to = way > 0 ? k + 1 : s > 0 ? k : k - 1;
    this.seek(this.run.times[Math.min(Math.max(to, 0), this.run.instants - 1)]);
  }

  toggle() {
    if (this.run.live && !this.playing) this.live.checked = false;
    if (!this.playing && this.now >= this.run.end) this.now = this.run.begin;
    this.set(!this.playing && this.run.instants > 1);
  }

  set(playing) {
    this.playing = playing;
    document.body.dataset.playing = playing;
    this.play.setAttribute('aria-label', playing ? 'pause' : 'play');
    this.changed();
  }

  advance(seconds) {
    if (!this.playing) return;
    const next = this.now + seconds * this.rate;
    if (next < this.run.end) this.now = next;
    else if (this.loop.checked) this.now = this.run.begin;
    else {
      this.now = this.run.end;
      this.set(false);
    }
    this.changed();
  }

  show() {
    this.time.value = this.now;
    this.clock.textContent = `${this.now.toFixed(this.digits)} / ${this.run.end.toFixed(this.digits)} s`;
  }
}

// Its own pace, unless the run would be over at once or last for minutes.
function startingPace(length) {
  if (length <= 0 || (length <= 60 && length >= 1)) return 1;
  const wanted = length > 60 ? length / 30 : length / 5, power = 10 ** Math.floor(Math.log10(wanted));
  return power * [5, 2, 1].find(step => step * power <= wanted * (1 + 1e-9));
}
