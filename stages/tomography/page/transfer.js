// The transfer function: colour and opacity of every density, linear between control points; and its file.
import { clamped, short } from './numbers.js';

export const kFormat = 'vitrine transfer function 1';
const kMostPoints = 64;
const kSoftSurface = 0.12;  // width of the ramp of a surface, share of its density
const kBone = '#efe6d2';

const point = (density, color, opacity) => ({ density, color, opacity });
export const channels = (color) => [1, 3, 5].map((i) => parseInt(color.slice(i, i + 2), 16));
const color_of = (rgb) => `#${rgb.map((v) => Math.round(clamped(v, 0, 255)).toString(16).padStart(2, '0')).join('')}`;

// A surface at that density, lit.
export function surface_at(volume, density) {
  const { low, high } = volume, half = Math.max((kSoftSurface * (density - low)) / 2, (high - low) / 500);
  const top = Math.max(high, density + 3 * half);
  return { lit: true, points: [point(low, kBone, 0), point(density - half, kBone, 0), point(density + half, kBone, 0.9), point(top, '#fffdf5', 1)] };
}
// Starts by name. `iso`: density between the material and the air.
export const kStarts = {
  surface: (volume) => surface_at(volume, volume.iso),
  'x-ray': ({ low, high, iso }) => ({
    lit: false, points: [point(low, '#dfe8f2', 0), point(low + 0.3 * (iso - low), '#dfe8f2', 0), point(iso, '#dfe8f2', 0.035), point(high, '#ffffff', 0.3)],
  }),
  // What there is most of is clear, the rest the more opaque the denser it is.
  soft: (volume) => {
    const { low, high, iso } = volume, usual = Math.max(volume.quantile(0.5), iso), dense = usual + 0.55 * (Math.max(volume.quantile(0.97), usual) - usual);
    return {
      lit: true,
      points: [point(low, '#7fb3cf', 0), point(iso - 0.4 * (iso - low), '#7fb3cf', 0), point(iso, '#8fc1d8', 0.04), point(usual, '#cfc3a4', 0.03),
        point(Math.max(dense, usual + 0.35 * (usual - low)), '#e0823c', 0.35), point(high, '#fff1c9', 0.95)],
    };
  },
};

export class Transfer {
  constructor(volume) {
    this.volume = volume, this.listeners = [];
    this.start('surface');
  }
  on_change(listener) {
    this.listeners.push(listener);
  }
  changed() {
    for (const f of this.listeners) f();
  }
  // `points` in any order; `chosen`: index of the point that the panel shows.
  set({ points, lit = this.lit }, chosen = 0, name = '') {
    this.points = [...points].sort((a, b) => a.density - b.density);
    this.lit = lit, this.chosen = clamped(chosen, 0, this.points.length - 1), this.name = name;
    this.changed();
  }
  start(name) {
    const { points, lit } = kStarts[name](this.volume);
    this.set({ points, lit }, points.length > 2 ? 2 : 0, name);
  }
  surface(density) {
    this.set(surface_at(this.volume, density), 2, 'surface');
  }

  choose(index) {
    this.chosen = index;
    this.changed();
  }
  // Moves or recolours a point; it stays between its neighbours and in the range of the densities.
  change(index, some) {
    const p = this.points[index], least = this.points[index - 1]?.density ?? this.volume.low, most = this.points[index + 1]?.density ?? this.volume.high;
    Object.assign(p, some);
    p.density = clamped(p.density, Math.min(least, most), Math.max(least, most)), p.opacity = clamped(p.opacity, 0, 1);
    this.chosen = index, this.name = '';
    this.changed();
  }
  add(density, opacity) {
    if (this.points.length >= kMostPoints) return;
    const added = point(density, color_of(this.at(density).rgb), opacity), after = this.points.findIndex((p) => p.density > density);
    const index = after < 0 ? this.points.length : after;
    this.points.splice(index, 0, added);
    this.chosen = index, this.name = '';
    this.changed();
  }
  // Two points remain.
  remove(index) {
    if (this.points.length <= 2) return;
    this.points.splice(index, 1);
    this.chosen = Math.min(index, this.points.length - 1), this.name = '';
    this.changed();
  }
  set_lit(lit) {
    this.lit = lit;
    this.changed();
  }

  // {rgb: 0 to 255, opacity} at a density; before the first and after the last point that of the point.
  at(density) {
    const next = this.points.findIndex((p) => p.density > density);
    if (next <= 0) {
      const p = this.points.at(next < 0 ? -1 : 0);
      return { rgb: channels(p.color), opacity: p.opacity };
    }
    const [a, b] = [this.points[next - 1], this.points[next]], t = (density - a.density) / (b.density - a.density);
    const from = channels(a.color), to = channels(b.color);
    return { rgb: from.map((v, c) => v + t * (to[c] - v)), opacity: a.opacity + t * (b.opacity - a.opacity) };
  }
  // Colours [4 n], 0 to 255, and opacities [n] from the lowest to the highest density.
  table(n) {
    const { low, high } = this.volume, colors = new Uint8Array(4 * n), opacities = new Float32Array(n);
    for (let i = 0; i < n; ++i) {
      const { rgb, opacity } = this.at(low + (i / (n - 1)) * (high - low));
      colors.set([...rgb, 255], 4 * i), opacities[i] = opacity;
    }
    return { colors, opacities };
  }

  json() {
    const { unit } = this.volume, points = this.points.map(({ density, color, opacity }) => ({ density: Number(density.toPrecision(7)), color, opacity: Number(opacity.toFixed(4)) }));
    return `${JSON.stringify({ format: kFormat, density_unit: `1/${unit}`, lit: this.lit, points }, null, 1)}\n`;
  }
}

const kMetres = { um: 1e-6, mm: 1e-3, cm: 1e-2, m: 1 };

// Points and lit of a saved function, in the unit of the volume. Throws an error whose message is one sentence for the user.
export function read_transfer(text, unit) {
  let file;
  try {
    file = JSON.parse(text);
  } catch {
    throw new Error('it is not JSON');
  }
  if (file === null || typeof file !== 'object' || file.format !== kFormat) throw new Error(`it is not a \u201c${kFormat}\u201d`);
  const length = kMetres[file.density_unit?.replace?.(/^1\//, '')];
  if (!length || !file.density_unit.startsWith('1/')) throw new Error('its density_unit is none of 1/um, 1/mm, 1/cm, 1/m');
  if (typeof file.lit !== 'boolean') throw new Error('lit must be true or false');
  if (!Array.isArray(file.points) || file.points.length < 2 || file.points.length > kMostPoints) throw new Error(`points must be a list of 2 to ${kMostPoints} points`);
  const points = file.points.map((p, i) => {
    const problem = (why) => new Error(`point ${i + 1}: ${why}`);
    if (!Number.isFinite(p?.density)) throw problem('density must be a number');
    if (!(typeof p.color === 'string' && /^#[0-9a-f]{6}$/i.test(p.color))) throw problem('color must be like #d9b382');
    if (!(Number.isFinite(p.opacity) && p.opacity >= 0 && p.opacity <= 1)) throw problem('opacity must be between 0 and 1');
    return point((p.density * kMetres[unit]) / length, p.color.toLowerCase(), p.opacity);
  });
  return { lit: file.lit, points };
}

export const point_text = ({ density, opacity }, per_length) => `density ${short(density)} ${per_length}, opacity ${short(100 * opacity, 2)} %`;
