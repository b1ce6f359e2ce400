// A plane of the world: a sheet that fades into the distance, a grid with metres in it, and shadow.
import * as THREE from 'three';

const FAR = 30;                         // [-] radius of the sheet, in sizes of what is seen

const GRID = {
  vertexShader: `
    varying vec2 place;
    varying vec2 away;
    uniform vec2 middle;
    void main() {
      away = position.xy;
      place = position.xy + middle;
      gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
    }`,
  fragmentShader: `
    varying vec2 place;
    varying vec2 away;
    uniform float cell, radius;
    uniform vec3 color;
    float lines(float size, float width) {
      vec2 at = place / size, wide = fwidth(at);
      vec2 off = abs(fract(at - 0.5) - 0.5) / max(wide, 1e-9);
      float clear = 1.0 - smoothstep(0.15, 0.6, max(wide.x, wide.y));
      return clear * (1.0 - clamp(min(off.x, off.y) - width + 0.5, 0.0, 1.0));
    }
    void main() {
      float far = length(away) / radius;
      float seen = max(0.45 * lines(cell, 0.5), 0.95 * lines(10.0 * cell, 0.8));
      gl_FragColor = vec4(color, seen * (1.0 - smoothstep(0.05, 0.6, far)));
      #include <colorspace_fragment>
    }`,
};

// 1, 2 or 5 times a power of ten, not above x
export function roundNumber(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  return power * [5, 2, 1].find(step => step * power <= x * (1 + 1e-9));
}

export class Ground {
  constructor(told) {
    this.normal = new THREE.Vector3(...told.normal);
    this.group = new THREE.Group();
    this.turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), this.normal);
    this.foot = this.normal.clone().multiplyScalar(told.offset);
    const pushed = { polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2, side: THREE.DoubleSide };
    this.sheet = new THREE.Mesh(fadingDisc(), new THREE.MeshBasicMaterial({ vertexColors: true, transparent: true, depthWrite: true, ...pushed }));
    this.shade = new THREE.Mesh(new THREE.CircleGeometry(1, 64), new THREE.ShadowMaterial({ transparent: true, depthWrite: false }));
    this.grid = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), new THREE.ShaderMaterial({
      ...GRID, transparent: true, depthWrite: false, side: THREE.DoubleSide,
      uniforms: { middle: { value: new THREE.Vector2() }, cell: { value: 1 }, radius: { value: 1 }, color: { value: new THREE.Color() } },
    }));
    this.shade.receiveShadow = true;
    this.sheet.renderOrder = -3;
    this.grid.renderOrder = -2;
    this.shade.renderOrder = -1;
    this.group.add(this.sheet, this.grid, this.shade);
    this.group.quaternion.copy(this.turn);
  }

  paint(colors) {
    this.sheet.material.color.set(colors.ground);
    this.grid.material.uniforms.color.value.set(colors.line);
    this.shade.material.opacity = colors.shadow;
  }

  // Lie below what is looked at, in cells that fit to how much is seen [m].
  under(target, seen) {
    const local = target.clone().sub(this.foot).applyQuaternion(this.turn.clone().invert());
    const radius = FAR * Math.max(seen, 0.5 * Math.abs(local.z));
    local.z = 0;
    this.group.position.copy(local).applyQuaternion(this.turn).add(this.foot);
    const { uniforms } = this.grid.material;
    for (const mesh of [this.sheet, this.shade]) mesh.scale.setScalar(radius);
    if (this.spanned !== radius) {
      this.grid.geometry.dispose();
      this.grid.geometry = new THREE.PlaneGeometry(2 * radius, 2 * radius);
      this.spanned = radius;
    }
    const cell = roundNumber(seen / 6);
    uniforms.middle.value.set(local.x % (10 * cell), local.y % (10 * cell));    // far away single precision has no cells
    uniforms.radius.value = radius;
    uniforms.cell.value = cell;
    return uniforms.cell.value;
  }
}

function fadingDisc() {
  const geometry = new THREE.RingGeometry(0, 1, 96, 12), { position } = geometry.attributes;
  const colors = new Float32Array(4 * position.count).fill(1);
  for (let i = 0; i < position.count; i++) {
    const far = Math.hypot(position.getX(i), position.getY(i));
    colors[4 * i + 3] = Math.max(0, 1 - Math.max(0, (far - 0.2) / 0.8)) ** 1.5;
  }
  geometry.setAttribute('color', new THREE.BufferAttribute(colors, 4));
  return geometry;
}
