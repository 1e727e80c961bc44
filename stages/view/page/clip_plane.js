// Clip plane: hides one side of a plane. Perpendicular to an axis it is fixed in the scene; perpendicular to the view it moves
// with the camera. Page address: clip=AXIS,PLACE, with a minus before the axis if the side of smaller coordinates is shown.
import { button, element } from '../../page/elements.js';
import { section, slider } from '../../page/controls.js';

const kAxes = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1], view: null };
const kEnds = 0.01;  // fraction of positions ignored at either end of the extent
const kMargin = 0.05;  // relative to the extent: additional range of the slider
const kPlaces = 400;  // steps of the slider
export const kNoClip = [0, 0, 0, -1];

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

// [minimum, maximum] of nearly all positions [3 n], per axis.
function extents(places) {
  return [0, 1, 2].map((c) => {
    const along = Float32Array.from({ length: places.length / 3 }, (_, i) => places[3 * i + c]).sort(), last = Math.max(0, along.length - 1);
    const [least, most] = [Math.floor(kEnds * last), Math.ceil((1 - kEnds) * last)].map((i) => along[i] ?? 0), margin = kMargin * (most - least);
    return [least - margin, most + margin];
  });
}

export class ClipPlane {
  // middle: centre of the scene; places: positions of the surfels.
  constructor(middle, places) {
    this.middle = middle, this.extents = extents(places);
    this.axis = null, this.place = 0, this.sign = 1;  // visible: sign * coordinate >= sign * place
    this.on_change = () => {};
  }
  // Range of the plane's position; perpendicular to the view it is relative to the middle.
  range(axis = this.axis) {
    const reach = Math.hypot(...this.extents.map(([a, b], c) => Math.max(b - this.middle[c], this.middle[c] - a)));
    return kAxes[axis] ? this.extents['xyz'.indexOf(axis)] : [-reach, reach];
  }
  set(some) {
    Object.assign(this, some);
    this.on_change();
  }
  // Places the plane through the middle of the scene; hides the side of the eye.
  stand(axis, eye) {
    const n = kAxes[axis], place = n ? dot(n, this.middle) : 0;
    this.set({ axis, place, sign: n && dot(n, eye) > place ? -1 : 1 });
  }
  flip() {
    this.set({ sign: -this.sign });
  }
  // [normal, offset]; visible: dot(normal, p) >= offset.
  plane(camera) {
    if (!this.axis) return kNoClip;
    const n = kAxes[this.axis] ?? camera.rotation.slice(6, 9), offset = this.place + (kAxes[this.axis] ? 0 : dot(n, this.middle));
    return [...n.map((v) => this.sign * v), this.sign * offset];
  }

  address() {
    return this.axis ? [['clip', `${this.sign < 0 ? '-' : ''}${this.axis},${this.place.toFixed(4)}`]] : [];
  }
  restore(query) {
    const [, minus, axis, place] = query.get('clip')?.match(/^(-?)(x|y|z|view),(-?[\d.]+)$/) ?? [];
    if (Number.isFinite(Number(place))) Object.assign(this, { axis, place: Number(place), sign: minus ? -1 : 1 });
  }
}

// Clips a polygon [[x y z] ...] to the visible side.
export function clipped(corners, plane) {
  const out = [], height = (p) => dot(plane, p) - plane[3];
  corners.forEach((b, i) => {
    const a = corners.at(i - 1), ha = height(a), hb = height(b);
    if (ha < 0 !== hb < 0) out.push(a.map((v, c) => v + (ha / (ha - hb)) * (b[c] - v)));
    if (hb >= 0) out.push(b);
  });
  return out;
}

// Returns {nodes of the panel, show: called after a change}. eye(): camera position.
export function clip_section(clip, unit, eye) {
  const names = { '': 'Off', x: 'x', y: 'y', z: 'z', view: 'view' };
  const axes = Object.entries(names).map(([axis, name]) =>
    button(name, () => (axis ? clip.stand(axis, eye()) : clip.set({ axis: null })), { id: `clip_${axis || 'off'}` }));
  const place = slider('Place', 'clip_place', 0, 1, 'any', unit, (v) => clip.set({ place: v }));
  const flip = button('Flip', () => clip.flip(), { id: 'clip_flip' });
  const show = () => {
    axes.forEach((b) => b.setAttribute('aria-pressed', b.id === `clip_${clip.axis ?? 'off'}`));
    place.input.disabled = flip.disabled = !clip.axis;
    const [least, most] = clip.axis ? clip.range() : [0, 1];
    Object.assign(place.input, { min: least, max: most, step: (most - least) / kPlaces || 'any' });
    place.show(clip.place);
  };
  show();
  return { nodes: section('Clip plane', element('div', { className: 'row' }, ...axes), place.row, element('div', { className: 'row' }, flip)), show };
}
