// A distance in a slice: dragged from one place to another while the button Measure is pressed.
import { button, element } from '../../page/elements.js';
import { section } from '../../page/controls.js';
import { short } from './numbers.js';

const kTick = 6;  // half the line across an end, screen pixels

export const length_of = ({ from, to }) => Math.hypot(...from.map((v, c) => v - to[c]));
const text_of = (measure, { unit }) => `${short(length_of(measure))} ${unit}`;

// In the slice that it was dragged in, while that shows the same plane.
export function draw_measure(context, slice, frame) {
  const { measure, place } = slice.state, { volume, axis } = slice;
  if (!measure || measure.axis !== axis || volume.voxel(place[axis], axis) !== volume.voxel(measure.from[axis], axis)) return;
  const [[ax, ay], [bx, by]] = [measure.from, measure.to].map((p) => slice.to_screen(p, frame)), length = Math.hypot(bx - ax, by - ay);
  if (length < 1) return;
  const [nx, ny] = [(-(by - ay) / length) * kTick, ((bx - ax) / length) * kTick];
  context.save();
  context.strokeStyle = context.fillStyle = '#ffe08a', context.lineWidth = 1.5, context.shadowColor = '#000', context.shadowBlur = 4;
  context.beginPath();
  for (const [x, y] of [[ax, ay], [bx, by]]) context.moveTo(x - nx, y - ny), context.lineTo(x + nx, y + ny);
  context.moveTo(ax, ay), context.lineTo(bx, by);
  context.stroke();
  context.font = '14px system-ui, sans-serif', context.textAlign = 'center', context.textBaseline = 'middle';
  const side = ny > 0 ? -1 : 1;
  context.fillText(text_of(measure, volume), (ax + bx) / 2 + side * nx * 2.6, (ay + by) / 2 + side * ny * 2.6);
  context.restore();
}

export function measure_section(state) {
  const shown = element('output', { id: 'measured' });
  const use = button('Measure', () => state.set_measuring(!state.measuring), { id: 'measure', title: 'drag in a slice' });
  const clear = button('Clear', () => state.set_measure(null), { id: 'clear_measure' });
  const show = () => {
    use.setAttribute('aria-pressed', state.measuring), clear.disabled = !state.measure;
    shown.value = state.measure ? text_of(state.measure, state.volume) : state.measuring ? 'drag in a slice' : '';
  };
  state.on_change((what) => what === 'measure' && show());
  show();
  return section('Distance', element('div', { className: 'row' }, use, clear, shown));
}
