// The page: puts its parts together, and draws when something has changed.
import { Run } from 'view/run';
import { Theme, ARROWS, IMPACT } from 'view/palette';
import { Stage } from 'view/stage';
import { Bodies } from 'view/bodies';
import { Ties } from 'view/ties';
import { Arrows } from 'view/arrows';
import { Impacts } from 'view/impacts';
import { Trails } from 'view/trails';
import { Overlay } from 'view/overlay';
import { Plots } from 'view/plots';
import { Player } from 'view/player';
import { listen } from 'view/live';
import { bindKeys } from 'view/keys';

const NEAR = 24;                        // [CSS pixel] a click so near the middle of a body means it
const MANY = 60;                        // bodies whose axes would hide them
const WISHED = { axes: 'body axes', trails: 'trails', names: 'names', origin: 'world axes' };
const ON_REQUEST = new Set(['velocity', 'angular_velocity', 'angular_momentum']);

class View {
  constructor(record, buffer) {
    this.run = new Run(record, buffer);
    this.wishes = new URLSearchParams(location.hash.slice(1));
    document.body.classList.toggle('film', this.wishes.has('film'));
    this.theme = new Theme(colors => this.paint(colors));
    this.plots = new Plots(this.run, time => this.player.seek(time));
    this.player = new Player(this.run, () => { this.dirty = true; });
    this.openStage();
    this.fillChooser();
    this.fillLayers();
    bindKeys(this);
    this.theme.set();
    this.choose(this.firstChoice());
    document.getElementById('follow').checked = this.wishes.has('follow');
    if (this.run.live) {
      this.arrows?.scale();
      this.player.grown();
    }
    this.stage?.frame(this.places());
    if (this.wishes.has('t')) this.player.seek(Number(this.wishes.get('t')));
    window.addEventListener('resize', () => this.resize());
    new ResizeObserver(() => this.resize()).observe(document.getElementById('stage'));
    if (this.run.live) listen(this);
  }

  // Without WebGL the plots still work.
  openStage() {
    const element = document.getElementById('stage'), message = document.getElementById('message');
    try {
      this.stage = new Stage(element, this.run);
    } catch (error) {
      message.textContent = 'The motion needs WebGL, which this browser does not give. The plots need nothing.';
      document.body.dataset.state = 'plots only';
      return;
    }
    this.bodies = new Bodies(this.run);
    this.ties = new Ties(this.run);
    this.arrows = new Arrows(this.run);
    this.impacts = new Impacts(this.run);
    this.trails = new Trails(this.run);
    this.overlay = new Overlay(this.run, this.stage);
    this.stage.scene.add(this.bodies.group, this.ties.group, this.arrows.group, this.impacts.group, this.trails.group);
    this.stage.resize();
    this.selectable(this.stage.renderer.domElement);
    message.hidden = true;
  }

  firstChoice() {
    const { bodies } = this.run, wanted = [
      body => body.name === this.wishes.get('body'), body => !body.fixed && !body.moved, body => !body.fixed, () => true,
    ];
    return wanted.map(fits => bodies.findIndex(fits)).find(index => index >= 0);
  }

  fillChooser() {
    this.chooser = document.getElementById('body');
    this.run.bodies.forEach((body, index) => this.chooser.add(new Option(body.name, index)));
    this.chooser.onchange = () => this.choose(Number(this.chooser.value));
    this.plots.attitude.onchange = () => this.choose(this.chosen);
    document.getElementById('follow').onchange = () => this.stage?.frame(this.places()) ?? this.keepInView();
    document.getElementById('frame').onclick = () => this.frame();
  }

  fillLayers() {
    const holder = document.getElementById('layers'), kinds = this.arrows?.kinds ?? [];
    this.layers = {};
    const impacts = this.run.impacts ? [['impacts', IMPACT.name]] : [];
    for (const [name, words] of [...Object.entries(WISHED), ...kinds.map(kind => [kind, ARROWS[kind].name]), ...impacts]) {
      const label = document.createElement('label'), box = document.createElement('input');
      box.type = 'checkbox';
      box.name = name;
      box.checked = !ON_REQUEST.has(name) && !(name === 'axes' && this.run.bodies.length > MANY);
      box.onchange = () => { this.dirty = true; };
      label.append(box, ` ${words}`);
      label.style.setProperty('--layer', ARROWS[name]?.color ?? (name === 'impacts' ? IMPACT.color : 'transparent'));
      holder.append(label);
      this.layers[name] = box;
    }
  }

  visible(layer) { return this.layers[layer].checked; }

  paint(colors) {
    this.colors = colors;
    this.stage?.paint(colors);
    this.bodies?.paint(colors);
    this.ties?.paint(colors);
    this.trails?.lay(this.chosen, colors);
    this.plots.paint();
    this.dirty = true;
  }

  choose(index) {
    this.chosen = (index + this.run.bodies.length) % this.run.bodies.length;
    const body = this.run.bodies[this.chosen];
    this.chooser.value = this.chosen;
    document.getElementById('swatch').style.background = body.color ?? 'var(--faint)';
    document.getElementById('facts').textContent = body.facts;
    this.plots.attitude.hidden = !(body.axes > 0);
    this.plots.choose(this.chosen);
    this.bodies?.choose(this.chosen);
    this.trails?.lay(this.chosen, this.colors);
    this.dirty = true;
  }

  selectable(canvas) {
    let from = null;
    canvas.addEventListener('pointerdown', event => { from = [event.clientX, event.clientY]; });
    canvas.addEventListener('pointerup', event => {
      if (!from || Math.hypot(event.clientX - from[0], event.clientY - from[1]) > 5) return;
      const found = this.at(event.offsetX, event.offsetY);
      if (found !== undefined) this.choose(found);
    });
  }

  // The body at a place of the picture: what the ray meets, or what is near it.
  at(x, y) {
    const met = this.bodies.met(this.stage.ray(x, y));
    if (met !== undefined && !this.run.bodies[met].ground) return met;
    const near = this.bodies.places.map((place, index) => {
      const seen = this.stage.project(place.position);
      return { index, away: seen.inside && this.run.bodies[index].parts.length ? Math.hypot(seen.x - x, seen.y - y) : Infinity };
    }).reduce((best, one) => (one.away < best.away ? one : best));
    return near.away < NEAR ? near.index : met;
  }

  places() {
    this.bodies.place(this.run.moment(this.player.now));
    return this.bodies.places;
  }

  frame(direction) {
    document.getElementById('follow').checked = false;
    this.stage.frame(this.places(), direction);
  }

  keepInView() {
    const following = document.getElementById('follow').checked;
    this.stage.follow(this.bodies.places, following ? this.chosen : -1);
  }

  resize() {
    this.stage?.resize();
    this.dirty = true;
  }

  // Everything as it is at the present time; synchronous, so that a film can be made of it.
  draw() {
    const moment = this.run.moment(this.player.now);
    this.player.show();
    this.plots.show(this.player.now);
    if (!this.stage) return;
    const places = this.places();
    this.ties.place(places);
    this.keepInView();
    const origin = this.stage.origin();
    this.bodies.draw(origin);
    this.arrows.show(moment, places, origin, kind => this.visible(kind));
    if (this.run.impacts) this.impacts.show(this.player.now, origin, this.visible('impacts'));
    this.trails.show(moment, origin, this.visible('trails'));
    this.bodies.triads.mesh.visible = this.visible('axes');
    this.stage.showOrigin = this.visible('origin');
    this.stage.controls.update();
    this.stage.draw();
    this.overlay.names(places, this.chosen, this.visible('names'));
    this.overlay.measure();
    this.overlay.arrows(this.arrows, kind => this.visible(kind));
  }

  // A picture of one time, for films and tests.
  seek(time) {
    this.player.set(false);
    this.player.seek(time);
    this.draw();
  }

  loop(stamp) {
    const seconds = this.before === undefined ? 0 : Math.min(0.1, (stamp - this.before) / 1000);
    this.before = stamp;
    this.player.advance(seconds);
    if (this.stage?.controls.update()) this.dirty = true;
    if (this.dirty || this.stage?.dirty) {
      this.dirty = false;
      this.draw();
      if (this.stage) this.stage.dirty = false;
    }
    requestAnimationFrame(next => this.loop(next));
  }
}

export function start(record, buffer) {
  const view = new View(record, buffer);
  view.draw();
  if (document.body.dataset.state === 'loading') document.body.dataset.state = 'ready';
  const still = view.wishes.has('paused') || view.wishes.has('t') || window.matchMedia('(prefers-reduced-motion: reduce)').matches;
  view.player.set(!still && !view.run.live && view.run.instants > 1);
  requestAnimationFrame(stamp => view.loop(stamp));
  return view;
}
