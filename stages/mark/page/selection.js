// The selected mark or corner, and its manipulation.
import { mark_in, outline_of } from './marks.js';
import { middle } from './sheet.js';

export class Selection {
  constructor(work) {
    this.work = work, this.chosen = null;  // { mark, corner: index or null }
  }
  clear() {
    this.chosen = null;
  }
  // With the tool "change", selects the mark of the current object in the current photo.
  follow() {
    const { work } = this, mark = work.tool === 'change' && mark_in(work.doc, work.thing, work.photo.name);
    this.chosen = mark ? { mark, corner: null } : null;
  }
  // Selects the same mark after undo.
  find_again() {
    const was = this.chosen?.mark, mark = was && mark_in(this.work.doc, was.thing, was.photo);
    this.chosen = mark ? { mark, corner: null } : null;
  }
  select(mark, corner) {
    this.chosen = mark && { mark, corner };
    if (mark) this.work.thing = mark.thing;
    this.work.changed();
  }
  // Position of the grabbed handle: a corner, or the middle of a side.
  place_of({ drawn, mark, corner, side }) {
    if (drawn !== undefined) return this.work.pen.drawing.corners[drawn];
    const corners = outline_of(mark);
    return side === undefined ? corners[corner] : middle(corners[side], corners[(side + 1) % corners.length]);
  }
  // Returns the grabbed corner after the move.
  move_corner(grip, place) {
    if (grip.drawn !== undefined) {
      this.work.pen.drawing.corners[grip.drawn] = place;
    } else {
      if (grip.side !== undefined) {
        grip = { mark: grip.mark, corner: grip.side + 1 };
        grip.mark.corners.splice(grip.corner, 0, place);
      }
      const { mark, corner } = grip;
      if (mark.box) {
        mark.corners[corner === 1 || corner === 2 ? 1 : 0][0] = place[0];
        mark.corners[corner >= 2 ? 1 : 0][1] = place[1];
      } else {
        mark.corners[corner] = place;
      }
      this.chosen = { mark, corner }, this.work.thing = mark.thing;
    }
    this.work.sheet.draw_soon();
    return grip;
  }
  put_down() {
    for (const m of this.work.doc.marks)
      if (m.box) m.corners = [[0, 1].map((k) => Math.min(m.corners[0][k], m.corners[1][k])), [0, 1].map((k) => Math.max(m.corners[0][k], m.corners[1][k]))];
    this.work.commit();
  }
  nudge(dx, dy) {
    const { mark, corner } = this.chosen, [x, y] = this.work.sheet.to_screen(this.place_of({ mark, corner }));
    this.move_corner({ mark, corner }, this.work.sheet.in_photo([x + dx, y + dy]));
    this.put_down();
  }
  // Deletes the selected corner, otherwise the mark.
  delete() {
    const { mark, corner } = this.chosen ?? { mark: mark_in(this.work.doc, this.work.thing, this.work.photo.name), corner: null };
    if (!mark) return;
    if (corner !== null && !mark.box && mark.corners.length > 3) {
      mark.corners.splice(corner, 1);
      this.chosen = { mark, corner: null };
    } else {
      this.work.doc.marks.splice(this.work.doc.marks.indexOf(mark), 1);
      this.chosen = null;
    }
    this.work.commit();
  }
}
