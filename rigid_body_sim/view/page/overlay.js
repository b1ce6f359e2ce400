// What is written over the picture: names, the scale, what arrows mean.
import { roundNumber } from 'view/ground';
import { ARROWS } from 'view/palette';

const FEW = 14;                         // names; of more bodies only the selected one has its own
const LINE = 17;                        // [CSS pixel] between names that would cover each other

export class Overlay {
  constructor(run, stage) {
    this.run = run;
    this.stage = stage;
    this.scale = document.getElementById('scale');
    this.legend = document.getElementById('legend');
    const holder = document.getElementById('labels');
    this.labels = run.bodies.map(body => {
      const label = document.createElement('span');
      label.textContent = body.name;
      label.style.setProperty('--body', body.color ?? 'var(--faint)');
      label.hidden = true;
      holder.append(label);
      return label;
    });
  }

  names(places, chosen, visible) {
    const taken = [], order = this.run.bodies.map((_, index) => index).sort((a, b) => (b === chosen) - (a === chosen));
    for (const body of order) {
      const label = this.labels[body];
      const wanted = visible && this.run.bodies.length > 1 && (body === chosen || (this.run.bodies.length <= FEW && this.run.bodies[body].parts.length > 0 && !this.run.bodies[body].ground));
      const { x, y, inside } = wanted ? this.stage.project(places[body].position) : {};
      label.hidden = !wanted || !inside;
      label.classList.toggle('chosen', body === chosen);
      if (label.hidden) continue;
      const width = 8 * this.run.bodies[body].name.length, right = Math.min(x + 10, this.stage.element.clientWidth - width - 12);
      let low = y + 6;
      while (taken.some(other => Math.abs(other.low - low) < LINE && Math.abs(other.right - right) < width)) low += LINE;
      taken.push({ low, right });
      label.hidden = low > this.stage.element.clientHeight - LINE;
      label.style.transform = `translate(${right}px, ${low}px)`;
    }
  }

  measure() {
    const metres = roundNumber(110 * this.stage.metresPerPixel), width = metres / this.stage.metresPerPixel;
    this.scale.style.width = `${width}px`;
    const unit = metres >= 1000 ? [metres / 1000, 'km'] : metres >= 0.1 ? [metres, 'm'] : metres >= 1e-3 ? [metres * 1e3, 'mm'] : [metres * 1e6, 'µm'];
    this.scale.firstElementChild.textContent = `${Number(unit[0].toPrecision(1))} ${unit[1]}`;
  }

  arrows(arrows, visible) {
    const rows = arrows.kinds.filter(visible).map(kind => {
      const worth = arrows.meaning(kind, this.run.arrow);
      return worth && `<i style="background:${ARROWS[kind].color}"></i>${ARROWS[kind].name}<b>${worth}</b>`;
    });
    const text = rows.filter(Boolean).map(row => `<div>${row}</div>`).join('');
    const head = text && `<div class="head">an arrow of ${Number(this.run.arrow.toPrecision(2))} m is</div>`;
    if (this.said !== head + text) this.legend.innerHTML = this.said = head + text;
  }
}
