// Mouse input on the picture: goes to the active tool, or to the camera if there is none. A tool: {name, drags: true if it uses
// the left button, pressed, moved, released, clicked (at), cancelled, key (event) -> handled, dropped()}; all but the name are
// optional. `at`: {x, y} in pixels of the last picture; moves also have dx, dy in screen pixels.
const kClick = 4;  // maximum movement of a click, screen pixels

export class Hand {
  constructor(view) {
    this.view = view, this.tool = null, this.from = null;
    const { canvas } = view;
    canvas.addEventListener('pointerdown', (e) => this.press(e));
    canvas.addEventListener('pointermove', (e) => this.move(e));
    canvas.addEventListener('pointerup', (e) => this.release(e));
    canvas.addEventListener('pointercancel', () => this.cancel());
    addEventListener('keydown', (e) => (e.key === 'Escape' ? this.drop() : this.tool?.key?.(e) && e.preventDefault()));
  }
  take(tool) {
    this.drop();
    this.tool = tool;
    this.view.controls.enableRotate = !tool.drags;
    this.view.changed();
  }
  drop() {
    const { tool } = this;
    if (!tool) return;
    this.tool = this.from = null, this.view.controls.enableRotate = true;
    tool.dropped?.();
    this.view.changed();
  }
  has(name) {
    return this.tool?.name === name;
  }

  at(e) {
    const box = this.view.canvas.getBoundingClientRect(), k = this.view.drawn;
    return { x: ((e.clientX - box.left) / box.width) * k.width, y: ((e.clientY - box.top) / box.height) * k.height };
  }
  press(e) {
    if (!e.isPrimary) return this.cancel();  // a second finger: the camera takes over
    if (!this.tool || e.button !== 0 || e.shiftKey || e.ctrlKey || e.metaKey) return;
    this.from = this.last = [e.clientX, e.clientY];
    this.tool.pressed?.(this.at(e));
  }
  cancel() {
    if (this.from) this.tool?.cancelled?.();
    this.from = null;
  }
  move(e) {
    if (!this.tool || !this.from || !e.isPrimary) return;
    const [dx, dy] = [e.clientX - this.last[0], e.clientY - this.last[1]];
    this.last = [e.clientX, e.clientY];
    this.tool.moved?.({ ...this.at(e), dx, dy });
  }
  release(e) {
    if (!this.tool || !this.from || !e.isPrimary) return;
    const click = Math.hypot(e.clientX - this.from[0], e.clientY - this.from[1]) <= kClick, { tool } = this;
    this.from = null;
    tool.released?.(this.at(e), click);
    if (click) tool.clicked?.(this.at(e));
  }
}
