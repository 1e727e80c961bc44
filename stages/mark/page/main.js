// The page: state of marks, view and storage. Tests use window.vitrine.
import { mask_pictures } from './carried.js';
import { refusals, state_of } from './checks.js';
import { take_dropped_files } from './file.js';
import { Hand } from './hand.js';
import { Kept } from './kept.js';
import { listen_to_keys } from './keys.js';
import { add_thing, empty_marks, History, remove_thing, words_of } from './marks.js';
import { marks_of } from './opened.js';
import { make_panel } from './panel.js';
import { Pen } from './pen.js';
import { Selection } from './selection.js';
import { Sheet } from './sheet.js';

const kPictures = 6;  // decoded pictures in the cache

const part = (id) => JSON.parse(document.getElementById(id).textContent);

class Work {
  constructor() {
    this.scene = part('scene'), this.small = part('small'), this.photos = part('photos');
    this.pictures = new Map(), this.masks = new Map(), this.listeners = [];
    this.tool = 'outline', this.pen = new Pen(this), this.selection = new Selection(this);
    this.hidden = false, this.masks_shown = true;
    this.kept = new Kept(this.scene.id);
    this.sheet = new Sheet(document.getElementById('sheet'), () => this.shown(), document.getElementById('tools'), document.getElementById('turn'));
    this.begin();
    this.hand = new Hand(this.sheet, this);
    addEventListener('beforeunload', (e) => this.dirty && e.preventDefault());
    listen_to_keys(this), take_dropped_files(this);
    make_panel(this);
    this.show(this.photo_index);
    this.sheet.fit();  // the tools have their final size
  }

  // Loads the marks of the run or the file, then unsaved marks of the browser on top.
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
      this.doc = kept.doc, this.pen.drawing = kept.drawing ?? null, this.saved = kept.saved ?? this.saved;
      this.photo_index = Math.max(0, this.scene.photos.findIndex((p) => p.name === kept.photo)), this.thing = kept.thing;
      this.history.push(this.doc);
      if (this.dirty)
        this.tell(`What you drew here until ${new Date(kept.time).toLocaleString()} and did not save is back.`, ['Begin without it', () => ((this.pen.drawing = null), this.travel(-1))]);
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
    return JSON.stringify(this.doc) !== this.saved || !!this.pen.drawing;
  }
  tell(text, ...actions) {
    const notice = document.getElementById('notice');
    notice.replaceChildren(text ?? '');
    for (const [word, act] of actions)
      notice.append(Object.assign(document.createElement('button'), { type: 'button', textContent: word, onclick: () => (this.tell(''), act()) }));
    notice.hidden = !text;
  }
  // State for drawing the sheet.
  shown() {
    const pictures = this.masks_shown && this.photo.masks ? this.mask_pictures() : {};
    return { doc: this.doc, thing: this.thing, selected: this.selection.chosen, drawing: this.pen.drawing, hover: this.pen.hovered, hidden: this.hidden,
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
  // Rounds to tenths of a pixel, as in the file.
  rounded(doc) {
    for (const m of doc.marks) m.corners = m.corners.map((p) => p.map((v) => Math.round(10 * v) / 10));
  }
  keep() {
    const fine = this.kept.write({ doc: this.doc, drawing: this.pen.drawing, photo: this.photo.name, thing: this.thing, saved: this.saved });
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
    this.doc = this.history.step(by);
    this.selection.find_again();
    if (!this.doc.things.some((t) => t.id === this.thing)) this.thing = this.doc.things[0]?.id ?? null;
    this.keep();
    this.changed();
  }
  undo() {
    if (!this.pen.take_back()) this.travel(-1);
  }
  redo() {
    this.travel(1);
  }
  // Deletes the last corner of an open outline, otherwise the selection.
  delete() {
    if (this.pen.drawing) this.undo();
    else this.selection.delete();
  }

  // --- objects

  add(kind) {
    this.pen.cancel(false);
    this.thing = add_thing(this.doc, kind).id, this.selection.clear();
    if (this.tool === 'change') this.tool = 'outline';
    this.tell('');
    this.commit();
  }
  remove(id) {
    const thing = this.doc.things.find((t) => t.id === id), marks = this.doc.marks.filter((m) => m.thing === id).length;
    if (this.thing === id) this.pen.cancel(false);
    remove_thing(this.doc, id);
    this.selection.clear();
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
    this.pen.leave();
    this.thing = id;
    this.pen.go_on();
    if (this.selection.chosen?.mark.thing !== id) this.selection.clear();
    this.keep(), this.changed();
  }

  set_tool(tool) {
    if (tool !== 'outline') this.pen.cancel(false);
    this.tool = tool;
    this.selection.follow();
    this.sheet.canvas.classList.toggle('change', tool === 'change');
    this.changed();
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
    if (other) this.pen.leave();
    this.photo_index = (i + n) % n;
    if (other) this.pen.go_on();
    this.selection.follow(), this.pen.hovered = null;
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

  // --- checks

  state_of(thing) {
    return state_of(this.doc, thing, this.scene);
  }
  refusals() {
    return refusals(this.doc, this.scene);
  }
}

window.vitrine = new Work();
