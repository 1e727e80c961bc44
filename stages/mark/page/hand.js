// Mouse, pen and touch input on the photo. One pointer draws or moves corners; dragging elsewhere moves the photo. Two fingers
// move and zoom it. Results go to `work` (main.js): its pen and its selection.
import { inside } from '../../page/polygon.js';
import { mark_in, marks_in, outline_of } from './marks.js';
import { middle } from './sheet.js';

const kStill = { mouse: 4, pen: 6, touch: 10 };  // maximum movement of a click, pixels
const kReach = { mouse: 9, pen: 12, touch: 22 };  // pick radius of a corner, pixels
const kLeastBox = 4;

const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

export class Hand {
  constructor(sheet, work) {
    this.sheet = sheet, this.work = work, this.pointers = new Map(), this.space = false;
    const c = sheet.canvas;
    c.addEventListener('pointerdown', (e) => this.down(e));
    c.addEventListener('pointermove', (e) => this.move(e));
    for (const name of ['pointerup', 'pointercancel']) c.addEventListener(name, (e) => this.up(e, name === 'pointercancel'));
    c.addEventListener('pointerleave', () => work.pen.hover(null));
    c.addEventListener('wheel', (e) => this.wheel(e), { passive: false });
    c.addEventListener('dblclick', (e) => (e.preventDefault(), work.pen.close()));
    c.addEventListener('contextmenu', (e) => e.preventDefault());
  }
  place(e) {
    const box = this.sheet.canvas.getBoundingClientRect();
    return [e.clientX - box.left, e.clientY - box.top];
  }
  wheel(e) {
    e.preventDefault();
    const lines = e.deltaMode === 1 ? 16 : 1;
    this.sheet.zoom_at(this.place(e), Math.exp(-e.deltaY * lines * (e.ctrlKey ? 0.01 : 0.0015)));
  }

  // Handle at `at`: a corner of the open outline; with the tool "change", a corner or the middle of a side.
  grip(at, reach) {
    const { sheet, work } = this, near = (p) => distance(sheet.to_screen(p), at) <= reach;
    if (work.pen.drawing && !work.pen.drawing.box) {
      const i = work.pen.drawing.corners.findLastIndex(near);
      return i >= 0 ? { drawn: i } : null;
    }
    if (work.tool !== 'change') return null;
    const here = marks_in(work.doc, sheet.photo.name), first = work.selection.chosen?.mark ?? mark_in(work.doc, work.thing, sheet.photo.name);
    for (const mark of [first, ...here].filter((m) => m && here.includes(m))) {
      const corner = outline_of(mark).findIndex(near);
      if (corner >= 0) return { mark, corner };
    }
    const mark = work.selection.chosen?.mark;
    if (!mark || mark.box || !here.includes(mark)) return null;
    const side = mark.corners.findIndex((a, i) => near(middle(a, mark.corners[(i + 1) % mark.corners.length])));
    return side >= 0 ? { mark, side } : null;
  }

  down(e) {
    if (!this.sheet.photo) return;
    this.sheet.canvas.focus({ preventScroll: true });
    this.sheet.canvas.setPointerCapture(e.pointerId);
    const at = this.place(e);
    this.pointers.set(e.pointerId, at);
    if (this.pointers.size > 1) return this.drop();
    const pans = e.button > 0 || this.space;
    this.press = { id: e.pointerId, from: at, still: kStill[e.pointerType] ?? 6, reach: kReach[e.pointerType] ?? 12, what: pans ? 'pan' : 'click' };
    if (pans) return;
    const grip = this.grip(at, this.press.reach);
    if (grip) {
      const place = this.sheet.to_screen(this.work.selection.place_of(grip));
      Object.assign(this.press, { grip, off: [place[0] - at[0], place[1] - at[1]] });  // keeps the offset to the pointer
    } else if (this.work.tool === 'box') {
      this.press.what = 'box';
    }
  }
  // A second finger cancels the action of the first.
  drop() {
    if (this.press?.what === 'box') this.work.pen.cancel();
    if (this.press?.what === 'corner') this.work.selection.put_down();
    this.press = null;
  }

  move(e) {
    const at = this.place(e), before = this.pointers.get(e.pointerId);
    if (!before) return e.pointerType !== 'touch' && this.sheet.photo ? this.work.pen.hover(this.sheet.in_photo(at)) : undefined;
    if (this.pointers.size === 2) this.pinch(e.pointerId, before, at);
    this.pointers.set(e.pointerId, at);
    const press = this.press;
    if (!press || press.id !== e.pointerId) return;
    if (press.what === 'click' && distance(at, press.from) > press.still) press.what = press.grip ? 'corner' : 'pan';
    if (press.what === 'pan') this.sheet.pan(at[0] - before[0], at[1] - before[1]);
    if (press.what === 'corner') press.grip = this.work.selection.move_corner(press.grip, this.sheet.in_photo([at[0] + press.off[0], at[1] + press.off[1]]));
    if (press.what === 'box' && distance(at, press.from) > press.still) this.work.pen.draw_box(this.sheet.in_photo(press.from), this.sheet.in_photo(at));
  }
  pinch(id, before, at) {
    const other = [...this.pointers].find(([key]) => key !== id)[1];
    const from = middle(before, other), to = middle(at, other);
    this.sheet.pan(to[0] - from[0], to[1] - from[1]);
    this.sheet.zoom_at(to, distance(at, other) / Math.max(1, distance(before, other)));
  }

  up(e, cancelled) {
    if (!this.pointers.delete(e.pointerId)) return;
    const press = this.press;
    if (!press || press.id !== e.pointerId) return;
    this.press = null;
    const at = this.place(e);
    if (cancelled) return press.what === 'box' ? this.work.pen.cancel() : press.what === 'corner' ? this.work.selection.put_down() : undefined;
    if (press.what === 'click') this.click(at, press);
    if (press.what === 'corner') this.work.selection.put_down();
    if (press.what === 'box') this.work.pen.finish_box(distance(at, press.from) >= kLeastBox);
  }
  click(at, press) {
    const { work, sheet } = this;
    if (work.tool === 'outline') {
      const corners = work.pen.drawing?.corners ?? [];
      if (press.grip?.drawn === 0 && corners.length > 2) return work.pen.close();
      if (press.grip) return;  // a double click adds one corner only
      return work.pen.add_corner(sheet.in_photo(at));
    }
    if (press.grip?.corner !== undefined) return work.selection.select(press.grip.mark, press.grip.corner);
    const [x, y] = sheet.to_photo(at);
    const hit = marks_in(work.doc, sheet.photo.name).filter((m) => inside(outline_of(m), [x, y]));
    const next = hit[(hit.indexOf(work.selection.chosen?.mark) + 1) % Math.max(1, hit.length)];
    work.selection.select(next ?? null, null);
  }
}
