// The cut plane of the picture of the volume: hides one side. Across an axis it stays where it is; across the view it turns with it.
import { button, element } from '../../page/elements.js';
import { section } from '../../page/controls.js';
import { field } from './fields.js';
import { place_text } from './numbers.js';

const kNone = [0, 0, 0, -1];

export class Cut {
  constructor(volume) {
    this.volume = volume;
    this.axis = null, this.place = 0, this.sign = 1;  // visible: sign * coordinate >= sign * place
    this.on_change = () => {};
  }
  set(some) {
    Object.assign(this, some);
    this.on_change();
  }
  range() {
    const { volume } = this, axis = 'xyz'.indexOf(this.axis), half = volume.diagonal / 2;
    return axis < 0 ? [-half, half] : [volume.origin[axis], volume.end[axis]];
  }
  // Through `place`; hides the side of the eye.
  stand(axis, place, camera) {
    const c = 'xyz'.indexOf(axis);
    if (c < 0) this.set({ axis, place: 0, sign: 1 });
    else this.set({ axis, place: place[c], sign: camera.eye[c] > place[c] ? -1 : 1 });
  }
  // [normal, offset]; visible: dot(normal, p) >= offset.
  plane({ ahead }) {
    if (!this.axis) return kNone;
    const c = 'xyz'.indexOf(this.axis), n = c < 0 ? ahead : [0, 1, 2].map((i) => (i === c ? 1 : 0));
    const offset = this.place + (c < 0 ? n.reduce((sum, v, i) => sum + v * this.volume.middle[i], 0) : 0);
    return [...n.map((v) => this.sign * v), this.sign * offset];
  }
}

export function cut_section(cut, state, camera) {
  const { volume } = cut, names = { '': 'Off', x: 'x', y: 'y', z: 'z', view: 'View' };
  const axes = Object.entries(names).map(([axis, name]) =>
    button(name, () => (axis ? cut.stand(axis, state.place, camera()) : cut.set({ axis: null })), { id: `cut_${axis || 'off'}` }));
  const place = field('Place', 'cut_place', 0, 1, (v) => cut.set({ place: v }), (v) => `${place_text(v, volume.cell)} ${volume.unit}`);
  const flip = button('Other side', () => cut.set({ sign: -cut.sign }), { id: 'cut_flip' });
  const here = button('At the crosshair', () => cut.set({ place: state.place['xyz'.indexOf(cut.axis)] }), { id: 'cut_here' });
  const show = () => {
    axes.forEach((b) => b.setAttribute('aria-pressed', b.id === `cut_${cut.axis ?? 'off'}`));
    place.input.disabled = flip.disabled = !cut.axis, here.disabled = !cut.axis || cut.axis === 'view';
    const [least, most] = cut.axis ? cut.range() : [0, 1];
    Object.assign(place.input, { min: least, max: most });
    place.show(cut.place);
  };
  show();
  return { nodes: section('Cut', element('div', { className: 'row' }, ...axes), place.row, element('div', { className: 'row' }, flip, here)), show };
}
