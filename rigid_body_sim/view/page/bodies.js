// The bodies: equal forms are instances of one geometry, so that a thousand bodies cost a few draw calls.
import * as THREE from 'three';
import { arrowGeometry, geometryOf } from 'view/shapes';
import { AXES } from 'view/palette';
import { from } from 'view/run';

const ACCENT = 0xff8c1a, MARGIN = 1.045;

// Edges of many bodies at once: the library instances faces only, so this one says that it is lines.
class InstancedEdges extends THREE.InstancedMesh {
  constructor(...all) {
    super(...all);
    this.isMesh = false;
    this.isLine = this.isLineSegments = true;
  }
}

export class Bodies {
  constructor(run) {
    this.run = run;
    this.group = new THREE.Group();
    this.places = run.bodies.map(() => ({ position: [0, 0, 0], orientation: [0, 0, 0, 1] }));
    this.batches = batchesOf(run);
    this.ink = new THREE.LineBasicMaterial({ transparent: true, opacity: 0.6 });
    this.forms = run.forms.map(form => geometryOf(form, run.buffer));
    for (const batch of this.batches) this.build(batch);
    this.triads = new Triads(run);
    this.origin = [0, 0, 0];
    this.group.add(this.triads.mesh);
    this.halo = new THREE.Group();
    this.group.add(this.halo);
  }

  build(batch) {
    const { faces, edges } = this.forms[batch.form], count = batch.members.length;
    const material = new THREE.MeshLambertMaterial({ vertexColors: true, side: batch.sheet ? THREE.DoubleSide : THREE.FrontSide });
    if (batch.translucent) Object.assign(material, { transparent: true, opacity: 0.28, depthWrite: false });
    batch.faces = new THREE.InstancedMesh(faces, material, count);
    batch.faces.castShadow = !batch.translucent && !batch.sheet;
    batch.faces.receiveShadow = true;
    batch.faces.userData.members = batch.members;
    batch.edges = edges && new InstancedEdges(edges, this.ink, count);
    for (const drawn of [batch.faces, batch.edges]) {
      if (!drawn) continue;
      drawn.frustumCulled = false;
      this.group.add(drawn);
    }
  }

  // Colours of a theme: fixed bodies are grey, the others keep theirs.
  paint(colors) {
    const color = new THREE.Color();
    this.ink.color.set(colors.ink);
    for (const batch of this.batches) {
      batch.members.forEach(({ body }, i) => batch.faces.setColorAt(i, color.set(this.run.bodies[body].color ?? colors.fixed)));
      batch.faces.instanceColor.needsUpdate = true;
    }
  }

  // Poses of an instant, between two recorded ones.
  place(moment) {
    this.places.forEach((place, body) => {
      this.run.position(body, moment, place.position);
      this.run.orientation(body, moment, place.orientation);
    });
  }

  // Draw them there. The picture takes single precision, so it is told where they are as seen from an
  // origin near them: a point of the world (3) [m].
  draw(origin) {
    this.origin = origin;
    this.group.position.fromArray(origin);
    const seen = [0, 0, 0];
    const frame = new THREE.Matrix4(), position = new THREE.Vector3(), turn = new THREE.Quaternion(), one = new THREE.Vector3(1, 1, 1);
    const whole = new THREE.Matrix4();
    const of = body => frame.compose(position.fromArray(from(origin, this.places[body].position, seen)), turn.fromArray(this.places[body].orientation), one);
    for (const { members, faces, edges } of this.batches) {
      members.forEach(({ body, local }, i) => {
        whole.multiplyMatrices(of(body), local);
        faces.setMatrixAt(i, whole);
        if (edges) edges.setMatrixAt(i, whole);
      });
      for (const drawn of [faces, edges]) if (drawn) drawn.instanceMatrix.needsUpdate = true;
      faces.boundingSphere = null;
    }
    this.triads.place(this.places, origin);
    if (this.chosen !== undefined) this.halo.matrix.copy(of(this.chosen));
    this.halo.matrixWorldNeedsUpdate = true;
  }

  // Where each part of each body is in the world: matrices, column by column.
  matrices() {
    const found = this.run.bodies.map(() => []), matrix = new THREE.Matrix4();
    for (const { members, faces } of this.batches)
      members.forEach(({ body, part }, i) => {
        faces.getMatrixAt(i, matrix);
        found[body][part] = matrix.toArray().map((x, place) => (place > 11 && place < 15 ? x + this.origin[place - 12] : x));
      });
    return found;
  }

  // A rim of light around the selected body.
  choose(chosen) {
    this.chosen = chosen;
    this.halo.clear();
    this.halo.matrixAutoUpdate = false;
    const material = new THREE.MeshBasicMaterial({ color: ACCENT, side: THREE.BackSide });
    for (const { form, members, sheet } of this.batches)
      for (const { body, local } of members) {
        if (body !== chosen || sheet || this.run.bodies.length < 2) continue;
        const rim = new THREE.Mesh(this.forms[form].faces, material);
        rim.matrixAutoUpdate = false;
        rim.matrix.copy(local).multiply(new THREE.Matrix4().makeScale(MARGIN, MARGIN, MARGIN));
        this.halo.add(rim);
      }
  }

  // The body that a ray meets first; undefined for none.
  met(ray) {
    const meshes = this.batches.filter(batch => !batch.translucent).map(batch => batch.faces);
    const [first] = ray.intersectObjects(meshes, false);
    return first && first.object.userData.members[first.instanceId].body;
  }
}

function batchesOf(run) {
  const batches = new Map(), one = new THREE.Vector3(1, 1, 1);
  run.bodies.forEach((body, index) => {
    body.parts.forEach((part, order) => {
      const key = `${part.form} ${part.translucent ?? false} ${body.ground ?? false}`;
      if (!batches.has(key)) batches.set(key, { form: part.form, translucent: part.translucent, sheet: body.ground, members: [] });
      const local = new THREE.Matrix4().compose(new THREE.Vector3(...part.at), new THREE.Quaternion(...part.turn), one);
      batches.get(key).members.push({ body: index, part: order, local });
    });
  });
  return [...batches.values()];
}

// Body axes as arrows: x red, y green, z blue, from the centre of mass.
class Triads {
  constructor(run) {
    this.owners = run.bodies.flatMap((body, index) => (body.axes > 0 ? [index] : []));
    this.lengths = run.bodies.map(body => body.axes);
    const material = new THREE.MeshLambertMaterial({ emissive: 0x222222 });
    this.mesh = new THREE.InstancedMesh(arrowGeometry(), material, 3 * this.owners.length);
    this.mesh.frustumCulled = false;
    const color = new THREE.Color();
    for (let i = 0; i < 3 * this.owners.length; i++) this.mesh.setColorAt(i, color.set(AXES[i % 3]));
  }

  place(places, origin) {
    const seen = [0, 0, 0], matrix = new THREE.Matrix4();
    const position = new THREE.Vector3(), turn = new THREE.Quaternion(), size = new THREE.Vector3();
    this.owners.forEach((body, i) => {
      const length = this.lengths[body], thick = 0.05 * length;
      position.fromArray(from(origin, places[body].position, seen));
      for (let axis = 0; axis < 3; axis++) {
        turn.fromArray(places[body].orientation).multiply(TO_AXIS[axis]);
        this.mesh.setMatrixAt(3 * i + axis, matrix.compose(position, turn, size.set(thick, thick, length)));
      }
    });
    this.mesh.instanceMatrix.needsUpdate = true;
  }
}

const Z = new THREE.Vector3(0, 0, 1);
const TO_AXIS = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(axis => new THREE.Quaternion().setFromUnitVectors(Z, new THREE.Vector3(...axis)));

// The axes of the world at its origin, or of the corner.
export function worldTriad(length) {
  const group = new THREE.Group();
  AXES.forEach((color, axis) => {
    const arrow = new THREE.Mesh(arrowGeometry(), new THREE.MeshBasicMaterial({ color }));
    arrow.quaternion.copy(TO_AXIS[axis]);
    arrow.scale.set(0.035 * length, 0.035 * length, length);
    group.add(arrow);
  });
  return group;
}
