// The page: what is marked, what the hand does with it, what is kept. Tests talk to window.vitrine.
import { download } from '../../page/elements.js';
import { mask_pictures } from './carried.js';
import { refusals, state_of } from './checks.js';
import { Hand } from './hand.js';
import { Kept } from './kept.js';
import { add_thing, empty_marks, History, kClasses, mark_in, outline_of, put_mark, remove_thing, words_of } from './marks.js';
import { marks_of } from './opened.js';
import { make_panel } from './panel.js';
import { middle, Sheet } from './sheet.js';
import { read_yaml, yaml_of } from './yaml.js';

const kFile = 'marks.yaml';
const kPictures = 6;          // decoded at a time
const kStep = 40, kNudge = 1;  // screen pixels of an arrow key

const part = (id) => JSON.parse(document.getElementById(id).textContent);

class Work {
  constructor() {
    this.scene = part('scene'), this.small = part('small'), this.photos = part('photos');
    this.pictures = new Map(), this.masks = new Map(), this.listeners = [];
    this.tool = 'outline', this.selected = null, this.drawing = null, this.hovered = null;
    this.hidden = false, this.masks_shown = true;
    this.begun = new Map();  // photo -> outline that was left open there
    this.kept = new Kept(this.scene.id);
    this.sheet = new Sheet(document.getElementById('sheet'), () => this.shown(), document.getElementById('tools'), document.getElementById('turn'));
    this.begin();
    this.hand = new Hand(this.sheet, this);
    addEventListener('keydown', (e) => this.key(e));
    addEventListener('keyup', (e) => e.key === ' ' && (this.hand.space = false));
    addEventListener('beforeunload', (e) => this.dirty && e.preventDefault());
    for (const name of ['dragover', 'dragleave', 'drop']) addEventListener(name, (e) => this.dragged(e));
    make_panel(this);
    this.show(this.photo_index);
    this.sheet.fit();  // the tools are there now
  }

  // The marks of the run or the file; above them those that the browser kept, if they were not saved.
  begin() {
    let doc = empty_marks();
    if (this.scene.marks) {
      try {
        const opened = marks_of(this.scene.marks, this.scene.photos);
        doc = opened.doc;
        if (opened.notes.length) this.tell(`${this.scene.marks_name}: ${opened.notes.join(' ')}`);
      } catch (e) {
        this.tell(`${this.scene.marks_name} cannot be shown: ${e.message}.`);
      }
    }
    this.rounded(doc);
    this.doc = doc, this.history = new History(doc), this.saved = JSON.stringify(doc), this.photo_index = 0;
    const kept = this.kept.read();
    if (kept?.doc && (kept.doc.marks.length || kept.drawing) && (!this.scene.marks || JSON.stringify(kept.doc) !== kept.saved)) {
      this.doc = kept.doc, this.drawing = kept.drawing ?? null, this.saved = kept.saved ?? this.saved;
      this.photo_index = Math.max(0, this.scene.photos.findIndex((p) => p.name === kept.photo)), this.thing = kept.thing;
      this.history.push(this.doc);
      if (this.dirty)
        this.tell(`What you drew here until ${new Date(kept.time).toLocaleString()} and did not save is back.`, ['Begin without it', () => ((this.drawing = null), this.travel(-1))]);
    }
    if (!this.doc.things.some((t) => t.id === this.thing)) this.thing = this.doc.things[0]?.id ?? null;
  }

  on_change(listener) {
    this.listeners.push(listener);
  }
  get photo() {
    return this.scene.photos[this.photo_index];
  }
  get dirty() {
    return JSON.stringify(this.doc) !== this.saved || !!this.drawing;
  }
  tell(text, ...actions) {
    const notice = document.getElementById('notice');
    notice.replaceChildren(text ?? '');
    for (const [word, act] of actions)
      notice.append(Object.assign(document.createElement('button'), { type: 'button', textContent: word, onclick: () => (this.tell(''), act()) }));
    notice.hidden = !text;
  }
  // What the sheet draws.
  shown() {
    const pictures = this.masks_shown && this.photo.masks ? this.mask_pictures() : {};
    return { doc: this.doc, thing: this.thing, selected: this.selected, drawing: this.drawing, hover: this.hovered, hidden: this.hidden,
             masks: Object.values(pictures), editing: this.tool === 'change' };
  }
  mask_pictures() {
    if (!this.masks.has(this.photo_index)) this.masks.set(this.photo_index, mask_pictures(this.photo.masks));
    return this.masks.get(this.photo_index);
  }

  // --- changes

  changed() {
    for (const f of this.listeners) f();
    this.sheet.draw_soon();
  }
  // Tenths of a pixel, as in the file.
  rounded(doc) {
    for (const m of doc.marks) m.corners = m.corners.map((p) => p.map((v) => Math.round(10 * v) / 10));
  }
  keep() {
    const fine = this.kept.write({ doc: this.doc, drawing: this.drawing, photo: this.photo.name, thing: this.thing, saved: this.saved });
    if (!fine && !this.warned) this.tell('This browser keeps nothing between visits of a page: save before you leave.');
    this.warned ||= !fine;
  }
  commit() {
    this.rounded(this.doc);
    this.history.push(this.doc);
    this.keep();
    this.changed();
  }
  travel(by) {
    const was = this.selected?.mark;
    this.doc = this.history.step(by);
    this.selected = null;
    if (was && mark_in(this.doc, was.thing, was.photo)) this.selected = { mark: mark_in(this.doc, was.thing, was.photo), corner: null };
    if (!this.doc.things.some((t) => t.id === this.thing)) this.thing = this.doc.things[0]?.id ?? null;
    this.keep();
    this.changed();
  }
  undo() {
    if (!this.drawing || this.drawing.box) return this.travel(-1);
    this.drawing.corners.pop();
    if (!this.drawing.corners.length) this.drawing = null;
    this.keep(), this.changed();
  }
  redo() {
    this.travel(1);
  }

  // --- objects

  add(kind) {
    this.cancel_drawing(false);
    this.thing = add_thing(this.doc, kind).id, this.selected = null;
    if (this.tool === 'change') this.tool = 'outline';
    this.tell('');
    this.commit();
  }
  remove(id) {
    const thing = this.doc.things.find((t) => t.id === id), marks = this.doc.marks.filter((m) => m.thing === id).length;
    if (this.thing === id) this.cancel_drawing(false);
    remove_thing(this.doc, id);
    this.selected = null;
    if (this.thing === id) this.thing = this.doc.things[0]?.id ?? null;
    if (marks) this.tell(`${words_of(thing)} and its marks are gone.`, ['Undo', () => this.undo()]);
    this.commit();
  }
  remove_mark(id, photo) {
    this.doc.marks = this.doc.marks.filter((m) => m.thing !== id || m.photo !== photo);
    this.commit();
  }
  rename(id, name) {
    this.doc.things.find((t) => t.id === id).name = name.trim();
    this.commit();
  }
  choose(id) {
    if (this.thing === id) return;
    this.leave_drawing();
    this.thing = id;
    this.go_on_drawing();
    if (this.selected?.mark.thing !== id) this.selected = null;
    this.keep(), this.changed();
  }

  // --- drawing

  set_tool(tool) {
    if (tool !== 'outline') this.cancel_drawing(false);
    this.tool = tool;
    const mark = tool === 'change' && mark_in(this.doc, this.thing, this.photo.name);
    this.selected = mark ? { mark, corner: null } : null;
    this.sheet.canvas.classList.toggle('change', tool === 'change');
    this.changed();
  }
  hover(place) {
    this.hovered = place;
    if (this.drawing) this.sheet.draw_soon();
  }
  ready_to_draw() {
    if (this.thing !== null) return true;
    this.tell('What is it?', ...Object.entries(kClasses).map(([kind, { word }]) => [word, () => this.add(kind)]));
    return false;
  }
  add_corner(place) {
    if (!this.ready_to_draw()) return;
    this.drawing ??= { box: false, corners: [] };
    this.drawing.corners.push(place);
    this.keep(), this.changed();
  }
  draw_box(from, to) {
    if (!this.ready_to_draw()) return;
    this.drawing = { box: true, corners: [from.map((v, i) => Math.min(v, to[i])), from.map((v, i) => Math.max(v, to[i]))] };
    this.sheet.draw_soon();
  }
  finish_box(fine) {
    if (!this.drawing?.box || !fine) {
      this.cancel_drawing();
      if (this.thing !== null) this.tell('Drag from one corner of the box to the opposite one.');
      return;
    }
    this.put();
  }
  close() {
    if (!this.drawing || this.drawing.box) return;
    if (this.drawing.corners.length < 3) return this.tell('An outline has three corners or more.');
    this.put();
  }
  put() {
    const mark = { thing: this.thing, photo: this.photo.name, ...this.drawing };
    this.drawing = null;
    const word = words_of(this.doc.things.find((t) => t.id === this.thing));
    this.tell('');
    if (put_mark(this.doc, mark)) this.tell(`${word} has one mark in a photo: the new one stands in the place of the one before.`, ['Undo', () => this.undo()]);
    this.selected = { mark, corner: null };
    this.commit();
  }
  cancel_drawing(change = true) {
    if (!this.drawing) return;
    this.drawing = null;
    if (change) this.keep(), this.changed();
  }

  // An outline that is open waits where it was begun, for its object.
  leave_drawing() {
    if (this.drawing && !this.drawing.box) this.begun.set(`${this.thing} ${this.photo.name}`, this.drawing);
    this.cancel_drawing(false);
  }
  go_on_drawing() {
    const key = `${this.thing} ${this.photo.name}`;
    if (this.tool !== 'outline' || !this.begun.has(key)) return;
    this.drawing = this.begun.get(key);
    this.begun.delete(key);
  }

  // --- changing

  select(mark, corner) {
    this.selected = mark && { mark, corner };
    if (mark) this.thing = mark.thing;
    this.changed();
  }
  // What the hand holds: a corner, or the middle of a side.
  place_of({ drawn, mark, corner, side }) {
    if (drawn !== undefined) return this.drawing.corners[drawn];
    const corners = outline_of(mark);
    return side === undefined ? corners[corner] : middle(corners[side], corners[(side + 1) % corners.length]);
  }
  // Returns where the corner is held from now on.
  move_corner(grip, place) {
    if (grip.drawn !== undefined) {
      this.drawing.corners[grip.drawn] = place;
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
      this.selected = { mark, corner }, this.thing = mark.thing;
    }
    this.sheet.draw_soon();
    return grip;
  }
  put_down() {
    for (const m of this.doc.marks)
      if (m.box) m.corners = [[0, 1].map((k) => Math.min(m.corners[0][k], m.corners[1][k])), [0, 1].map((k) => Math.max(m.corners[0][k], m.corners[1][k]))];
    this.commit();
  }
  nudge(dx, dy) {
    const { mark, corner } = this.selected, [x, y] = this.sheet.to_screen(this.place_of({ mark, corner }));
    this.move_corner({ mark, corner }, this.sheet.in_photo([x + dx, y + dy]));
    this.put_down();
  }
  // The corner that is selected, else the mark.
  delete() {
    if (this.drawing) return this.undo();
    const { mark, corner } = this.selected ?? { mark: mark_in(this.doc, this.thing, this.photo.name), corner: null };
    if (!mark) return;
    if (corner !== null && !mark.box && mark.corners.length > 3) {
      mark.corners.splice(corner, 1);
      this.selected = { mark, corner: null };
    } else {
      this.doc.marks.splice(this.doc.marks.indexOf(mark), 1);
      this.selected = null;
    }
    this.commit();
  }

  // --- photos

  async picture(i) {
    if (!this.pictures.has(i)) {
      const image = new Image();
      image.src = this.photos[i];
      this.pictures.set(i, image);
      if (this.pictures.size > kPictures) this.pictures.delete(this.pictures.keys().next().value);
      await image.decode();
    }
    return this.pictures.get(i);
  }
  async show(i) {
    const n = this.scene.photos.length, other = i !== this.photo_index;
    if (other) this.leave_drawing();
    this.photo_index = (i + n) % n;
    if (other) this.go_on_drawing();
    const mark = this.tool === 'change' && mark_in(this.doc, this.thing, this.photo.name);
    this.selected = mark ? { mark, corner: null } : null, this.hovered = null;
    this.sheet.show(this.photo, null);
    if (other) this.keep();
    this.changed();
    const shown = this.photo_index, image = await this.picture(shown);
    if (shown !== this.photo_index) return;
    this.sheet.show(this.photo, image);
    this.picture((shown + 1) % n).catch(() => {});
  }
  show_named(name) {
    const i = this.scene.photos.findIndex((p) => p.name === name);
    if (i >= 0) this.show(i);
  }

  // --- the file

  state_of(thing) {
    return state_of(this.doc, thing, this.scene);
  }
  refusals() {
    return refusals(this.doc, this.scene);
  }
  yaml() {
    return yaml_of(this.doc, (name) => this.scene.photos.filter((p) => p.name === name).map((p) => [p.width, p.height])[0], this.scene.command);
  }
  // What a run would refuse is said first.
  save() {
    const refused = this.refusals();
    const write = () => {
      download(kFile, new Blob([this.yaml()], { type: 'application/yaml' }));
      this.saved = JSON.stringify(this.doc);
      this.keep();
      this.tell(`Saved as ${kFile}, where this browser puts its downloads. The command to run stands below \u201cFile\u201d.`);
      this.changed();
    };
    if (!refused.length) return write();
    this.tell(`A run would refuse this: ${refused.join(' ')}`, ['Save all the same', write]);
  }
  open_text(text, name) {
    try {
      const { doc, notes } = marks_of(read_yaml(text), this.scene.photos);
      this.cancel_drawing(false);
      const replaced = this.doc.marks.length > 0;
      this.doc = doc, this.selected = null, this.thing = doc.things[0]?.id ?? null;
      this.commit();
      const first = this.scene.photos.findIndex((p) => doc.marks.some((m) => m.photo === p.name));
      if (first >= 0) this.show(first);
      this.tell([`${name} is open: ${doc.marks.length} marks.`, ...notes].join(' '), ...(replaced ? [['Back to those before', () => this.undo()]] : []));
    } catch (e) {
      this.tell(`${name} is no file of marks: ${e.message}.`);
    }
  }
  async open(file) {
    this.open_text(await file.text(), file.name);
  }
  dragged(e) {
    if (![...(e.dataTransfer?.types ?? [])].includes('Files')) return;
    e.preventDefault();
    document.body.classList.toggle('dropping', e.type === 'dragover');
    if (e.type === 'drop' && e.dataTransfer.files[0]) this.open(e.dataTransfer.files[0]);
  }

  // --- keys

  key(e) {
    if (e.target.closest?.('input, textarea, select')) return;
    const act = this.action(e);
    if (!act) return;
    e.preventDefault();
    act();
  }
  action(e) {
    const { sheet } = this, centre = [sheet.width / 2, sheet.height / 2], on_button = e.target.closest?.('button, summary, label');
    if (e.ctrlKey || e.metaKey) {
      const k = e.key.toLowerCase();
      if (k === 's') return () => this.save();
      if (k === 'y' || (k === 'z' && e.shiftKey)) return () => this.redo();
      return k === 'z' ? () => this.undo() : null;
    }
    if (e.altKey) return null;
    if (/^[1-9]$/.test(e.key)) return this.doc.things[e.key - 1] ? () => this.choose(this.doc.things[e.key - 1].id) : null;
    const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[e.key];
    if (arrow && (on_button || e.target === document.body || e.target === sheet.canvas)) {
      const by = arrow.map((v) => v * (this.selected?.corner != null ? kNudge * (e.shiftKey ? 10 : 1) : kStep));
      return this.selected?.corner != null ? () => this.nudge(...by) : () => sheet.pan(-by[0], -by[1]);
    }
    if ((e.key === 'Enter' || e.key === ' ') && on_button) return null;
    switch (e.key) {
      case 'o': return () => this.set_tool('outline');
      case 'b': return () => this.set_tool('box');
      case 'c': return () => this.set_tool('change');
      case 'n': case 'PageDown': return () => this.show(this.photo_index + 1);
      case 'p': case 'PageUp': return () => this.show(this.photo_index - 1);
      case 'f': case '0': return () => sheet.fit();
      case '+': case '=': return () => sheet.zoom_at(centre, 1.25);
      case '-': return () => sheet.zoom_at(centre, 0.8);
      case 'h': return () => ((this.hidden = !this.hidden), this.changed());
      case 'm': return () => ((this.masks_shown = !this.masks_shown), this.changed());
      case 'Enter': return () => this.close();
      case 'Backspace': case 'Delete': return () => this.delete();
      case ' ': return () => (this.hand.space = true);
      case 'Escape': return () => (this.drawing ? this.cancel_drawing() : (this.tell(''), this.select(null, null)));
      default: return null;
    }
  }
}

window.vitrine = new Work();
