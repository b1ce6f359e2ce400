// Colours of the drawing that differ in light and dark; those of bodies come with the run.

const THEMES = {
  light: { background: 0xf7f8fa, ground: 0xe6e9ee, line: 0x9aa5b4, ink: 0x1d2430, fixed: 0xb4bcc8, shadow: 0.26, sky: 0xffffff, below: 0xb9c0cc, sun: 2.5, fill: 2.3 },
  dark: { background: 0x12161d, ground: 0x1c222c, line: 0x4a5669, ink: 0xdfe5ee, fixed: 0x6d7888, shadow: 0.5, sky: 0xe6ecff, below: 0x6b7484, sun: 2.3, fill: 1.9 },
};

export const AXES = ['#e5383b', '#2a9d4a', '#3a78e7'];        // x, y, z

// What kind of arrow, its colour and the word for it.
export const ARROWS = {
  command_force: { color: '#e8590c', name: 'commanded force', unit: 'N' },
  command_torque: { color: '#7048e8', name: 'commanded torque', unit: 'N m' },
  contact: { color: '#f2b705', name: 'contact force', unit: 'N' },
  drag: { color: '#0ca6a0', name: 'drag', unit: 'N' },
  drag_torque: { color: '#087f7a', name: 'drag torque', unit: 'N m' },
  drive: { color: '#d6336c', name: 'driving force', unit: 'N' },
  drive_torque: { color: '#a61e4d', name: 'driving torque', unit: 'N m' },
  velocity: { color: '#37b24d', name: 'velocity', unit: 'm/s' },
  angular_velocity: { color: '#22a7d0', name: 'angular velocity', unit: 'rad/s' },
  angular_momentum: { color: '#b08900', name: 'angular momentum', unit: 'kg m²/s' },
};

export const IMPACT = { color: '#e03131', name: 'impacts' };

export class Theme {
  constructor(apply) {
    this.apply = apply;
    this.system = window.matchMedia('(prefers-color-scheme: dark)');
    this.system.addEventListener('change', () => this.chosen || this.set());
    document.getElementById('theme').onclick = () => this.toggle();
    this.chosen = new URLSearchParams(location.hash.slice(1)).get('theme');
  }

  get name() {
    if (this.chosen === 'light' || this.chosen === 'dark') return this.chosen;
    return this.system.matches ? 'dark' : 'light';
  }

  get colors() { return THEMES[this.name]; }

  set() {
    document.documentElement.dataset.theme = this.name;
    this.apply(this.colors);
  }

  toggle() {
    this.chosen = this.name === 'dark' ? 'light' : 'dark';
    this.set();
  }
}
