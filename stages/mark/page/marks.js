// Data model of the marks: objects with a class, at most one mark per object and photo. Corners are pixels of the original photo,
// upright; a box has two corners, top left and bottom right. Same rules as stages/masks.
import { area, crossing } from '../../page/polygon.js';

export const kClasses = {
  transparent: { word: 'Glass', doc: 'what is behind it shows through', colors: ['#2b87c8', '#79b9e6', '#12568a'] },
  specular: { word: 'Metal or mirror', doc: 'polished: it mirrors', colors: ['#e0861a', '#f2b566', '#a45a06'] },
  object: { word: 'Main object', doc: 'what the photos are about', colors: ['#3f9d56', '#7fc28d', '#1f6b35'] },
  ignore: { word: 'Not to be used', doc: 'a passer-by, a tripod, a hand', colors: ['#c2456b', '#e08aa4', '#86233f'] },
};
export const kEnough = 2, kWell = 3;  // minimum and recommended number of photos per object

export const empty_marks = () => ({ things: [], marks: [] });
export const words_of = (thing) => kClasses[thing.kind].word + (thing.name ? ` \u201c${thing.name}\u201d` : '');

export function color_of(doc, thing) {
  const alike = doc.things.filter((t) => t.kind === thing.kind), { colors } = kClasses[thing.kind];
  return colors[alike.indexOf(thing) % colors.length];
}

export function add_thing(doc, kind) {
  const alike = doc.things.filter((t) => t.kind === kind), taken = new Set(alike.map((t) => t.name));
  let name = '';
  for (let n = 2; taken.has(name); ++n) name = String(n);
  const thing = { id: 1 + Math.max(0, ...doc.things.map((t) => t.id)), kind, name };
  doc.things.push(thing);
  return thing;
}
export function remove_thing(doc, id) {
  doc.things = doc.things.filter((t) => t.id !== id);
  doc.marks = doc.marks.filter((m) => m.thing !== id);
}

export const mark_in = (doc, thing, photo) => doc.marks.find((m) => m.thing === thing && m.photo === photo);
export const marks_in = (doc, photo) => doc.marks.filter((m) => m.photo === photo);

// Replaces the mark of the object in this photo, if any.
export function put_mark(doc, mark) {
  const before = mark_in(doc, mark.thing, mark.photo);
  if (before) doc.marks[doc.marks.indexOf(before)] = mark;
  else doc.marks.push(mark);
  return !!before;
}

export function outline_of({ box, corners }) {
  if (!box) return corners;
  const [[l, t], [r, b]] = corners;
  return [[l, t], [r, t], [r, b], [l, b]];
}

// Reason why a run would reject a mark.
export function problem_of(mark, photo) {
  const corners = outline_of(mark);
  if (!photo) return 'is of a photo that is not here';
  if (corners.some(([x, y]) => x < 0 || y < 0 || x > photo.width || y > photo.height)) return 'leaves the photo';
  if (crossing(corners)) return 'crosses itself';
  return area(corners) === 0 ? 'encloses nothing' : '';
}

// Undo and redo: one state at a time.
export class History {
  constructor(doc) {
    this.states = [JSON.stringify(doc)], this.at = 0;
  }
  push(doc) {
    const state = JSON.stringify(doc);
    if (state === this.states[this.at]) return false;
    this.states.splice(++this.at, Infinity, state);
    return true;
  }
  get can_undo() {
    return this.at > 0;
  }
  get can_redo() {
    return this.at + 1 < this.states.length;
  }
  step(by) {
    this.at = Math.min(Math.max(this.at + by, 0), this.states.length - 1);
    return JSON.parse(this.states[this.at]);
  }
}
