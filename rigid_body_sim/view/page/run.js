// The recorded run: times, and numbers per instant that may grow while a run goes on.

const KINDS = { f4: Float32Array, f8: Float64Array, u4: Uint32Array };

const MOST_BYTES = 1 << 27, MOST_INSTANTS = 50000;     // of what a run that goes on has sent: of more, half

// An array that grows at its end, in a buffer that doubles: each number is copied a few times at most.
export class Growing {
  constructor(first, width = 1) {
    this.width = width;                 // numbers per row
    this.values = this.room = first;
  }

  append(more) {
    const { length } = this.values, needed = length + more.length;
    if (needed > this.room.length) {
      this.room = new this.room.constructor(2 * needed);
      this.room.set(this.values);
    }
    this.room.set(more, length);
    this.values = this.room.subarray(0, needed);
  }

  // Keeps so many numbers.
  cut(length) { this.values = this.room.subarray(0, length); }

  // Keeps some rows, given by their ascending numbers.
  keep(rows) {
    const { width } = this;
    rows.forEach((row, place) => this.room.copyWithin(width * place, width * row, width * (row + 1)));
    this.cut(width * rows.length);
  }
}

// An array out of the page: { kind, at [byte], size [numbers] }.
export function arrayOf(entry, buffer) {
  return new KINDS[entry.kind](buffer.slice(entry.at, entry.at + entry.size * KINDS[entry.kind].BYTES_PER_ELEMENT));
}

export class Run {
  constructor(record, buffer) {
    Object.assign(this, record);        // bodies, forms, ties, …: see playback_page.py
    this.buffer = buffer;
    this.series = {};
    for (const [name, entry] of Object.entries(record.series))
      this.series[name] = new Growing(arrayOf(entry, buffer), entry.width);
    this.grownContacts = [];            // who takes contacts that come while a run goes on
    this.grownImpacts = [];             // and impacts
    this.thinnings = [];                // who keeps things by instant, when some are left out
    this.origins = record.bodies.map(body => body.origin);
  }

  get times() { return this.series.time.values; }
  get instants() { return this.times.length; }
  get begin() { return this.times[0]; }
  get end() { return this.times[this.instants - 1]; }

  append(record, buffer) {
    for (const [name, entry] of Object.entries(record.series))
      this.series[name].append(arrayOf(entry, buffer));
    if (record.contacts) this.grownContacts.forEach(take => take(record.contacts, buffer));
    if (record.impacts) this.grownImpacts.forEach(take => take(record.impacts, buffer));
    const all = Object.values(this.series), bytes = all.reduce((sum, { values }) => sum + values.byteLength, 0);
    if (bytes < MOST_BYTES && this.instants < MOST_INSTANTS) return;
    const kept = this.evenly(this.instants >> 1);
    for (const series of all) series.keep(kept);
    this.thinnings.forEach(keep => keep(kept));
  }

  // Numbers of some instants, evenly over time: however often it is done, none become rare that are old.
  evenly(most) {
    const { times, begin, end } = this, step = (end - begin) / most, kept = [];
    let next = begin;
    times.forEach((time, k) => {
      if (time < next && k < times.length - 1) return;
      kept.push(k);
      next = begin + step * (Math.floor((time - begin) / step) + 1);
    });
    return kept;
  }

  // Where a time lies: { k, next, s } with times[k] <= time, s the fraction on the way to the next.
  moment(time) {
    const times = this.times;
    let low = 0, high = this.instants - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (times[middle] <= time + 1e-12) low = middle; else high = middle - 1;
    }
    const next = Math.min(low + 1, this.instants - 1);
    const span = times[next] - times[low];
    const s = span > 0 ? Math.min(Math.max((time - times[low]) / span, 0), 1) : 0;
    return { k: low, next, s, span };
  }

  nearest(time) {
    const { k, next, s } = this.moment(time);
    return s < 0.5 ? k : next;
  }

  // A vector (3 numbers from a body's row) between two instants, in double precision.
  vector(name, body, moment, out, origin) {
    const { values } = this.series[name], n = this.bodies.length;
    const a = 3 * (moment.k * n + body), b = 3 * (moment.next * n + body);
    for (let j = 0; j < 3; j++)
      out[j] = (1 - moment.s) * values[a + j] + moment.s * values[b + j] + (origin ? origin[j] : 0);
    return out;
  }

  position(body, moment, out) {
    return this.vector('position', body, moment, out, this.origins[body]);
  }

  // Orientation (xyzw) between two instants: on by the rotation vector from one to the other,
  // with as many whole turns as the recorded angular velocity tells.
  orientation(body, moment, out) {
    const { values } = this.series.orientation, n = this.bodies.length;
    const a = 4 * (moment.k * n + body), b = 4 * (moment.next * n + body);
    const q = [values[a], values[a + 1], values[a + 2], values[a + 3]];
    if (moment.s > 0) {
      const turn = turnBetween(q, [values[b], values[b + 1], values[b + 2], values[b + 3]]);
      const rate = this.series.angular_velocity.values, w = 3 * (moment.k * n + body), v = 3 * (moment.next * n + body);
      const told = 0.5 * moment.span * turn.axis.reduce((sum, e, j) => sum + e * (rate[w + j] + rate[v + j]), 0);
      const whole = Math.round((told - turn.angle) / (2 * Math.PI));
      const half = 0.5 * moment.s * (turn.angle + 2 * Math.PI * (Number.isFinite(whole) ? whole : 0));
      const sine = Math.sin(half);
      return multiply([turn.axis[0] * sine, turn.axis[1] * sine, turn.axis[2] * sine, Math.cos(half)], q, out);
    }
    for (let j = 0; j < 4; j++) out[j] = q[j];
    return out;
  }
}

// p q of quaternions xyzw
export function multiply(p, q, out) {
  const [a, b, c, d] = p, [e, f, g, h] = q;
  out[0] = d * e + a * h + b * g - c * f;
  out[1] = d * f - a * g + b * h + c * e;
  out[2] = d * g + a * f - b * e + c * h;
  out[3] = d * h - a * e - b * f - c * g;
  return out;
}

// Axis (world) and angle in [0, pi] of the shortest turn from p to q.
function turnBetween(p, q) {
  const r = multiply(q, [-p[0], -p[1], -p[2], p[3]], []);
  if (r[3] < 0) for (let j = 0; j < 4; j++) r[j] = -r[j];
  const sine = Math.hypot(r[0], r[1], r[2]);
  if (sine < 1e-12) return { axis: [0, 0, 1], angle: 0 };
  return { axis: [r[0] / sine, r[1] / sine, r[2] / sine], angle: 2 * Math.atan2(sine, r[3]) };
}

// A point as seen from another, in double precision.
export function from(origin, point, out) {
  for (let j = 0; j < 3; j++) out[j] = point[j] - origin[j];
  return out;
}

// v turned by q (xyzw), body axes to world
export function rotate(q, v, out) {
  const [x, y, z, w] = q, [a, b, c] = v;
  const tx = 2 * (y * c - z * b), ty = 2 * (z * a - x * c), tz = 2 * (x * b - y * a);
  out[0] = a + w * tx + y * tz - z * ty;
  out[1] = b + w * ty + z * tx - x * tz;
  out[2] = c + w * tz + x * ty - y * tx;
  return out;
}
