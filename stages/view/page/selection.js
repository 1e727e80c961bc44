// Surfels selected by a selector of `vitrine edit` (core/render/edit/selection.h). Classes, objects and components were computed when
// the page was written; positions are tested here. Surfels that the page does not render (glass of known shape, omitted ones)
// follow the rendered ones and are counted.
import { resized } from './cameras.js';
import { inside } from '../../page/polygon.js';
import { kClasses } from './edit_list.js';
import { surfel_places } from './scene_data.js';

const kSky = 2, kInside = 4;  // flags of surfels (stages/view/page_surfels.h)

const joined = (a, b) => {
  const out = new a.constructor(a.length + b.length);
  out.set(a), out.set(b, a.length);
  return out;
};

export class Selection {
  constructor({ scene, blocks }) {
    const drawn = scene.drawn, b = blocks;
    this.scene = scene, this.drawn = drawn;
    this.places = joined(surfel_places(b.place).subarray(0, 3 * drawn), surfel_places(b.absent_place));
    this.classes = joined(b.part_class, b.absent_class), this.components = joined(b.part_component, b.absent_component);
    this.objects = b.part_object && joined(b.part_object, b.absent_object);
    this.id_of = new Map(scene.objects.map(({ id, name }) => [name, id]));
    this.flags = joined(b.flags.subarray(0, drawn), b.absent_flags);
    this.count = this.flags.length;
    this.cameras = new Map(scene.cameras.map((c) => [c.name, resized(c, c.photo[0], c.photo[1])]));
  }
  is_inside(i) {
    return (this.flags[i] & kInside) !== 0;
  }
  is_sky(i) {
    return (this.flags[i] & kSky) !== 0;
  }

  // Returns a predicate of x, y, z.
  in_mark({ photo, box, polygon, size }) {
    const camera = this.cameras.get(photo), { rotation: r, translation: t, fx, fy, cx, cy, width, height } = camera;
    const corners = box ? [[box[0], box[1]], [box[2], box[1]], [box[2], box[3]], [box[0], box[3]]] : polygon;
    const at = corners.map(([x, y]) => (size ? [(x * width) / size[0], (y * height) / size[1]] : [x, y]));
    return (x, y, z) => {
      const depth = r[6] * x + r[7] * y + r[8] * z + t[2];
      if (!(depth > 0)) return false;
      const u = (fx * (r[0] * x + r[1] * y + r[2] * z + t[0])) / depth + cx, v = (fy * (r[3] * x + r[4] * y + r[5] * z + t[1])) / depth + cy;
      return u >= 0 && v >= 0 && u < width && v < height && inside(at, [u, v]);
    };
  }

  // [count] 0 or 1, including deleted ones.
  flags_of(select) {
    const out = new Uint8Array(this.count).fill(1);
    if (select === 'all') return out;
    const { class: kind, object, component, box, marks, except } = select;
    if (!kind && !object && !component && !box && !marks?.length) return out.fill(0);  // empty selection
    const bit = kind ? 1 << kClasses.indexOf(kind) : 0, id = this.id_of.get(object);
    const in_marks = (marks ?? []).map((m) => this.in_mark(m)), left_out = except ? this.flags_of(except) : null;
    for (let i = 0; i < this.count; ++i) {
      const x = this.places[3 * i], y = this.places[3 * i + 1], z = this.places[3 * i + 2];
      if (kind && !(this.classes[i] & bit)) out[i] = 0;
      else if (object && this.objects[i] !== id) out[i] = 0;
      else if (component && this.components[i] !== component) out[i] = 0;
      else if (box && !(x >= box[0] && x <= box[3] && y >= box[1] && y <= box[4] && z >= box[2] && z <= box[5])) out[i] = 0;
      else if (!in_marks.every((f) => f(x, y, z))) out[i] = 0;
      else if (left_out?.[i]) out[i] = 0;
    }
    return out;
  }

  // Mesh component at a position: that of the nearest surfel on a component, within `reach`; 0 if none.
  component_at(p, reach) {
    let best = reach * reach, found = 0;
    for (let i = 0; i < this.count; ++i) {
      if (this.components[i] === 0 || this.is_inside(i)) continue;
      const d = (this.places[3 * i] - p[0]) ** 2 + (this.places[3 * i + 1] - p[1]) ** 2 + (this.places[3 * i + 2] - p[2]) ** 2;
      if (d < best) (best = d), (found = this.components[i]);
    }
    return found;
  }
}

// Selection by position only: such tints also change content behind glass.
export const is_geometric = (select) => select === 'all' || (!select.class && !select.object && !select.component);
