// Geometry of the forms of a run: solid faces with a pattern that shows spin, and edges.
import * as THREE from 'three';
import { arrayOf } from 'view/run';

const PALE = 1, DARK = 0.62;            // of the body's colour: the two tones of the pattern
const MANY = 1500;                      // vertices: edges of finer surfaces would be a haze

function solid(form, buffer) {
  const upright = geometry => geometry.rotateX(Math.PI / 2);     // the axis is z here, y in the library
  switch (form.type) {
    case 'point':
    case 'sphere': return upright(new THREE.SphereGeometry(form.radius, 48, 24));
    case 'ellipsoid': return upright(new THREE.SphereGeometry(1, 48, 24)).scale(...form.radii);
    case 'box': return new THREE.BoxGeometry(...form.size);
    case 'cylinder': return upright(new THREE.CylinderGeometry(form.radius, form.radius, form.length, 48, 2));
    case 'capsule': return upright(new THREE.CapsuleGeometry(form.radius, form.length, 12, 48));
    default: return surface(form, buffer);
  }
}

function surface(form, buffer) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(arrayOf(form.vertices, buffer), 3));
  geometry.setIndex(new THREE.BufferAttribute(arrayOf(form.faces, buffer), 1));
  return geometry;
}

// Two tones, changing from octant to octant of the shape: a body of revolution that spins is seen to.
function patterned(geometry) {
  const faces = geometry.index ? geometry.toNonIndexed() : geometry;
  const p = faces.attributes.position, tones = new Float32Array(3 * p.count);
  for (let i = 0; i < p.count; i += 3) {
    let sign = 1;
    for (const axis of ['getX', 'getY', 'getZ']) {
      const corners = [p[axis](i), p[axis](i + 1), p[axis](i + 2)];
      const across = axis === 'getZ' && Math.min(...corners) < 0 && Math.max(...corners) > 0;
      if (!across && corners[0] + corners[1] + corners[2] < 0) sign = -sign;
    }
    tones.fill(sign > 0 ? PALE : DARK, 3 * i, 3 * i + 9);
  }
  faces.setAttribute('color', new THREE.BufferAttribute(tones, 3));
  return faces;
}

function plain(geometry) {
  const faces = geometry.index ? geometry.toNonIndexed() : geometry;
  faces.computeVertexNormals();
  faces.setAttribute('color', new THREE.BufferAttribute(new Float32Array(3 * faces.attributes.position.count).fill(1), 3));
  return faces;
}

// { faces, edges or null } of a form
export function geometryOf(form, buffer) {
  const round = ['sphere', 'ellipsoid', 'cylinder', 'capsule'].includes(form.type);
  const base = solid(form, buffer);
  const faces = round ? patterned(base) : plain(base);
  const angle = form.type === 'surface' && form.ground ? 1 : 25;
  const sharp = form.type === 'box' || form.type === 'cylinder' || (form.type === 'surface' && base.attributes.position.count < MANY);
  return { faces, edges: sharp ? new THREE.EdgesGeometry(base, angle) : null };
}

// An arrow along z from 0 to 1: thickness is scaled in x and y, so that length may change alone.
export function arrowGeometry(head = 0.22, shaft = 0.35) {
  const stem = new THREE.CylinderGeometry(shaft, shaft, 1 - head, 10).translate(0, (1 - head) / 2, 0);
  const tip = new THREE.ConeGeometry(1, head, 16).translate(0, 1 - head / 2, 0);
  return merged([stem, tip]).rotateX(Math.PI / 2);
}

// A coil of radius 1 along z from 0 to 1, which is to be drawn `long` times its radius: the wire is as thick either way.
export function coilGeometry(long) {
  const turns = Math.max(4, Math.round(0.75 * long));
  class Helix extends THREE.Curve {
    getPoint(t, target = new THREE.Vector3()) {
      const grown = Math.min(1, t / 0.06, (1 - t) / 0.06), angle = 2 * Math.PI * turns * t;
      return target.set(grown * Math.cos(angle), grown * Math.sin(angle), long * t);
    }
  }
  return new THREE.TubeGeometry(new Helix(), turns * 24, 0.13, 6).scale(1, 1, 1 / long);
}

function merged(parts) {
  const all = new THREE.BufferGeometry(), loose = parts.map(part => part.toNonIndexed());
  for (const name of ['position', 'normal']) {
    const values = loose.flatMap(part => Array.from(part.attributes[name].array));
    all.setAttribute(name, new THREE.Float32BufferAttribute(values, 3));
  }
  return all;
}
