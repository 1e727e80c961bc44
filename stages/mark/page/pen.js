// The shape being drawn: an open outline, or a box during a drag. When closed it becomes the mark of the selected object in the
// photo.
import { kClasses, put_mark, words_of } from './marks.js';

export class Pen {
  constructor(work) {
    this.work = work, this.drawing = null, this.hovered = null;
    this.begun = new Map();  // object and photo -> unfinished outline
  }
  hover(place) {
    this.hovered = place;
    if (this.drawing) this.work.sheet.draw_soon();
  }
  ready() {
    if (this.work.thing !== null) return true;
    this.work.tell('What is it?', ...Object.entries(kClasses).map(([kind, { word }]) => [word, () => this.work.add(kind)]));
    return false;
  }
  add_corner(place) {
    if (!this.ready()) return;
    this.drawing ??= { box: false, corners: [] };
    this.drawing.corners.push(place);
    this.work.keep(), this.work.changed();
  }
  draw_box(from, to) {
    if (!this.ready()) return;
    this.drawing = { box: true, corners: [from.map((v, i) => Math.min(v, to[i])), from.map((v, i) => Math.max(v, to[i]))] };
    this.work.sheet.draw_soon();
  }
  finish_box(fine) {
    if (!this.drawing?.box || !fine) {
      this.cancel();
      if (this.work.thing !== null) this.work.tell('Drag from one corner of the box to the opposite one.');
      return;
    }
    this.put();
  }
  close() {
    if (!this.drawing || this.drawing.box) return;
    if (this.drawing.corners.length < 3) return this.work.tell('An outline has three corners or more.');
    this.put();
  }
  put() {
    const mark = { thing: this.work.thing, photo: this.work.photo.name, ...this.drawing };
    this.drawing = null;
    const word = words_of(this.work.doc.things.find((t) => t.id === this.work.thing));
    this.work.tell('');
    if (put_mark(this.work.doc, mark)) this.work.tell(`${word} has one mark in a photo: the new one stands in the place of the one before.`, ['Undo', () => this.work.undo()]);
    this.work.selection.chosen = { mark, corner: null };
    this.work.commit();
  }
  cancel(change = true) {
    if (!this.drawing) return;
    this.drawing = null;
    if (change) this.work.keep(), this.work.changed();
  }

  // Keeps an unfinished outline for its object and photo.
  leave() {
    if (this.drawing && !this.drawing.box) this.begun.set(`${this.work.thing} ${this.work.photo.name}`, this.drawing);
    this.cancel(false);
  }
  go_on() {
    const key = `${this.work.thing} ${this.work.photo.name}`;
    if (this.work.tool !== 'outline' || !this.begun.has(key)) return;
    this.drawing = this.begun.get(key);
    this.begun.delete(key);
  }
  // Removes the last corner; returns whether there was one.
  take_back() {
    if (!this.drawing || this.drawing.box) return false;
    this.drawing.corners.pop();
    if (!this.drawing.corners.length) this.drawing = null;
    this.work.keep(), this.work.changed();
    return true;
  }
}
