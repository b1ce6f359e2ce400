'use strict';
// Plots as SVG and tables that sort; needs nothing but this page.
const SVG = 'http://www.w3.org/2000/svg';
const NARROW = 620;  // [px] below, curves bear no names: the legend has them
const NEAR = 28;     // [px] from which a point answers to the pointer

function node(name, attributes, parent, text) {
  const made = document.createElementNS(SVG, name);
  for (const key in attributes) made.setAttribute(key, attributes[key]);
  if (text !== undefined) made.textContent = text;
  if (parent) parent.appendChild(made);
  return made;
}

function markPath(mark, r) {
  const polygon = points => 'M' + points.map(([x, y]) => `${(x * r).toFixed(2)},${(y * r).toFixed(2)}`).join('L') + 'Z';
  switch (mark) {
    case 's': return polygon([[-.9, -.9], [.9, -.9], [.9, .9], [-.9, .9]]);
    case '^': return polygon([[0, -1.15], [1.05, .85], [-1.05, .85]]);
    case 'v': return polygon([[0, 1.15], [1.05, -.85], [-1.05, -.85]]);
    case 'D': return polygon([[0, -1.2], [1.2, 0], [0, 1.2], [-1.2, 0]]);
    case 'P': return polygon([[-.4, -1.1], [.4, -1.1], [.4, -.4], [1.1, -.4], [1.1, .4], [.4, .4], [.4, 1.1], [-.4, 1.1], [-.4, .4], [-1.1, .4], [-1.1, -.4], [-.4, -.4]]);
    case 'X': return polygon([[-.5, -1.1], [0, -.6], [.5, -1.1], [1.1, -.5], [.6, 0], [1.1, .5], [.5, 1.1], [0, .6], [-.5, 1.1], [-1.1, .5], [-.6, 0], [-1.1, -.5]]);
    case '*': return polygon(Array.from({length: 10}, (_, i) => {
      const size = i % 2 ? .7 : 1.7, angle = Math.PI * (i / 5 - .5);
      return [size * Math.cos(angle), size * Math.sin(angle)];
    }));
    default: return `M${-r},0a${r},${r} 0 1,0 ${2 * r},0a${r},${r} 0 1,0 ${-2 * r},0Z`;
  }
}

function logScale(values, from, to, room) {
  const low = Math.log10(Math.min(...values)) - room, high = Math.log10(Math.max(...values)) + room;
  const scale = value => from + (Math.log10(value) - low) / (high - low) * (to - from);
  const every = Math.max(1, Math.ceil((high - low) / (Math.abs(to - from) / 55)));
  scale.ticks = [];
  for (let power = Math.ceil(low); power <= Math.floor(high); power++)
    if (power % every === 0) scale.ticks.push(power);
  return scale;
}

function power(parent, x, y, exponent, anchor) {
  const text = node('text', {x, y, 'text-anchor': anchor, fill: '#57606a'}, parent);
  node('tspan', {}, text, '10');
  node('tspan', {dy: -5, 'font-size': 9}, text, String(exponent).replace('-', '\u2212'));
}

// names of curves: each tries the places about its own points and takes the one that covers least
function placeNames(curves, bounds) {
  const marks = curves.flatMap(curve => curve.at);
  const taken = [], inside = (box, [x, y]) => x > box[0] && x < box[2] && y > box[1] && y < box[3];
  const lines = curves.flatMap(curve => curve.at.slice(1).flatMap(([x, y], i) => {
    const [u, v] = curve.at[i], count = Math.max(2, Math.ceil(Math.hypot(x - u, y - v) / 6));
    return Array.from({length: count}, (_, k) => [u + (x - u) * k / count, v + (y - v) * k / count]);
  }));
  for (const curve of curves.filter(one => one.out)) {
    const width = curve.label.length * (curve.ours ? 7.4 : 6.6) + 6, height = 14;
    let best = null;
    [...curve.at].reverse().forEach(([px, py], later) => {
      for (const [sx, sy] of [[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, 1], [1, -1], [-1, -1]]) {
        const x = px + sx * (width / 2 + 6), y = py + sy * (height / 2 + 6);
        const box = [x - width / 2, y - height / 2, x + width / 2, y + height / 2];
        let cost = .4 * later;
        for (const other of taken)
          if (box[0] < other[2] && other[0] < box[2] && box[1] < other[3] && other[1] < box[3]) cost += 1000;
        if (box[0] < bounds[0] || box[1] < bounds[1] || box[2] > bounds[2] || box[3] > bounds[3]) cost += 1000;
        for (const at of marks) if (inside(box, at)) cost += 8;
        for (const at of lines) if (inside(box, at)) cost += 3;
        if (!best || cost < best.cost) best = {cost, x, y, box};
      }
    });
    if (best && best.cost < 1000) { taken.push(best.box); curve.name = best; } else { curve.name = null; }
  }
}

function draw(figure, plot, hidden) {
  const svg = figure.querySelector('svg');
  const width = Math.max(300, figure.clientWidth), height = Math.min(560, Math.max(330, .58 * width));
  const left = 62, right = width - 14, top = 10, bottom = height - 44;
  svg.replaceChildren();
  figure.querySelector('.tip').hidden = true;
  svg.setAttribute('viewBox', `0 0 ${width} ${height}`);
  const seen = plot.series.filter((_, index) => !hidden.has(index));
  const all = seen.length ? seen : plot.series;
  const x = logScale(all.flatMap(one => one.points.map(point => point.x)), left, right, .35);
  const y = logScale(all.flatMap(one => one.points.map(point => point.y)), bottom, top, .5);
  const grid = node('g', {class: 'grid'}, svg);
  for (const tick of x.ticks) {
    const at = x(10 ** tick);
    node('line', {x1: at, x2: at, y1: top, y2: bottom, stroke: '#e6e9ec'}, grid);
    power(grid, at, bottom + 18, tick, 'middle');
  }
  for (const tick of y.ticks) {
    const at = y(10 ** tick);
    node('line', {x1: left, x2: right, y1: at, y2: at, stroke: '#e6e9ec'}, grid);
    power(grid, left - 8, at + 4, tick, 'end');
  }
  node('path', {d: `M${left},${top}V${bottom}H${right}`, fill: 'none', stroke: '#57606a'}, grid);
  node('text', {x: (left + right) / 2, y: height - 6, 'text-anchor': 'middle'}, svg, plot.x);
  node('text', {x: 13, y: (top + bottom) / 2, 'text-anchor': 'middle', transform: `rotate(-90 13 ${(top + bottom) / 2})`}, svg, plot.y);
  if (plot.front.length)
    node('path', {class: 'front', d: 'M' + plot.front.map(([u, v]) => `${x(u)},${y(v)}`).join('L') + (plot.front.length > 1 ? '' : 'h.1'),
      fill: 'none', stroke: '#f3e6a8', 'stroke-width': 12, 'stroke-linecap': 'round', 'stroke-linejoin': 'round'}, svg);
  const spots = [], curves = [];
  for (const one of [...seen].reverse()) {
    const group = node('g', {class: 'series', 'data-label': one.label}, svg);
    const at = one.points.map(point => [x(point.x), y(point.y)]);
    node('polyline', {points: at.map(pair => pair.map(value => value.toFixed(1)).join(',')).join(' '), fill: 'none', stroke: one.color,
      'stroke-width': one.out ? 2 : 1, ...(one.ours ? {} : {'stroke-dasharray': '5 3'})}, group);
    const shape = markPath(one.mark, one.out ? 4.2 : 2.4);
    at.forEach(([u, v], index) => {
      node('path', {d: shape, transform: `translate(${u.toFixed(1)} ${v.toFixed(1)})`, stroke: one.color,
        'stroke-width': 1.3, fill: one.ours ? one.color : '#fff'}, group);
      spots.push({u, v, one, point: one.points[index], group});
    });
    curves.unshift({...one, at, group});
  }
  if (width >= NARROW) {
    placeNames(curves, [left, top, right, bottom]);
    for (const curve of curves.filter(each => each.out && each.name))
      node('text', {x: curve.name.x, y: curve.name.y + 4, 'text-anchor': 'middle', fill: curve.ours ? curve.color : '#333',
        'font-weight': curve.ours ? 600 : 400, stroke: '#fff', 'stroke-width': 3, 'paint-order': 'stroke'}, svg, curve.label);
  }
  figure.spots = spots;
}

function watch(figure, plot) {
  const svg = figure.querySelector('svg'), tip = figure.querySelector('.tip');
  const leave = () => { tip.hidden = true; svg.querySelectorAll('.series').forEach(group => group.removeAttribute('opacity')); };
  const move = event => {
    const field = svg.getBoundingClientRect(), scale = svg.viewBox.baseVal.width / field.width;
    const u = (event.clientX - field.left) * scale, v = (event.clientY - field.top) * scale;
    let best = null, distance = NEAR;
    for (const spot of figure.spots) {
      const away = Math.hypot(spot.u - u, spot.v - v);
      if (away < distance) { best = spot; distance = away; }
    }
    if (!best) return leave();
    svg.querySelectorAll('.series').forEach(group => group.setAttribute('opacity', group === best.group ? 1 : .25));
    tip.replaceChildren();
    const head = document.createElement('b');
    head.textContent = best.one.label;
    tip.append(head);
    for (const line of best.point.lines) { tip.append(line, document.createElement('br')); }
    tip.hidden = false;
    const place = best.u / scale + 14, most = figure.clientWidth - tip.offsetWidth;
    tip.style.left = `${Math.max(0, place > most ? best.u / scale - tip.offsetWidth - 14 : place)}px`;
    tip.style.top = `${Math.max(0, best.v / scale - 10)}px`;
  };
  svg.addEventListener('pointermove', move);
  svg.addEventListener('pointerdown', move);
  svg.addEventListener('pointerleave', leave);
}

function legend(figure, plot, hidden) {
  const list = figure.querySelector('.legend');
  plot.series.forEach((one, index) => {
    const item = document.createElement('li'), button = document.createElement('button');
    button.type = 'button';
    button.setAttribute('aria-pressed', 'true');
    const sign = node('svg', {viewBox: '-12 -7 24 14', width: 24, height: 14, style: 'width:24px;height:14px'});
    node('line', {x1: -12, x2: 12, y1: 0, y2: 0, stroke: one.color, 'stroke-width': one.out ? 2 : 1, ...(one.ours ? {} : {'stroke-dasharray': '4 2'})}, sign);
    node('path', {d: markPath(one.mark, one.out ? 4 : 2.6), stroke: one.color, fill: one.ours ? one.color : '#fff'}, sign);
    button.append(sign, one.label);
    button.addEventListener('click', () => {
      const off = hidden.has(index);
      if (off) hidden.delete(index); else hidden.add(index);
      button.setAttribute('aria-pressed', String(off));
      draw(figure, plot, hidden);
    });
    item.append(button);
    list.append(item);
  });
}

function sortable(table) {
  const body = table.tBodies[0];
  [...table.tHead.rows[0].cells].forEach((head, column) => {
    const button = head.querySelector('button');
    if (!button) return;
    button.addEventListener('click', () => {
      const down = head.getAttribute('aria-sort') === 'ascending';
      for (const other of table.tHead.rows[0].cells) other.removeAttribute('aria-sort');
      head.setAttribute('aria-sort', down ? 'descending' : 'ascending');
      const value = row => {
        const cell = row.cells[column], number = cell.dataset.v;
        return number === undefined ? cell.textContent : number === '' ? null : Number(number);
      };
      const rows = [...body.rows].map((row, index) => ({row, index, value: value(row)}));
      rows.sort((a, b) => {
        if (a.value === null || b.value === null) return (a.value === null) - (b.value === null) || a.index - b.index;
        const order = typeof a.value === 'number' ? a.value - b.value : a.value.localeCompare(b.value);
        return (down ? -order : order) || a.index - b.index;
      });
      body.append(...rows.map(each => each.row));
    });
  });
}

const plots = JSON.parse(document.getElementById('report-data').textContent);
for (const figure of document.querySelectorAll('figure.plot')) {
  const plot = plots[figure.dataset.problem], hidden = new Set();
  if (!plot) continue;
  legend(figure, plot, hidden);
  watch(figure, plot);
  let width = 0;
  new ResizeObserver(() => {
    if (figure.clientWidth !== width) { width = figure.clientWidth; draw(figure, plot, hidden); }
  }).observe(figure);
  draw(figure, plot, hidden);
}
document.querySelectorAll('table.sortable').forEach(sortable);
