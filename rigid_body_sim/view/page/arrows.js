// Arrows: commands, contacts, drag, drives; velocity, angular velocity and angular momentum on request.
import * as THREE from 'three';
import { arrowGeometry } from 'view/shapes';
import { ARROWS } from 'view/palette';
import { arrayOf, from, Growing, rotate } from 'view/run';

const RECENT = 250;                     // instants whose contacts say how long an arrow is, while a run goes on
const USUAL = 0.9;                      // [-] share of the vectors that are no longer than the usual arrow
const THICK = 0.045;                    // [-] of the usual length
const Z = new THREE.Vector3(0, 0, 1);

// As many arrows of one kind as an instant needs.
class Quiver {
  constructor(kind, most, usual) {
    const material = new THREE.MeshBasicMaterial({ color: ARROWS[kind].color, depthTest: false, transparent: true, opacity: 0.9 });
    this.group = new THREE.Group();
    this.material = material;
    this.usual = usual;
    this.kind = kind;
    this.room(Math.max(1, most));
  }

  // Makes room for so many arrows; those that were there are forgotten.
  room(most) {
    if (this.most >= most) return;
    this.most = most;
    if (this.mesh) {
      this.group.remove(this.mesh);
      this.mesh.dispose();
    }
    this.mesh = new THREE.InstancedMesh(Quiver.arrow, this.material, most);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 2;
    this.group.add(this.mesh);
    this.clear();
  }

  clear() {
    this.mesh.count = 0;
  }

  // start (3) [m], direction times length (3) [m]
  add(start, along) {
    const length = Math.hypot(...along);
    if (!(length > 1e-3 * this.usual)) return;
    const thick = Math.min(THICK * this.usual, 0.25 * length);
    Quiver.turn.setFromUnitVectors(Z, Quiver.direction.fromArray(along).divideScalar(length));
    Quiver.matrix.compose(Quiver.start.fromArray(from(Quiver.origin, start, [])), Quiver.turn, Quiver.size.set(thick, thick, length));
    this.mesh.setMatrixAt(this.mesh.count++, Quiver.matrix);
    this.mesh.instanceMatrix.needsUpdate = true;
  }
}
Object.assign(Quiver, {
  arrow: arrowGeometry(0.28, 0.4),
  turn: new THREE.Quaternion(), direction: new THREE.Vector3(), start: new THREE.Vector3(),
  size: new THREE.Vector3(), matrix: new THREE.Matrix4(), origin: [0, 0, 0],
});

// Vectors of some bodies over time, drawn at a point of each: { kind, bodies, at, columns, width, series, metres }.
class BodyArrows {
  constructor(run, told) {
    Object.assign(this, told);
    this.run = run;
    this.idle = Boolean(run.live);      // nothing of it was seen so far, so no arrow means anything
    this.quiver = new Quiver(told.kind, told.bodies.length, run.arrow);
  }

  // While a run goes on: as long as a usual arrow is what only a tenth of the last exceed.
  scale() {
    const { values } = this.run.series[this.series], sizes = [];
    for (let i = Math.max(0, values.length - 3 * this.width * RECENT); i < values.length; i += 3) {
      const size = Math.hypot(values[i], values[i + 1], values[i + 2]);
      if (size > 0) sizes.push(size);
    }
    this.idle &&= !sizes.length;
    this.metres = scaled(this.run.arrow, sizes) ?? this.metres;
  }

  // Held between instants, as a command is: what acted over the tick that ends at the next instant.
  show(moment, places) {
    const { values } = this.run.series[this.series];
    const k = this.kind.startsWith('command') && moment.s > 0 ? moment.next : moment.k;
    const vector = [0, 0, 0], arm = [0, 0, 0];
    this.bodies.forEach((body, i) => {
      const from = 3 * (k * this.width + this.columns[i]);
      for (let j = 0; j < 3; j++) vector[j] = this.metres * values[from + j];
      const long = Math.hypot(...vector), most = 4 * this.run.arrow;
      if (long > most) for (let j = 0; j < 3; j++) vector[j] *= most / long;
      rotate(places[body].orientation, this.at[i], arm);
      this.quiver.add(places[body].position.map((x, j) => x + arm[j]), vector);
    });
  }
}

// Contact forces of the recorded instant that is nearest: { starts, arrows, metres, longest }.
class ContactArrows {
  constructor(run) {
    this.kind = 'contact';
    this.told = run.contacts;
    this.metres = run.contacts.metres;
    this.allStarts = new Growing(arrayOf(run.contacts.starts, run.buffer));
    this.allNumbers = new Growing(Float64Array.from(arrayOf(run.contacts.arrows, run.buffer)), 6);      // point, force
    let most = 1;
    for (let k = 1; k < this.starts.length; k++) most = Math.max(most, this.starts[k] - this.starts[k - 1]);
    this.quiver = new Quiver('contact', most, run.arrow);
    this.arrow = run.arrow;
    run.grownContacts.push((told, buffer) => this.grow(arrayOf(told.starts, buffer), arrayOf(told.arrows, buffer)));
    run.thinnings.push(kept => this.keep(kept));
  }

  get starts() { return this.allStarts.values; }
  get numbers() { return this.allNumbers.values; }

  // What comes while a run goes on, behind what is there.
  grow(starts, numbers) {
    const before = this.starts[this.starts.length - 1];
    this.allStarts.append(starts.slice(1).map(start => start + before));
    this.allNumbers.append(numbers);
    let most = 1;
    for (let k = 1; k < starts.length; k++) most = Math.max(most, starts[k] - starts[k - 1]);
    this.quiver.room(most);
  }

  // Keeps the contacts of some instants.
  keep(kept) {
    const { starts, numbers } = this;
    let end = 0;
    kept.forEach((k, place) => {
      const from = starts[k], to = starts[k + 1];
      numbers.copyWithin(6 * end, 6 * from, 6 * to);
      starts[place] = end;
      end += to - from;
    });
    starts[kept.length] = end;
    this.allStarts.cut(kept.length + 1);
    this.allNumbers.cut(6 * end);
  }

  scale() {
    const first = this.starts[Math.max(0, this.starts.length - RECENT)], sizes = [];
    for (let i = first; i < this.starts[this.starts.length - 1]; i++) sizes.push(Math.hypot(...this.numbers.subarray(6 * i + 3, 6 * i + 6)));
    this.metres = scaled(this.arrow, sizes) ?? this.metres;
  }

  show(moment) {
    const k = moment.s < 0.5 ? moment.k : moment.next;
    for (let i = this.starts[k]; i < this.starts[k + 1]; i++) {
      const force = this.numbers.subarray(6 * i + 3, 6 * i + 6), size = Math.hypot(...force);
      const length = Math.min(size * this.metres, this.told.longest);
      if (size > 0) this.quiver.add(this.numbers.subarray(6 * i, 6 * i + 3), Array.from(force, f => (f * length) / size));
    }
  }
}

// Metres for each unit, so that a usual arrow stands for what only a tenth exceed; undefined: there is nothing.
function scaled(arrow, sizes) {
  sizes.sort((a, b) => a - b);
  const usual = sizes[Math.floor(USUAL * (sizes.length - 1))];
  return usual > 0 ? arrow / usual : undefined;
}

export class Arrows {
  constructor(run) {
    this.sets = run.arrows.map(told => new BodyArrows(run, told));
    if (run.contacts) this.sets.push(new ContactArrows(run));
    this.group = new THREE.Group();
    for (const set of this.sets) this.group.add(set.quiver.group);
  }

  scale() {
    for (const set of this.sets) set.scale();
  }

  get kinds() { return [...new Set(this.sets.map(set => set.kind))]; }

  // What acts, drawn as seen from a point of the world.
  show(moment, places, origin, visible) {
    this.count = {};
    this.group.position.fromArray(origin);
    Quiver.origin = origin;
    for (const set of this.sets) {
      set.quiver.clear();
      if (visible(set.kind)) set.show(moment, places);
      this.count[set.kind] = (this.count[set.kind] ?? 0) + set.quiver.mesh.count;
    }
  }

  // What a usual arrow stands for, by kind, in words.
  meaning(kind, length) {
    const set = this.sets.find(each => each.kind === kind), worth = length / set.metres;
    return !set.idle && Number.isFinite(worth) ? `${Number(worth.toPrecision(2))} ${ARROWS[kind].unit}` : '';
  }
}
