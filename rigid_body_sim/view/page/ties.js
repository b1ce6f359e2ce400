// What ties bodies: springs as coils (with a damper as a rod inside), bumpers as buffers, pivots as balls.
import * as THREE from 'three';
import { coilGeometry } from 'view/shapes';
import { rotate } from 'view/run';

const Z = new THREE.Vector3(0, 0, 1);

// Where an end { body, at } is: a point of a body (as seen from its centre of mass), or of the world.
function endOf(end, places, out) {
  if (end.body < 0) return out.fromArray(end.at);
  const arm = rotate(places[end.body].orientation, end.at, []);
  return out.fromArray(places[end.body].position.map((x, j) => x + arm[j]));
}

function between(mesh, start, end, thick) {
  const along = end.clone().sub(start), length = along.length();
  mesh.visible = length > 0;
  mesh.position.copy(start);
  if (length > 0) mesh.quaternion.setFromUnitVectors(Z, along.divideScalar(length));
  mesh.scale.set(thick, thick, Math.max(length, 1e-9));
}

const rod = new THREE.CylinderGeometry(1, 1, 1, 16).rotateX(Math.PI / 2).translate(0, 0, 0.5);
const ball = new THREE.SphereGeometry(1, 24, 16);

class Spring {
  constructor(told, materials) {
    this.told = told;
    this.coil = new THREE.Mesh(coilGeometry(told.long / told.radius), materials.spring);
    this.drawn = [this.coil];
    if (told.damping > 0) this.drawn.push(new THREE.Mesh(rod, materials.arm), new THREE.Mesh(rod, materials.damper));
    this.feet = [new THREE.Mesh(ball, materials.anchor), new THREE.Mesh(ball, materials.anchor)];
    this.drawn.push(...this.feet);
  }

  place(places) {
    const a = endOf(this.told.a, places, new THREE.Vector3()), b = endOf(this.told.b, places, new THREE.Vector3());
    const thick = this.told.radius;
    between(this.coil, a, b, thick);
    if (this.told.damping > 0) {
      between(this.drawn[1], a, b, 0.18 * thick);
      between(this.drawn[2], a, a.clone().lerp(b, 0.5), 0.5 * thick);
    }
    [a, b].forEach((end, i) => {
      this.feet[i].position.copy(end);
      this.feet[i].scale.setScalar(0.45 * thick);
    });
  }
}

// A buffer on the end of a that reaches as far as it pushes; pressed where b is nearer.
class Bumper {
  constructor(told, materials) {
    this.told = told;
    this.coil = new THREE.Mesh(coilGeometry(told.length / told.radius), materials.bumper);
    this.plate = new THREE.Mesh(rod, materials.anchor);
    this.drawn = [this.coil, this.plate];
  }

  place(places) {
    const a = endOf(this.told.a, places, new THREE.Vector3()), b = endOf(this.told.b, places, new THREE.Vector3());
    const along = b.clone().sub(a), distance = along.length() || 1e-9;
    const tip = a.clone().addScaledVector(along, Math.min(distance, this.told.length) / distance);
    const back = tip.clone().addScaledVector(along, (-0.12 * this.told.length) / distance);
    between(this.coil, a, tip, this.told.radius);
    between(this.plate, back, tip, 1.25 * this.told.radius);
  }
}

// The fixed point and the arm to the centre of mass; faintly also through the body that hides them.
class PivotBall {
  constructor(told, materials) {
    this.told = told;
    this.at = new THREE.Vector3().fromArray(told.at);
    this.balls = [materials.anchor, materials.hidden].map(material => new THREE.Mesh(ball, material));
    this.rods = [materials.arm, materials.hidden].map(material => new THREE.Mesh(rod, material));
    this.drawn = [...this.balls, ...this.rods];
    for (const each of this.balls) {
      each.scale.setScalar(told.radius);
      each.position.copy(this.at);
    }
    for (const each of [this.balls[1], this.rods[1]]) each.renderOrder = 1;
  }

  place(places) {
    const center = new THREE.Vector3().fromArray(places[this.told.body].position);
    for (const each of this.rods) between(each, this.at, center, 0.35 * this.told.radius);
  }
}

export class Ties {
  constructor(run) {
    const lit = color => new THREE.MeshLambertMaterial({ color });
    this.materials = {
      spring: lit(0x8a94a6), bumper: lit(0xd9882b), damper: lit(0x4e5969), arm: lit(0x7b8596), anchor: lit(0x3d4654),
      hidden: new THREE.MeshBasicMaterial({ color: 0x3d4654, depthTest: false, transparent: true, opacity: 0.4 }),
    };
    const kinds = { spring: Spring, bumper: Bumper, pivot: PivotBall };
    this.all = run.ties.map(told => new kinds[told.kind](told, this.materials));
    this.group = new THREE.Group();
    for (const { drawn } of this.all)
      for (const mesh of drawn) {
        mesh.castShadow = mesh.material !== this.materials.hidden;
        this.group.add(mesh);
      }
  }

  paint(colors) {
    this.materials.anchor.color.set(colors.ink).lerp(new THREE.Color(0x7b8596), 0.35);
    this.materials.hidden.color.set(colors.ink);
  }

  place(places) {
    for (const tie of this.all) tie.place(places);
  }
}
