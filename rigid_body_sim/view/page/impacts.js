// Impacts at their instants: a ring around the point, across the normal, that opens for a moment.
import * as THREE from 'three';
import { arrayOf, from, Growing } from 'view/run';
import { IMPACT } from 'view/palette';

const LASTS = 0.25;                     // [s] of the run that a ring is seen
const SMALL = 0.3, LARGE = 1.0;        // [-] of the usual arrow: radius at its begin and end
const MOST = 256;                       // rings at once: the last ones
const Z = new THREE.Vector3(0, 0, 1);

export class Impacts {
  constructor(run) {
    this.group = new THREE.Group();
    this.told = run.impacts;
    if (!this.told) return;
    this.allTimes = new Growing(arrayOf(run.impacts.times, run.buffer));
    this.allPlaces = new Growing(Float64Array.from(arrayOf(run.impacts.places, run.buffer)), 6);       // point, normal
    this.arrow = run.arrow;
    const material = new THREE.MeshBasicMaterial({ color: IMPACT.color, side: THREE.DoubleSide, transparent: true, opacity: 0.85, depthTest: false });
    this.mesh = new THREE.InstancedMesh(new THREE.RingGeometry(0.82, 1, 40), material, MOST);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 3;
    this.mesh.count = 0;
    this.group.add(this.mesh);
    run.grownImpacts.push((told, buffer) => {
      this.allTimes.append(arrayOf(told.times, buffer));
      this.allPlaces.append(arrayOf(told.places, buffer));
    });
  }

  get times() { return this.allTimes.values; }
  get places() { return this.allPlaces.values; }

  // The number of the first impact after a time.
  after(time) {
    let low = 0, high = this.times.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= time) low = middle + 1; else high = middle;
    }
    return low;
  }

  show(time, origin, visible) {
    if (!this.told) return;
    this.group.position.fromArray(origin);
    const end = visible ? this.after(time) : 0, first = visible ? Math.max(this.after(time - LASTS), end - MOST) : 0;
    const turn = new THREE.Quaternion(), matrix = new THREE.Matrix4(), point = new THREE.Vector3(), normal = new THREE.Vector3(), size = new THREE.Vector3();
    this.mesh.count = 0;
    for (let i = first; i < end; i++) {
      const share = (time - this.times[i]) / LASTS;
      turn.setFromUnitVectors(Z, normal.fromArray(this.places, 6 * i + 3));
      size.setScalar(this.arrow * (SMALL + (LARGE - SMALL) * share));
      this.mesh.setMatrixAt(this.mesh.count++, matrix.compose(point.fromArray(from(origin, this.places.subarray(6 * i, 6 * i + 3), [])), turn, size));
    }
    this.mesh.instanceMatrix.needsUpdate = true;
  }
}
