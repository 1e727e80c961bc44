// The transfer function over the histogram of the densities: points are dragged, added by a double click, removed by the right
// button or the key Delete. Both axes are square roots; the histogram has logarithms of the number of voxels.
import { button, element } from '../../page/elements.js';
import { axis_of, density_at, field, root_field } from './fields.js';
import { clamped, short } from './numbers.js';
import { point_text } from './transfer.js';

const kWidth = 300, kHeight = 130, kEdge = 7;  // of the drawing, and free space around it
const kBins = 150, kStops = 60;
const kStep = 0.01, kFine = 0.002;  // of the keys, shares of the range
const kRadius = 6, kTouch = 14;  // of a point, and of what a finger hits

const svg = (tag, more = {}, ...children) => {
  const e = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [key, value] of Object.entries(more)) e.setAttribute(key, value);
  e.append(...children);
  return e;
};

export class TransferEditor {
  constructor(transfer) {
    this.transfer = transfer, this.volume = transfer.volume, this.held = null;
    this.gradient = svg('linearGradient', { id: 'transfer_colors' });
    this.area = svg('path', { fill: 'url(#transfer_colors)', 'fill-opacity': 0.75 });
    this.line = svg('path', { class: 'line' });
    this.marker = svg('path', { class: 'marker' });
    this.points = svg('g');
    this.picture = svg('svg', { id: 'transfer', viewBox: `0 0 ${kWidth} ${kHeight}`, 'aria-label': 'opacity over density', role: 'group' },
                       svg('defs', {}, this.gradient), svg('path', { class: 'bars', d: this.bars() }), this.area, this.marker, this.line, this.points);
    this.listen();
    const ends = element('div', { className: 'ends' }, ...[0, 0.25, 0.5, 0.75, 1].map((share) => element('span', { textContent: short(density_at(this.volume, share), 2) })));
    ends.append(element('span', { className: 'unit', textContent: this.volume.per_length }));
    this.nodes = [this.picture, ends, ...this.fields()];
    transfer.on_change(() => this.show());
    this.show();
  }

  // ---- places in the drawing

  x(density) {
    return kEdge + (kWidth - 2 * kEdge) * axis_of(this.volume, density);
  }
  y(opacity) {
    return kHeight - kEdge - (kHeight - 2 * kEdge) * Math.sqrt(opacity);
  }
  at(e) {
    const box = this.picture.getBoundingClientRect();
    const x = ((e.clientX - box.left) / box.width) * kWidth, y = ((e.clientY - box.top) / box.height) * kHeight;
    const up = clamped((kHeight - kEdge - y) / (kHeight - 2 * kEdge), 0, 1);
    return { density: density_at(this.volume, clamped((x - kEdge) / (kWidth - 2 * kEdge), 0, 1)), opacity: up * up };
  }
  bars() {
    const counts = this.volume.histogram(), bins = new Float64Array(kBins);
    const bin = (step) => Math.min(kBins - 1, Math.floor(Math.sqrt(step / this.volume.steps) * kBins));
    const steps = new Float64Array(kBins);  // in each bin: their mean is shown, so that the widths do not matter
    counts.forEach((n, step) => ((bins[bin(step)] += n), ++steps[bin(step)]));
    steps.forEach((n, i) => (bins[i] = n ? bins[i] / n : i ? bins[i - 1] : 0));
    const most = Math.log1p(Math.max(...bins)) || 1, w = (kWidth - 2 * kEdge) / kBins, foot = kHeight - kEdge;
    const tops = [...bins].map((n, i) => `H${(kEdge + i * w).toFixed(2)}V${(foot - (Math.log1p(n) / most) * (foot - kEdge)).toFixed(2)}`);
    return `M${kEdge} ${foot}${tops.join('')}H${kWidth - kEdge}V${foot}Z`;
  }

  // ---- mouse, fingers, keys

  // Index of the point at an event; -1 without one.
  nearest(e) {
    const box = this.picture.getBoundingClientRect(), scale = box.width / kWidth;
    let best = -1, least = e.pointerType === 'touch' ? kTouch * 1.5 : kTouch;
    this.transfer.points.forEach((p, i) => {
      const far = Math.hypot(e.clientX - box.left - this.x(p.density) * scale, e.clientY - box.top - this.y(p.opacity) * (box.height / kHeight));
      if (far < least) best = i, least = far;
    });
    return best;
  }
  listen() {
    const { picture, transfer } = this;
    picture.addEventListener('pointerdown', (e) => {
      const index = this.nearest(e);
      if (index < 0 || e.button !== 0) return;
      e.preventDefault();
      picture.setPointerCapture(e.pointerId);
      this.held = index;
      transfer.choose(index);
      this.points.children[index].focus({ preventScroll: true });
    });
    picture.addEventListener('pointermove', (e) => this.held !== null && transfer.change(this.held, this.at(e)));
    for (const name of ['pointerup', 'pointercancel']) picture.addEventListener(name, () => (this.held = null));
    picture.addEventListener('dblclick', (e) => {
      if (this.nearest(e) >= 0) return;
      const { density, opacity } = this.at(e);
      transfer.add(density, opacity);
    });
    picture.addEventListener('contextmenu', (e) => {
      e.preventDefault();
      const index = this.nearest(e);
      if (index >= 0) transfer.remove(index);
    });
    picture.addEventListener('keydown', (e) => this.key(e));
  }
  key(e) {
    const { transfer } = this, index = [...this.points.children].indexOf(e.target), p = transfer.points[index];
    if (!p) return;
    const step = e.shiftKey ? kFine : kStep, height = Math.sqrt(p.opacity), along = axis_of(this.volume, p.density);
    const [dx, dy] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[e.key] ?? [0, 0];
    if (dx || dy) transfer.change(index, { density: density_at(this.volume, clamped(along + dx * step, 0, 1)), opacity: clamped(height + dy * step, 0, 1) ** 2 });
    else if (e.key === 'Delete' || e.key === 'Backspace') transfer.remove(index);
    else return;
    e.preventDefault();
    this.points.children[transfer.chosen].focus({ preventScroll: true });
  }

  // ---- fields of the chosen point

  fields() {
    const { transfer, volume } = this;
    this.density = root_field('Density', 'point_density', volume, (v) => transfer.change(transfer.chosen, { density: v }));
    this.opacity = field('Opacity', 'point_opacity', 0, 1, (v) => transfer.change(transfer.chosen, { opacity: v * v }), (v) => `${short(100 * v * v, 2)} %`);
    this.color = element('input', { type: 'color', id: 'point_color', oninput: () => transfer.change(transfer.chosen, { color: this.color.value }) });
    this.remove = button('Remove', () => transfer.remove(transfer.chosen), { id: 'remove_point' });
    const add = button('Add', () => this.add_next(), { id: 'add_point', title: 'a point between this one and the next' });
    this.which = element('span', { className: 'which' });
    const lit = element('input', { type: 'checkbox', id: 'lit', onchange: () => transfer.set_lit(lit.checked) });
    this.lit = lit;
    return [element('div', { className: 'row' }, this.which, element('label', { htmlFor: 'point_color', textContent: 'Colour' }), this.color, add, this.remove),
      this.density.row, this.opacity.row, element('label', { className: 'row' }, lit, 'light falls on surfaces')];
  }
  add_next() {
    const { transfer } = this, { points, chosen } = transfer, [a, b] = chosen + 1 < points.length ? [points[chosen], points[chosen + 1]] : [points[chosen - 1], points[chosen]];
    const density = (a.density + b.density) / 2;
    transfer.add(density, transfer.at(density).opacity);
  }

  // The density below the pointer or at the crosshair, as a line.
  show_density(density) {
    this.marker.setAttribute('d', density === null ? '' : `M${this.x(density).toFixed(2)} ${kEdge}V${kHeight - kEdge}`);
  }
  show() {
    const { transfer, volume } = this, { points, chosen } = transfer, foot = kHeight - kEdge;
    while (this.points.children.length > points.length) this.points.lastChild.remove();
    while (this.points.children.length < points.length)
      this.points.append(svg('circle', { r: kRadius, tabindex: 0, role: 'slider' }));
    [...this.points.children].forEach((circle, i) => {
      const p = points[i], { low, high } = volume;
      for (const [key, value] of Object.entries({
        cx: this.x(p.density).toFixed(2), cy: this.y(p.opacity).toFixed(2), fill: p.color, class: i === chosen ? 'chosen' : '',
        'aria-label': `point ${i + 1} of ${points.length}`, 'aria-valuemin': low, 'aria-valuemax': high, 'aria-valuenow': p.density, 'aria-valuetext': point_text(p, volume.per_length),
      })) circle.setAttribute(key, value);
    });
    this.draw_function(points, foot);
    const p = points[chosen];
    this.which.textContent = `Point ${chosen + 1}\u2009/\u2009${points.length}`;
    this.density.show(p.density), this.opacity.show(Math.sqrt(p.opacity));
    this.color.value = p.color, this.remove.disabled = points.length <= 2, this.lit.checked = transfer.lit;
  }
  // Line and coloured area: between two points colour and opacity are linear in the density.
  draw_function(points, foot) {
    const { low, high } = this.volume, kParts = 12, out = [];
    const ends = [{ ...points[0], density: low }, ...points, { ...points.at(-1), density: high }];
    ends.forEach((b, i) => {
      const a = ends[i - 1];
      for (let k = a ? 1 : kParts; k <= kParts; ++k) {
        const t = k / kParts, mixed = (key) => (a ? a[key] + t * (b[key] - a[key]) : b[key]);
        out.push(`${this.x(mixed('density')).toFixed(2)} ${this.y(mixed('opacity')).toFixed(2)}`);
      }
    });
    this.line.setAttribute('d', `M${out.join('L')}`);
    this.area.setAttribute('d', `M${kEdge} ${foot}L${out.join('L')}L${kWidth - kEdge} ${foot}Z`);
    this.gradient.replaceChildren(...Array.from({ length: kStops + 1 }, (_, i) => {
      const { rgb } = this.transfer.at(density_at(this.volume, i / kStops));
      return svg('stop', { offset: i / kStops, 'stop-color': `rgb(${rgb.map(Math.round)})` });
    }));
  }
}
