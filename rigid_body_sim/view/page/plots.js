// Plots of the selected body, linked with the time: each shows its values now, and a click goes to a time.
import uPlot from 'uplot';
import { AXES } from 'view/palette';
import { arrayOf, rotate } from 'view/run';

const XYZ = ['x', 'y', 'z'];
const DEGREES = [1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 0.01, 0.1, 0.5, 1, 2, 5, 10, 20, 45, 90, 180];
const HEIGHT = 118;                     // [CSS pixel]
const NO_DRIFT = 1e-17;                 // [-] zero has no place on a logarithmic axis: it is drawn here, and told as 0

// What is plotted of a body: title, unit, names of the components, and how to read them at an instant.
const OF_BODY = [
  { series: 'position', title: 'position', unit: 'm' },
  { series: 'orientation', title: 'attitude' },
  { series: 'velocity', title: 'velocity', unit: 'm/s' },
  { series: 'angular_velocity_body', title: 'angular velocity, body axes', unit: 'rad/s' },
  { series: 'angular_momentum', title: 'angular momentum about the centre of mass, world axes', unit: 'kg m²/s' },
  { series: 'force', title: 'commanded force', unit: 'N' },
  { series: 'torque', title: 'commanded torque', unit: 'N m' },
];

export class Plots {
  constructor(run, seek) {
    this.run = run;
    this.seek = seek;
    this.holder = document.getElementById('plots');
    this.attitude = document.getElementById('attitude');
    this.all = [];
    new ResizeObserver(() => this.resize()).observe(this.holder);
  }

  choose(body) {
    this.body = body;
    for (const plot of this.all) plot.remove();
    this.all = [...this.ofBody(), ...this.ofRun()].map(told => new Plot(this.holder, told, this.seek));
  }

  ofBody() {
    return OF_BODY.flatMap(told => {
      if (told.series === 'orientation') return this.run.bodies[this.body].axes > 0 ? [this.turning()] : [];
      if (told.series === 'angular_velocity_body') return this.rates(told);
      if (!this.run.series[told.series]) return [];
      const columns = columnsOf(this.run, told.series, this.body, 3);
      const idle = columns.every(column => column.every(x => x === 0));
      if (idle && told.series !== 'position') return [];
      return [{ ...told, names: XYZ, colors: AXES, times: this.run.times, columns }];
    });
  }

  // Angular velocity in body axes: R^T w
  rates(told) {
    const world = columnsOf(this.run, 'angular_velocity', this.body, 3);
    if (world.every(column => column.every(x => x === 0))) return [];
    const [x, y, z, w] = columnsOf(this.run, 'orientation', this.body, 4), columns = [[], [], []];
    this.run.times.forEach((_, k) => {
      const inBody = rotate([-x[k], -y[k], -z[k], w[k]], world.map(column => column[k]), []);
      inBody.forEach((rate, j) => columns[j].push(rate));
    });
    return [{ ...told, names: XYZ, colors: AXES, times: this.run.times, columns }];
  }

  turning() {
    const quaternions = columnsOf(this.run, 'orientation', this.body, 4);
    const told = { title: 'attitude', times: this.run.times };
    if (this.attitude.value === 'quaternion')
      return { ...told, title: 'attitude, body to world', unit: '–', names: [...XYZ, 'w'], colors: [...AXES, 'var(--ink)'], columns: quaternions };
    return { ...told, title: 'attitude: roll, pitch, yaw', unit: '°', names: ['roll', 'pitch', 'yaw'], colors: AXES, columns: angles(quaternions) };
  }

  // Of all bodies together: energies, works, drifts.
  ofRun() {
    return this.run.curves.map(told => {
      const columns = told.curves.map(curve => Array.from(this.read(curve.values)));
      return {
        title: told.title, unit: told.unit, logarithmic: told.logarithmic, times: this.read(told.time), columns,
        names: told.curves.map(curve => curve.name), colors: told.curves.map(curve => curve.color), dashes: told.curves.map(curve => curve.dash),
      };
    });
  }

  read(entry) {
    return typeof entry === 'string' ? this.run.series[entry].values : arrayOf(entry, this.run.buffer);
  }

  show(time) {
    for (const plot of this.all) plot.show(time);
  }

  resize() {
    for (const plot of this.all) plot.resize();
  }

  paint() {
    for (const plot of this.all) plot.drawing.redraw(false);
  }
}

function columnsOf(run, name, body, width) {
  const { values } = run.series[name], n = run.bodies.length;
  const shift = name === 'position' ? run.origins[body] : null;
  return Array.from({ length: width }, (_, j) =>
    Array.from({ length: run.instants }, (_, k) => values[width * (k * n + body) + j] + (shift ? shift[j] : 0)));
}

// Roll about x, pitch about y, yaw about z [degree] with R = Rz Ry Rx; a line is broken where an angle wraps.
function angles([x, y, z, w]) {
  const degrees = 180 / Math.PI, columns = [[], [], []];
  x.forEach((_, k) => {
    const pitch = Math.asin(Math.min(1, Math.max(-1, 2 * (w[k] * y[k] - z[k] * x[k]))));
    columns[0].push(degrees * Math.atan2(2 * (w[k] * x[k] + y[k] * z[k]), 1 - 2 * (x[k] ** 2 + y[k] ** 2)));
    columns[1].push(degrees * pitch);
    columns[2].push(degrees * Math.atan2(2 * (w[k] * z[k] + x[k] * y[k]), 1 - 2 * (y[k] ** 2 + z[k] ** 2)));
  });
  for (const column of columns)
    for (let k = column.length - 1; k > 0; k--) if (Math.abs(column[k] - column[k - 1]) > 180) column[k] = null;
  return columns;
}

// Short enough for its place: three to six digits and a power where it needs one.
export function figure(x, digits = 5) {
  if (x === null || x === undefined || Number.isNaN(x)) return '–';
  if (x === 0) return '0';
  const size = Math.abs(x);
  if (size >= 1e6 || size < 1e-3) return x.toExponential(2).replace(/\.?0+e/, 'e').replace('+', '');
  return x.toPrecision(digits).replace(/(\.\d*?)0+$/, '$1').replace(/\.$/, '');
}

function resolved(color) {
  const name = /^var\((.*)\)$/.exec(color)?.[1];
  return name ? getComputedStyle(document.body).getPropertyValue(name) : color;
}

class Plot {
  constructor(holder, told, seek) {
    this.told = told;
    this.element = document.createElement('figure');
    this.element.innerHTML = `<figcaption><span class="title"></span><span class="values"></span></figcaption><div class="chart"></div>`;
    this.element.querySelector('.title').textContent = `${told.title} [${told.unit}]`;
    this.values = told.names.map((name, i) => {
      const item = document.createElement('span');
      item.innerHTML = '<i></i><em></em> <b></b>';
      item.style.setProperty('--curve', told.colors[i]);
      item.querySelector('em').textContent = name;
      if (told.dashes?.[i].length) item.classList.add('dashed');
      this.element.querySelector('.values').append(item);
      return item.querySelector('b');
    });
    holder.append(this.element);
    this.chart = this.element.querySelector('.chart');
    this.drawing = new uPlot(this.options(), [Array.from(told.times), ...drawn(told)], this.chart);
    this.now = document.createElement('div');
    this.now.className = 'now';
    this.drawing.over.append(this.now);
    this.seekable(seek);
  }

  options() {
    const { told } = this, grid = { stroke: () => resolved('var(--grid)'), width: 1 }, ticks = { show: false };
    const axis = { stroke: () => resolved('var(--faint)'), grid, ticks, font: '11px system-ui, sans-serif' };
    return {
      width: Math.max(120, this.chart.clientWidth), height: HEIGHT, padding: [6, 8, 0, 0],
      legend: { show: false },
      cursor: { drag: { x: false, y: false }, points: { size: 5 }, y: false },
      scales: {
        x: { time: false, range: (_, low, high) => (high > low ? [low, high] : [low, low + 1]) },
        y: told.logarithmic ? { distr: 3, range: (_, low, high) => [0.5 * (low || NO_DRIFT), 2 * (high || 100 * NO_DRIFT)] } : { range: (_, low, high) => calm(low, high) },
      },
      axes: [
        { ...axis, size: 22, gap: 2, values: (_, all) => all.map(x => figure(x, 6)) },
        { ...axis, size: 62, gap: 4, space: 26, ...(told.logarithmic && { splits: decades, filter: (_, all) => all }), ...(told.unit === '°' && { incs: DEGREES }), values: (_, all) => all.map(x => (x === null ? null : figure(x, 6))) },
      ],
      series: [{}, ...told.names.map((_, i) => ({
        stroke: () => resolved(told.colors[i]), width: 1.5, dash: told.dashes?.[i] ?? [], points: { show: false }, spanGaps: false,
      }))],
    };
  }

  seekable(seek) {
    const { over } = this.drawing;
    const go = event => {
      const box = over.getBoundingClientRect();
      seek(this.drawing.posToVal(Math.min(Math.max(event.clientX - box.left, 0), box.width), 'x'));
    };
    over.addEventListener('pointerdown', event => {
      over.setPointerCapture(event.pointerId);
      go(event);
    });
    over.addEventListener('pointermove', event => { if (event.buttons) go(event); });
  }

  show(time) {
    const { times, columns } = this.told, k = indexAt(times, time);
    this.values.forEach((item, i) => { item.textContent = figure(columns[i][k]); });
    const x = this.drawing.valToPos(Math.min(Math.max(time, times[0]), times[times.length - 1]), 'x');
    this.now.style.transform = `translateX(${x}px)`;
  }

  resize() {
    if (this.chart.clientWidth) this.drawing.setSize({ width: this.chart.clientWidth, height: HEIGHT });
  }

  remove() {
    this.drawing.destroy();
    this.element.remove();
  }
}

// Columns as an axis can bear them.
function drawn({ columns, logarithmic }) {
  return logarithmic ? columns.map(column => column.map(x => Math.max(x, NO_DRIFT))) : columns;
}

// At most five powers of ten for a logarithmic axis.
function decades(_, __, low, high) {
  const first = Math.ceil(Math.log10(low)), last = Math.floor(Math.log10(high)), every = Math.max(1, Math.ceil((last - first) / 4));
  return Array.from({ length: Math.max(1, Math.floor((last - first) / every) + 1) }, (_, i) => 10 ** (first + i * every));
}

// Last instant not after a time.
function indexAt(times, time) {
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= time + 1e-12) low = middle; else high = middle - 1;
  }
  return low;
}

// Round-off is not blown up: an axis spans at least a millionth of its values.
function calm(low, high) {
  if (low === null || high === null || (low === 0 && high === 0)) return [-1, 1];
  const least = 1e-6 * Math.max(Math.abs(low), Math.abs(high), 1e-9), middle = 0.5 * (low + high);
  const half = 0.55 * Math.max(high - low, least);
  return [middle - half, middle + half];
}
