// List of edits of the page: the edits, the selected one, the number of surfels of each; the preview follows every change.
import { unprojected } from './cameras.js';
import { edits_of, edits_yaml, mistake_of } from './edit_list.js';
import { EditPreview } from './edit_preview.js';
import { Selection } from './selection.js';

const kFlat = 0.01;  // radii of the scene: minimum extent of a box between two points
const kReach = 0.1;  // radii: pick distance of a component

export class Edits {
  constructor(view, page) {
    this.view = view, this.page = page;
    this.selection = new Selection(page);
    this.preview = new EditPreview(view.picture, page, this.selection);
    this.list = [], this.found = [], this.counts = [], this.chosen = -1;
    addEventListener('beforeunload', (e) => this.unsaved && e.preventDefault());
    this.photos = page.scene.cameras.map((c) => c.name), this.objects = page.scene.objects.map((o) => o.name);
  }
  get one() {
    return this.list[this.chosen];
  }

  // Called after any change of the list.
  changed() {
    this.unsaved = this.list.length > 0;
    this.found = this.preview.show(this.list);
    this.counts = this.found.map(({ surfels }) => surfels);
    this.view.show_state(), this.view.adjusting();
  }
  choose(index) {
    this.view.hand.drop();
    this.chosen = index;
    this.view.changed(), this.view.draw_marks();
  }
  add(name = `edit ${this.list.length + 1}`, select = {}) {
    this.list.push({ name, select, remove: false, set: {} });
    this.choose(this.list.length - 1);
  }
  remove() {
    this.list.splice(this.chosen, 1);
    this.choose(-1), this.changed();
  }
  // Changes some of name, select, remove, set of the selected edit.
  change(some) {
    this.list[this.chosen] = { ...this.one, ...some };
    this.changed();
  }
  // Sets one value of `set`; undefined removes it.
  set(key, value) {
    const { [key]: before, ...others } = this.one.set;
    this.change({ set: value === undefined ? others : { ...others, [key]: value } });
  }
  mistake(index) {
    const { surfels = 0, content = 0 } = this.found[index] ?? {};
    return mistake_of(this.list[index], surfels + content);
  }
  // Text of the file; null, with a message, while `vitrine edit` would reject it.
  yaml() {
    const wrong = this.list.map((e, i) => [e.name, this.mistake(i)]).find(([, m]) => m);
    this.view.tell(this.list.length === 0 ? 'There is no edit to save.' : wrong ? `\u201c${wrong[0]}\u201d cannot be saved: ${wrong[1]}.` : '');
    if (this.list.length === 0 || wrong) return null;
    this.unsaved = false;
    return edits_yaml(this.list);
  }
  async open(file) {
    try {
      this.list = edits_of(await file.text(), this.photos, this.objects);
      this.view.tell('');
      this.choose(this.list.length ? 0 : -1), this.changed();
      this.unsaved = false;
    } catch (e) {
      this.view.tell(`${file.name} cannot be read: ${e.message}`);
    }
  }

  // ---- mouse tools on the picture (hand.js)

  surface_at({ x, y }) {
    const z = this.view.picture.depth_at(x, y);
    this.view.tell(z > 0 ? '' : 'There is no surface here.');
    return z > 0 ? unprojected(this.view.drawn, x, y, z) : null;
  }
  pick_component() {
    if (this.view.hand.has('component')) return this.view.hand.drop();
    this.view.hand.take({
      name: 'component',
      clicked: (at) => {
        const p = this.surface_at(at), found = p && this.selection.component_at(p, kReach * this.page.scene.radius);
        if (found) this.change({ select: { component: found } });
        else if (p) this.view.tell('No component of the mesh is here.');
      },
    });
  }
  pick_box() {
    if (this.view.hand.has('box')) return this.view.hand.drop();
    let first = null;
    this.view.hand.take({
      name: 'box',
      clicked: (at) => {
        const p = this.surface_at(at), least = 0.5 * kFlat * this.page.scene.radius;
        if (!p || !first) return void (first = p ?? first);
        const low = p.map((v, c) => Math.min(v, first[c])), high = p.map((v, c) => Math.max(v, first[c]));
        const box = [...low.map((v, c) => Math.min(v, 0.5 * (v + high[c]) - least)), ...high.map((v, c) => Math.max(v, 0.5 * (v + low[c]) + least))];
        first = null;
        this.change({ select: { box } });
      },
    });
  }
  // Marks in the photo of the current camera: a rectangle by dragging, a polygon by clicks, closed at its first corner or by
  // Enter.
  draw_mark(kind) {
    const { view } = this;
    if (view.hand.has(`mark_${kind}`)) return view.hand.drop();
    let photo = view.photo;
    const corners = (this.drawn_corners = []), show = () => view.draw_marks();
    // The photo at this press; an unfinished mark of another photo is discarded.
    const stands = () => {
      if (photo !== view.photo) corners.length = 0, (photo = view.photo);
      view.tell(photo === undefined ? 'Marks are drawn at the place of a photo: click one of the photos first.' : '');
      return photo !== undefined;
    };
    if (!stands()) return;
    const size = () => this.page.scene.cameras[photo].photo;
    const pixel = ({ x, y }, [width, height] = size()) => [Math.min(width, Math.max(0, (x * width) / view.drawn.width)), Math.min(height, Math.max(0, (y * height) / view.drawn.height))].map((v) => Math.round(10 * v) / 10);
    const add = (mark) => this.change({ select: { marks: [...(this.one.select.marks ?? []), { photo: this.photos[photo], ...mark }] } });
    let from = null;
    const close = () => {
      if (corners.length >= 3) add({ polygon: [...corners] });
      corners.length = 0, show();
    };
    const rectangle = (a, b) => [Math.min(a[0], b[0]), Math.min(a[1], b[1]), Math.max(a[0], b[0]), Math.max(a[1], b[1])];
    const outline = ([l, t, r, b]) => [[l, t], [r, t], [r, b], [l, b]];
    const tool = kind === 'box' ? {
      pressed: (at) => (from = stands() ? pixel(at) : null),
      moved: (at) => from && (corners.splice(0, 4, ...outline(rectangle(from, pixel(at)))), show()),
      released: (at) => {
        if (!from) return;
        const box = rectangle(from, pixel(at));
        corners.length = 0;
        if (box[2] - box[0] > 1 && box[3] - box[1] > 1) add({ box });
        else show();
      },
    } : {
      clicked: (at) => {
        if (!stands()) return;
        const p = pixel(at), near = (12 * size()[0]) / view.canvas.clientWidth;
        if (corners.length >= 3 && Math.hypot(p[0] - corners[0][0], p[1] - corners[0][1]) < near) return close();
        corners.push(p), show();
      },
      key: (e) => e.key === 'Enter' && (close(), true),
    };
    view.hand.take({ name: `mark_${kind}`, drags: true, ...tool, cancelled: () => ((from = null), (corners.length = 0), show()), dropped: () => ((this.drawn_corners = []), show()) });
  }
}
