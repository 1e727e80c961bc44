// Distance measurement between two clicked surface points.
import { button, element } from '../../page/elements.js';
import { section } from './controls.js';
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

export function measures_section(view) {
  const { measures } = view, shown = element('output', { id: 'distance' });
  const measure = button('Measure', () => view.use(measures), { id: 'measure' });
  const show = () => {
    measure.setAttribute('aria-pressed', view.tool === measures);
    shown.value = measures.text() || (view.tool === measures ? 'click two points' : '');
  };
  return { nodes: section('Distance', element('div', { className: 'row' }, measure, shown)), show };
}
