// Where bodies have been: the path of the centre of mass, or of the tip of an axis where a body stays.
import * as THREE from 'three';
import { from, rotate } from 'view/run';

const FEW = 14;                         // paths; of more bodies only the selected one has one
const POINTS = 3000;                    // of a path
const NEAR = 3e4;                       // [-] usual arrows that what is looked at may be from where paths are seen from

export class Trails {
  constructor(run) {
    this.run = run;
    this.group = new THREE.Group();
    this.base = [0, 0, 0];              // where paths are seen from, so that single precision is enough
  }

  // Lay the paths anew: for all bodies where they are few, else for the selected one.
  lay(chosen, colors) {
    this.laid = { chosen, colors };
    this.group.position.fromArray(this.base);
    this.group.traverse(line => line.geometry?.dispose());
    this.group.clear();
    this.run.bodies.forEach((body, index) => {
      if (body.fixed && !body.moved) return;
      if (this.run.bodies.length > FEW && index !== chosen) return;
      this.draw(index, body.color ?? colors.line, index === chosen);
    });
  }

  draw(body, color, chosen) {
    const { points, every } = this.path(body);
    const attribute = new THREE.BufferAttribute(points, 3);
    for (const part of ['past', 'all']) {
      const geometry = new THREE.BufferGeometry().setAttribute('position', attribute);
      const opacity = part === 'past' ? 0.95 : chosen ? 0.42 : 0.22;
      const line = new THREE.Line(geometry, new THREE.LineBasicMaterial({ color, transparent: true, opacity }));
      line.frustumCulled = false;
      line.userData = { every, part };
      this.group.add(line);
    }
  }

  // Points as seen from the base.
  path(body) {
    const { run } = this, shift = from(this.base, run.origins[body], []), every = Math.max(1, Math.ceil(run.instants / POINTS)), count = Math.ceil(run.instants / every);
    const points = new Float32Array(3 * count), { values } = run.series.position, n = run.bodies.length;
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < count; i++)
      for (let j = 0; j < 3; j++) {
        const x = values[3 * (i * every * n + body) + j];
        points[3 * i + j] = x + shift[j];
        low[j] = Math.min(low[j], x);
        high[j] = Math.max(high[j], x);
      }
    const travel = Math.hypot(...high.map((x, j) => x - low[j])), { axes } = run.bodies[body];
    if (axes > 0 && travel < 0.2 * axes) return { points: this.tips(body, every, count, shift), every };
    return { points, every };
  }

  // Path of the tip of the axis that sweeps farthest.
  tips(body, every, count, shift) {
    const { run } = this, length = run.bodies[body].axes;
    const paths = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(axis => {
      const points = new Float32Array(3 * count), tip = [0, 0, 0], q = [0, 0, 0, 1], at = [0, 0, 0];
      let sweep = 0;
      for (let i = 0; i < count; i++) {
        const moment = { k: i * every, next: i * every, s: 0 };
        rotate(run.orientation(body, moment, q), axis.map(x => x * length), tip);
        run.vector('position', body, moment, at);
        for (let j = 0; j < 3; j++) {
          points[3 * i + j] = tip[j] + at[j] + shift[j];
          if (i) sweep += Math.abs(points[3 * i + j] - points[3 * i - 3 + j]);
        }
      }
      return { points, sweep };
    });
    return paths.reduce((best, path) => (path.sweep > best.sweep ? path : best)).points;
  }

  // Up to now strongly, what is to come faintly.
  show(moment, origin, visible) {
    if (this.laid && visible && Math.hypot(...from(this.base, origin, [])) > NEAR * this.run.arrow) {
      this.base = origin;
      this.lay(this.laid.chosen, this.laid.colors);
    }
    this.group.visible = visible;
    for (const { geometry, userData } of this.group.children)
      if (userData.part === 'past') geometry.setDrawRange(0, Math.floor(moment.k / userData.every) + 1);
  }
}
