// The photo on the screen with the drawing on top. Positions are [x, y] in pixels of the original photo, or of the screen (CSS
// pixels from the corner of the canvas); zoom is screen pixels per photo pixel.
import { color_of, outline_of, problem_of, words_of } from './marks.js';

const kMargin = 14;  // around a fitted photo
const kMostZoom = 40;  // relative to the fitted zoom
const kHandle = 5;
const kFill = '2b';  // alpha of marked areas

export class Sheet {
  // `above`, `below`: elements that cover the top and the bottom of the canvas.
  constructor(canvas, changed, above, below) {
    this.canvas = canvas, this.context = canvas.getContext('2d'), this.changed = changed, this.covers = [above, below];
    this.zoom = 1, this.left = 0, this.top = 0, this.fitted = true;
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
  }
  resize() {
    const ratio = devicePixelRatio || 1, { clientWidth: w, clientHeight: h } = this.canvas;
    this.width = w, this.height = h, this.ratio = ratio;
    this.canvas.width = Math.max(1, Math.round(w * ratio)), this.canvas.height = Math.max(1, Math.round(h * ratio));
    if (this.photo && this.fitted) this.fit();
    this.draw_soon();
  }

  // `picture`: an image of the whole photo at any size; null while it loads.
  show(photo, picture) {
    const other = this.photo !== photo;
    this.photo = photo, this.picture = picture;
    if (other) this.fit();
    this.draw_soon();
  }
  // Top and height of the uncovered part.
  free() {
    const [above, below] = this.covers.map((e) => e.offsetHeight + kMargin);
    return [above, Math.max(1, this.height - above - below)];
  }
  fit_zoom() {
    return Math.max(1e-3, Math.min((this.width - 2 * kMargin) / this.photo.width, (this.free()[1] - 2 * kMargin) / this.photo.height));
  }
  fit() {
    const [top, height] = this.free();
    this.zoom = this.fit_zoom(), this.fitted = true;
    this.left = (this.width - this.photo.width * this.zoom) / 2, this.top = top + (height - this.photo.height * this.zoom) / 2;
    this.draw_soon();
  }
  to_photo([x, y]) {
    return [(x - this.left) / this.zoom, (y - this.top) / this.zoom];
  }
  to_screen([x, y]) {
    return [this.left + x * this.zoom, this.top + y * this.zoom];
  }
  // Clamps a position to the photo.
  in_photo(at) {
    const [x, y] = this.to_photo(at);
    return [Math.min(Math.max(x, 0), this.photo.width), Math.min(Math.max(y, 0), this.photo.height)];
  }
  pan(dx, dy) {
    this.left += dx, this.top += dy;
    this.hold();
  }
  zoom_at([x, y], factor) {
    const fit = this.fit_zoom(), zoom = Math.min(Math.max(this.zoom * factor, fit / 2), fit * kMostZoom), by = zoom / this.zoom;
    this.left = x + (this.left - x) * by, this.top = y + (this.top - y) * by, this.zoom = zoom;
    this.hold();
  }
  // Keeps a part of the photo on the screen.
  hold() {
    const w = this.photo.width * this.zoom, h = this.photo.height * this.zoom, part = 60;
    this.left = Math.min(Math.max(this.left, part - w), this.width - part), this.top = Math.min(Math.max(this.top, part - h), this.height - part);
    this.fitted = false;
    this.draw_soon();
  }

  draw_soon() {
    if (this.waiting) return;
    this.waiting = requestAnimationFrame(() => ((this.waiting = 0), this.draw()));
  }
  // State from `changed()`: { doc, thing, selected: { mark, corner }, drawing, hover, hidden, masks, editing }.
  draw() {
    const c = this.context, { photo } = this;
    c.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    c.clearRect(0, 0, this.width, this.height);
    if (!photo) return;
    const box = [this.left, this.top, photo.width * this.zoom, photo.height * this.zoom];
    c.fillStyle = '#8884', c.fillRect(...box);
    c.imageSmoothingQuality = 'high';
    if (this.picture) c.drawImage(this.picture, ...box);
    const state = this.changed();
    for (const mask of state.masks) c.drawImage(mask, ...box);
    if (state.hidden) return;
    for (const mark of state.doc.marks) if (mark.photo === photo.name) this.draw_mark(mark, state);
    if (state.drawing) this.draw_drawing(state);
  }

  path(corners, closed) {
    const c = this.context;
    c.beginPath();
    corners.forEach((p, i) => c[i ? 'lineTo' : 'moveTo'](...this.to_screen(p)));
    if (closed) c.closePath();
  }
  // A colour with a white outline, readable on any photo.
  stroke(color, width, dash = []) {
    const c = this.context;
    c.lineJoin = 'round';
    c.setLineDash([]), (c.strokeStyle = '#fffc'), (c.lineWidth = width + 2), c.stroke();
    c.setLineDash(dash), (c.strokeStyle = color), (c.lineWidth = width), c.stroke();
    c.setLineDash([]);
  }
  handle(at, color, { full = false, small = false } = {}) {
    const c = this.context, [x, y] = this.to_screen(at);
    c.beginPath(), c.arc(x, y, small ? kHandle - 2 : kHandle, 0, 7);
    c.fillStyle = full ? color : '#fff', c.strokeStyle = full ? '#fff' : color, c.lineWidth = 2;
    c.fill(), c.stroke();
  }
  draw_mark(mark, { doc, thing, selected, editing }) {
    const c = this.context, of = doc.things.find((t) => t.id === mark.thing), color = color_of(doc, of), corners = outline_of(mark);
    const chosen = mark === selected?.mark, wrong = problem_of(mark, this.photo);
    this.path(corners, true);
    c.fillStyle = color + kFill, c.fill('evenodd');
    this.stroke(color, mark.thing === thing ? 2.5 : 1.5, wrong ? [5, 4] : mark.box ? [9, 4] : []);
    if (chosen && editing && !mark.box) corners.forEach((a, i) => this.handle(middle(a, corners[(i + 1) % corners.length]), color, { small: true }));
    if (mark.thing === thing || chosen) corners.forEach((p, i) => this.handle(p, color, { full: chosen && selected.corner === i }));
    const [x, y] = this.to_screen(corners.reduce((top, p) => (p[1] < top[1] ? p : top)));
    const text = words_of(of) + (wrong ? `: ${wrong}` : '');
    c.font = '600 12px system-ui, sans-serif';
    const width = c.measureText(text).width, at = [Math.min(Math.max(x - width / 2, 8), this.width - width - 8), Math.max(y - 12, 16)];
    c.fillStyle = wrong ? '#a52a2f' : color, c.beginPath(), c.roundRect(at[0] - 6, at[1] - 13, width + 12, 18, 9), c.fill();
    c.fillStyle = '#fff', c.fillText(text, ...at);
  }
  draw_drawing({ doc, thing, drawing, hover }) {
    const of = doc.things.find((t) => t.id === thing), color = of ? color_of(doc, of) : '#888', c = this.context;
    const corners = drawing.box ? outline_of(drawing) : hover ? [...drawing.corners, hover] : drawing.corners;
    this.path(corners, drawing.box);
    if (!drawing.box && corners.length > 2) (c.fillStyle = color + '1c'), c.fill('evenodd');
    if (!drawing.box) this.path(corners, false);
    this.stroke(color, 2, drawing.box ? [9, 4] : []);
    if (!drawing.box) drawing.corners.forEach((p, i) => this.handle(p, color, { full: i === 0 && drawing.corners.length > 2 }));
  }
}

export const middle = (a, b) => [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
