// One of three slices: the plane across an axis through the crosshair, with the other two planes as lines, a scale bar and a
// slider. The last remaining axis goes up.
import { element } from '../../page/elements.js';
import { draw_measure } from './measure.js';
import { hold_slice } from './slice_hand.js';
import { clamped, place_text, round_length } from './numbers.js';

export const kAxisColors = ['#ff8f70', '#8fd18b', '#7db4ff'];
const kMargin = 26;  // around the whole slice, screen pixels
const kGap = 7;  // of the lines around the crosshair, screen pixels
const kBar = 0.28;  // most length of the scale bar, share of the width
const kGround = '#141518', kUnknown = '#24262b', kHatch = '#30333a', kText = '#e8e6e0';

export class Slice {
  constructor(state, axis) {
    this.state = state, this.volume = state.volume, this.axis = axis;
    this.right = axis === 0 ? 1 : 0, this.up = axis === 2 ? 1 : 2;
    const name = 'xyz'[axis], { volume } = this;
    this.canvas = element('canvas', { tabIndex: 0, id: `slice_${name}` });
    this.canvas.setAttribute('role', 'img');
    this.label = element('span', { className: 'label' });
    this.slider = element('input', { type: 'range', id: `place_${name}`, min: 0, max: volume.size[axis] - 1, step: 1, title: `place along ${name}` });
    this.slider.setAttribute('aria-label', `place of the slice along ${name}`);
    this.slider.oninput = () => state.step(axis, Number(this.slider.value) - volume.voxel(state.place[axis], axis));
    this.slider.style.accentColor = kAxisColors[axis];
    this.node = element('div', { className: 'pane', id: `pane_${name}` }, this.canvas, this.label, this.slider);
    this.image = new OffscreenCanvas(volume.size[this.right], volume.size[this.up]);
    hold_slice(this);
    state.on_change((what) => what !== 'hover' && this.draw());
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  // Screen pixels of the canvas, and how many of them a unit of length has.
  frame() {
    const { volume, right, up, state } = this, width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    const extent = (c) => volume.end[c] - volume.origin[c];
    const fit = Math.min((width - 2 * kMargin) / extent(right), (height - 2 * kMargin) / extent(up));
    return { width, height, scale: Math.max(fit, 1e-9) * state.zoom };
  }
  to_screen(place, { width, height, scale } = this.frame()) {
    const { focus } = this.state;
    return [width / 2 + (place[this.right] - focus[this.right]) * scale, height / 2 - (place[this.up] - focus[this.up]) * scale];
  }
  // The place in this slice below a point of the canvas.
  to_place([x, y], { width, height, scale } = this.frame()) {
    const place = [...this.state.place], { focus } = this.state;
    place[this.right] = focus[this.right] + (x - width / 2) / scale;
    place[this.up] = focus[this.up] - (y - height / 2) / scale;
    return place;
  }

  // Grey values of the slice in `image`, one pixel a voxel.
  paint_voxels() {
    const { volume, state, axis, right, up } = this, { values, strides, size } = volume;
    const at = volume.voxel(state.place[axis], axis), key = [at, state.black, state.white].join();
    if (key === this.painted) return;
    this.painted = key;
    const w = size[right], h = size[up], data = new ImageData(w, h), words = new Uint32Array(data.data.buffer), grey = this.greys();
    for (let y = 0, to = 0; y < h; ++y)
      for (let x = 0, from = at * strides[axis] + (h - 1 - y) * strides[up]; x < w; ++x, ++to, from += strides[right]) words[to] = grey[values[from]];
    this.image.getContext('2d').putImageData(data, 0, 0);
  }
  // Pixel of each step.
  greys() {
    const { volume, state } = this;
    return Uint32Array.from({ length: volume.steps + 1 }, (_, q) => {
      const v = Math.round(clamped((volume.density_of(q) - state.black) / (state.white - state.black), 0, 1) * 255);
      return 0xff000000 | (v << 16) | (v << 8) | v;
    });
  }

  draw() {
    const { canvas, volume, state, axis, right, up } = this, frame = this.frame(), { width, height, scale } = frame;
    if (!width || !height) return;
    const density = devicePixelRatio || 1, context = canvas.getContext('2d');
    if (canvas.width !== Math.round(width * density) || canvas.height !== Math.round(height * density))
      canvas.width = Math.round(width * density), canvas.height = Math.round(height * density);
    context.setTransform(density, 0, 0, density, 0, 0);
    context.fillStyle = kGround;
    context.fillRect(0, 0, width, height);
    this.paint_voxels();
    const at = (c, p) => state.place.map((v, i) => (i === right ? p[0] : i === up ? p[1] : v));
    const [left, bottom] = this.to_screen(at(0, [volume.origin[right], volume.origin[up]]), frame);
    const [end_x, end_y] = this.to_screen(at(0, [volume.end[right], volume.end[up]]), frame);
    context.save();
    context.beginPath();
    context.rect(left, end_y, end_x - left, bottom - end_y);
    context.clip();
    this.hatch(context, left, end_y, end_x, bottom);
    this.clip_to_known(context, frame);
    const voxel = volume.cell * scale;
    context.imageSmoothingEnabled = true, context.imageSmoothingQuality = 'high';
    context.drawImage(this.image, left, bottom - this.image.height * voxel, this.image.width * voxel, this.image.height * voxel);
    context.restore();
    this.draw_lines(context, frame);
    draw_measure(context, this, frame);
    this.draw_bar(context, frame);
    this.draw_axes(context, frame);
    const text = place_text(state.place[axis], volume.cell);
    this.label.textContent = `${'xyz'[axis]} = ${text} ${volume.unit}`;
    this.label.style.color = kAxisColors[axis];
    this.slider.value = volume.voxel(state.place[axis], axis);
    this.slider.setAttribute('aria-valuetext', `${text} ${volume.unit}`);
    canvas.setAttribute('aria-label', `slice across ${'xyz'[axis]} at ${text} ${volume.unit}; arrows move the crosshair, page up and page down the slice`);
  }
  // The part of the plane that is in the cylinder around z.
  clip_to_known(context, frame) {
    const { radius } = this.volume, { place } = this.state;
    if (radius === null) return;
    const [x, y] = this.to_screen([0, 0, place[2]], frame), half = Math.sqrt(Math.max(0, radius ** 2 - (this.axis === 2 ? 0 : place[this.axis] ** 2))) * frame.scale;
    context.beginPath();
    if (this.axis === 2) context.arc(x, y, half, 0, 2 * Math.PI);
    else context.rect(x - half, 0, 2 * half, frame.height);
    context.clip();
  }
  // Where nothing is known.
  hatch(context, x0, y0, x1, y1) {
    context.fillStyle = kUnknown;
    context.fillRect(x0, y0, x1 - x0, y1 - y0);
    if (this.volume.radius === null) return;
    context.strokeStyle = kHatch, context.lineWidth = 1;
    context.beginPath();
    for (let x = x0 - (y1 - y0); x < x1; x += 8) context.moveTo(x, y1), context.lineTo(x + (y1 - y0), y0);
    context.stroke();
  }
  draw_lines(context, frame) {
    const [x, y] = this.to_screen(this.state.place, frame), { width, height } = frame;
    const line = (color, ...ends) => {
      context.strokeStyle = color;
      context.beginPath();
      for (const [ax, ay, bx, by] of ends) context.moveTo(ax, ay), context.lineTo(bx, by);
      context.stroke();
    };
    context.lineWidth = 1, context.globalAlpha = 0.75;
    line(kAxisColors[this.right], [x, 0, x, y - kGap], [x, y + kGap, x, height]);
    line(kAxisColors[this.up], [0, y, x - kGap, y], [x + kGap, y, width, y]);
    context.globalAlpha = 1;
  }
  draw_bar(context, { width, height, scale }) {
    const length = round_length((kBar * width) / scale), x = 12, y = height - 14;
    context.fillStyle = context.strokeStyle = kText, context.font = '13px system-ui, sans-serif', context.lineWidth = 2;
    context.shadowColor = '#000', context.shadowBlur = 4;
    context.beginPath();
    context.moveTo(x, y - 4), context.lineTo(x, y), context.lineTo(x + length * scale, y), context.lineTo(x + length * scale, y - 4);
    context.stroke();
    context.textAlign = 'left', context.textBaseline = 'bottom';
    context.fillText(`${parseFloat(length.toPrecision(1))} ${this.volume.unit}`, x, y - 6);
    context.shadowBlur = 0;
  }
  // The directions of the two axes, in the lower right corner.
  draw_axes(context, { width, height }) {
    const x = width - 40, y = height - 16, reach = 22;
    const arrow = (color, dx, dy, name, tx, ty) => {
      context.strokeStyle = context.fillStyle = color;
      context.beginPath();
      context.moveTo(x, y), context.lineTo(x + dx * reach, y + dy * reach);
      context.stroke();
      context.fillText(name, x + tx, y + ty);
    };
    context.lineWidth = 1.5, context.textBaseline = 'middle', context.textAlign = 'center', context.font = '13px system-ui, sans-serif';
    arrow(kAxisColors[this.right], 1, 0, 'xyz'[this.right], reach + 8, 0);
    arrow(kAxisColors[this.up], 0, -1, 'xyz'[this.up], 0, -reach - 8);
  }
}
