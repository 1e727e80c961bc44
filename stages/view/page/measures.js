// Distance measurement between two clicked surface points; with the true length, the option of `vitrine export` that sets the unit.
import { button, element } from '../../page/elements.js';
import { section } from '../../page/controls.js';
import { svg } from './marks.js';

export class Measures {
  constructor(view) {
    this.view = view, this.points = [];
  }
  // Handles a click on a surface; the message is shown where there is none.
  take(place) {
    if (this.points.length === 2) this.points = [];
    this.points.push(place);
  }
  nothing = 'There is no surface to measure from.';
  ended() {
    this.points = [];
  }

  // Distance of the two points; null if there are fewer. In units of the scene.
  distance() {
    const [a, b] = this.points;
    return b ? Math.hypot(...a.map((v, i) => v - b[i])) : null;
  }
  text() {
    const d = this.distance();
    if (d === null) return '';
    const { metres_per_unit } = this.view.scene;
    if (!metres_per_unit) return `${d.toFixed(3)} units, scale unknown`;
    const metres = metres_per_unit * d;
    return metres < 1 ? `${(100 * metres).toFixed(1)} cm` : `${metres.toFixed(2)} m`;
  }

  // projected(place) -> [x, y, z] on the screen.
  marks(projected) {
    const at = this.points.map(projected).filter((p) => p[2] > 0), [a, b] = at;
    const line = b ? [svg('line', { x1: a[0], y1: a[1], x2: b[0], y2: b[1] }), svg('text', { x: b[0] + 8, y: b[1] }, this.text())] : [];
    return [...line, ...at.map(([cx, cy]) => svg('circle', { cx, cy, r: 4 }))];
  }
}

const kLength = /^\s*\d*\.?\d+\s*(m|cm|mm)\s*$/;

// Text of `vitrine export --scale-points`; empty without two points, or if the length is not a positive one with a unit.
export function scale_points(points, length) {
  if (points.length < 2 || !kLength.test(length) || !(parseFloat(length) > 0)) return '';
  return `--scale-points "${points.map((p) => p.map((v) => v.toPrecision(7)).join(',')).join(' ')} ${length.replace(/\s/g, '')}"`;
}

export function measures_section(view) {
  const { measures } = view, shown = element('output', { id: 'distance' });
  const measure = button('Measure', () => view.use(measures), { id: 'measure' });
  const length = element('input', { id: 'true_length', type: 'text', size: 8, placeholder: '24cm', oninput: () => show() });
  length.setAttribute('aria-label', 'true length of the distance');
  const option = element('output', { id: 'scale_points' });
  const known = element('div', { className: 'row', hidden: true }, element('label', {}, 'True length ', length), option);
  const show = () => {
    known.hidden = measures.points.length < 2;
    option.value = scale_points(measures.points, length.value);
    measure.setAttribute('aria-pressed', view.tool === measures);
    shown.value = measures.text() || (view.tool === measures ? 'click two points' : '');
  };
  return { nodes: section('Distance', element('div', { className: 'row' }, measure, shown), known), show };
}
