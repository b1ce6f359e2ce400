// Light, camera and drawing: a camera that keeps up upright and has in view what moves.
import * as THREE from 'three';
import { OrbitControls } from 'three/OrbitControls';
import { Ground, roundNumber } from 'view/ground';
import { worldTriad } from 'view/bodies';
import { AXES } from 'view/palette';

const VIEW = new THREE.Vector3(0.55, -1, 0.42).normalize();      // from what is looked at to the camera
const ROOM = 1.12;                      // [-] of the fit: a little air around it
const WANDERS = 4;                      // [-] a run that stays within so many sizes of its start is framed whole
const FEW = 60;                         // bodies whose axes have to be seen whole
const CORNER = 92;                      // [CSS pixel] of the axes in the corner

export class Stage {
  constructor(element, run) {
    this.element = element;
    this.run = run;
    this.renderer = new THREE.WebGLRenderer({ antialias: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFSoftShadowMap;
    this.renderer.autoClear = false;
    element.prepend(this.renderer.domElement);
    this.scene = new THREE.Scene();
    this.light();
    this.camera = new THREE.PerspectiveCamera(36, 1, 0.01, 1e4);
    this.camera.up.set(0, 0, 1);
    this.camera.position.copy(VIEW);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    Object.assign(this.controls, { enableDamping: true, dampingFactor: 0.12, zoomToCursor: false, rotateSpeed: 0.8 });
    this.controls.addEventListener('start', () => { this.untouched = false; });
    this.controls.addEventListener('change', () => { this.dirty = true; });
    this.grounds = run.planes.map(plane => new Ground(plane));
    for (const ground of this.grounds) this.scene.add(ground.group);
    this.axes = worldTriad(1);
    this.scene.add(this.axes);
    this.corner = cornerAxes();
    this.framing = new Framing(run);
    this.zoom = 1;
    this.untouched = true;
  }

  light() {
    this.sky = new THREE.HemisphereLight(0xffffff, 0x888888, 1);
    this.sky.position.set(0, 0, 1);
    this.sun = new THREE.DirectionalLight(0xffffff, 2);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(2048, 2048);
    this.sun.shadow.bias = -0.0004;
    this.sun.shadow.normalBias = 0.6;
    this.sun.shadow.radius = 3;
    this.scene.add(this.sky, this.sun, this.sun.target);
  }

  paint(colors) {
    this.scene.background = new THREE.Color(colors.background);
    this.sky.color.set(colors.sky);
    this.sky.groundColor.set(colors.below);
    this.sky.intensity = colors.fill;
    this.sun.intensity = colors.sun;
    for (const ground of this.grounds) ground.paint(colors);
    this.dirty = true;
  }

  resize() {
    const width = this.element.clientWidth, height = this.element.clientHeight;
    if (!width || !height) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.dirty = true;
  }

  // Distance at which a box (THREE.Box3) fits into the picture, seen along the present direction.
  fit(box) {
    const away = this.camera.position.clone().sub(this.controls.target).normalize();
    const right = new THREE.Vector3().crossVectors(this.camera.up, away).normalize();
    const above = new THREE.Vector3().crossVectors(away, right);
    const high = Math.tan((this.camera.fov * Math.PI) / 360), wide = high * this.camera.aspect;
    const half = box.getSize(new THREE.Vector3()).multiplyScalar(0.5 * ROOM);
    let distance = 1e-6;
    for (const x of [-1, 1]) for (const y of [-1, 1]) for (const z of [-1, 1]) {
      const corner = new THREE.Vector3(x * half.x, y * half.y, z * half.z);
      const needed = Math.max(Math.abs(corner.dot(right)) / wide, Math.abs(corner.dot(above)) / high);
      distance = Math.max(distance, needed + corner.dot(away));
    }
    return distance;
  }

  // Turn to everything, from where the run is looked at first or from a given direction.
  frame(places, direction = VIEW) {
    this.controls.enableDamping = false;      // what a drag left over ends here
    this.controls.update();
    this.controls.enableDamping = true;
    this.controls.target.set(0, 0, 0);
    this.camera.position.copy(direction);
    this.zoom = 1;
    this.untouched = true;
    this.follow(places, -1);
    this.controls.update();
  }

  // Go with what moves: the selected body, or a box around all. Direction and zoom stay the viewer's.
  follow(places, chosen) {
    const box = chosen >= 0 ? this.framing.around(chosen, places) : this.framing.box(places);
    const center = box.getCenter(new THREE.Vector3()), offset = this.camera.position.clone().sub(this.controls.target);
    const fitting = this.fit(box);
    if (this.fitted && !this.untouched) this.zoom *= offset.length() / this.placed;
    else this.zoom = 1;
    const distance = fitting * this.zoom;
    const shift = this.fitted && !this.untouched && this.center ? this.controls.target.clone().sub(this.center) : new THREE.Vector3();
    this.controls.target.copy(center).add(shift.multiplyScalar(this.fitted ? fitting / this.fitted : 1));
    this.center = center;
    this.camera.position.copy(this.controls.target).add(offset.setLength(distance));
    this.fitted = fitting;
    this.placed = distance;
    this.dirty = true;
  }

  // Where the picture is seen from in double precision (3) [m]: what is looked at.
  origin() { return this.controls.target.toArray(); }

  // Metres that a pixel shows at the distance of what is looked at.
  get metresPerPixel() {
    const distance = this.camera.position.distanceTo(this.controls.target);
    return (2 * distance * Math.tan((this.camera.fov * Math.PI) / 360)) / Math.max(1, this.element.clientHeight);
  }

  draw() {
    const distance = this.camera.position.distanceTo(this.controls.target);
    this.camera.near = distance / 100;
    this.camera.far = distance * 5000;
    this.camera.updateProjectionMatrix();
    const seen = 0.5 * this.metresPerPixel * Math.hypot(this.element.clientWidth, this.element.clientHeight);
    for (const ground of this.grounds) this.cell = ground.under(this.controls.target, seen);
    this.axes.scale.setScalar(this.originLength());
    this.axes.visible = this.showOrigin;
    const reach = Math.min(seen, 3 * this.framing.size) * 1.3;
    const sun = this.sun.shadow.camera;
    this.sun.target.position.copy(this.controls.target);
    this.sun.position.copy(this.controls.target).add(new THREE.Vector3(0.5, -0.35, 1).setLength(4 * reach));
    Object.assign(sun, { left: -reach, right: reach, top: reach, bottom: -reach, near: 0.1 * reach, far: 9 * reach });
    sun.updateProjectionMatrix();
    this.sun.shadow.normalBias = 0.0012 * reach;
    this.renderer.clear();
    this.fromOrigin(() => this.renderer.render(this.scene, this.camera));
    this.drawCorner();
  }

  // Do something while camera and scene are where they are as seen from the origin: the light of a
  // scene and its shadows take places in single precision.
  fromOrigin(work) {
    const { camera, scene, controls } = this, place = camera.position.clone();
    scene.position.copy(controls.target).negate();
    camera.position.sub(controls.target);
    work();
    camera.position.copy(place);
    camera.updateMatrixWorld();
  }

  originLength() {
    return Math.min(roundNumber(60 * this.metresPerPixel), 0.5 * this.framing.size || 1);
  }

  drawCorner() {
    const { renderer } = this, height = this.element.clientHeight;
    this.corner.camera.position.copy(this.camera.position).sub(this.controls.target).setLength(4);
    this.corner.camera.up.copy(this.camera.up);
    this.corner.camera.lookAt(0, 0, 0);
    renderer.clearDepth();
    renderer.setViewport(4, 4, CORNER, Math.min(CORNER, height));
    renderer.render(this.corner.scene, this.corner.camera);
    renderer.setViewport(0, 0, this.element.clientWidth, height);
  }

  // Where a point of the world is in the picture [CSS pixel], and whether it is in it.
  project(point) {
    const p = new THREE.Vector3().fromArray(point).project(this.camera);
    const x = (0.5 + 0.5 * p.x) * this.element.clientWidth, y = (0.5 - 0.5 * p.y) * this.element.clientHeight;
    return { x, y, inside: Math.abs(p.x) <= 1 && Math.abs(p.y) <= 1 && p.z < 1 };
  }

  // What is met by it is where it was drawn: as seen from the origin.
  ray(x, y) {
    const caster = new THREE.Raycaster();
    const at = new THREE.Vector2((2 * x) / this.element.clientWidth - 1, 1 - (2 * y) / this.element.clientHeight);
    this.fromOrigin(() => {
      this.camera.updateMatrixWorld();
      this.scene.updateMatrixWorld();
      caster.setFromCamera(at, this.camera);
    });
    return caster;
  }
}

// What has to be in view: a box around all instants where the run stays near its start, else around the present one.
class Framing {
  constructor(run) {
    this.run = run;
    this.watched = run.bodies.flatMap((body, index) => (body.watched ? [index] : []));
    this.anchors = run.ties.flatMap(tie => tie.kind === 'pivot' ? [tie.at] : [tie.a, tie.b].filter(end => end.body < 0).map(end => end.at));
    const first = this.boxAt(0);
    this.whole = new THREE.Box3();
    for (let k = 0; k < run.instants; k += Math.max(1, Math.floor(run.instants / 200))) this.whole.union(this.boxAt(k));
    this.whole.union(this.boxAt(run.instants - 1));
    this.size = first.getSize(new THREE.Vector3()).length();
    this.still = !run.live && this.whole.getSize(new THREE.Vector3()).length() <= WANDERS * this.size;
  }

  boxAt(k) {
    const box = new THREE.Box3(), moment = { k, next: k, s: 0 }, at = [0, 0, 0];
    const turn = [0, 0, 0, 1];
    for (const body of this.watched)
      this.include(box, body, this.run.position(body, moment, at), this.run.orientation(body, moment, turn));
    return this.complete(box);
  }

  box(places) {
    if (this.still) return this.whole;
    const box = new THREE.Box3();
    for (const body of this.watched) this.include(box, body, places[body].position, places[body].orientation);
    return this.complete(box);
  }

  // The corners of what is drawn of a body, and the tips of its axes.
  include(box, body, position, orientation) {
    const { low, high, axes } = this.run.bodies[body], center = new THREE.Vector3().fromArray(position);
    const turn = new THREE.Quaternion().fromArray(orientation), show = corner => box.expandByPoint(corner.applyQuaternion(turn).add(center));
    for (const x of [low[0], high[0]]) for (const y of [low[1], high[1]]) for (const z of [low[2], high[2]]) show(new THREE.Vector3(x, y, z));
    if (axes > 0 && this.run.bodies.length <= FEW)
      for (let axis = 0; axis < 3; axis++) show(new THREE.Vector3().setComponent(axis, axes));
  }

  complete(box) {
    for (const anchor of this.anchors) box.expandByPoint(new THREE.Vector3().fromArray(anchor));
    if (box.isEmpty()) box.set(new THREE.Vector3(-1, -1, -1), new THREE.Vector3(1, 1, 1));
    return box;
  }

  around(body, places) {
    const box = new THREE.Box3(), center = new THREE.Vector3().fromArray(places[body].position);
    const r = 2.2 * Math.max(this.run.bodies[body].extent, this.run.bodies[body].axes) || 1;
    return box.set(center.clone().addScalar(-r), center.addScalar(r));
  }
}

function cornerAxes() {
  const scene = new THREE.Scene(), camera = new THREE.PerspectiveCamera(40, 1, 0.1, 20);
  scene.add(worldTriad(1));
  ['x', 'y', 'z'].forEach((letter, axis) => {
    const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map: written(letter, AXES[axis]), depthTest: false }));
    sprite.position.setComponent(axis, 1.25);
    sprite.scale.setScalar(0.5);
    scene.add(sprite);
  });
  return { scene, camera };
}

function written(letter, color) {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = 64;
  const pen = canvas.getContext('2d');
  Object.assign(pen, { font: 'bold 46px system-ui, sans-serif', textAlign: 'center', textBaseline: 'middle', fillStyle: color });
  pen.fillText(letter, 32, 32);
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = THREE.SRGBColorSpace;
  return texture;
}
