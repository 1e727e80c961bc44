// The picture of the volume: camera, drawing on changes only, reduced while it moves in a slow browser; a click puts the crosshair on
// what it hits.
import { element } from '../../page/elements.js';
import { Casting } from './casting.js';
import { direction, Orbit } from './orbit.js';
import { outlines } from './outlines.js';

const kSlow = 60;  // milliseconds per picture; above it moving pictures are reduced
const kLeastScale = 0.2;
const kCoarseGain = 1.5;  // by how much larger a picture with longer steps may be
const kFirstRows = 8;  // of a picture in bands
const kRest = 200;  // milliseconds without movement
const kMostSide = 2048;  // of a picture, pixels
const kTurn = 0.008, kKeyTurn = 0.08, kZoomStep = 1.12, kKeyMove = 0.05, kClick = 4;

export class VolumeView {
  constructor(state, transfer, cut, tell) {
    Object.assign(this, { state, transfer, cut, tell, volume: state.volume });
    this.canvas = element('canvas', { tabIndex: 0, id: 'picture' });
    this.canvas.setAttribute('role', 'img');
    this.canvas.setAttribute('aria-label', 'the volume; arrows turn it, plus and minus zoom');
    this.lines = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
    this.lines.setAttribute('aria-hidden', 'true');
    this.node = element('div', { className: 'pane', id: 'pane_volume' }, this.canvas, this.lines, element('span', { className: 'label', textContent: 'volume' }));
    this.orbit = new Orbit(this.volume), this.framed = true, this.scale = 0.5, this.resting = false, this.change = 0;
    try {
      this.casting = new Casting(this.canvas, this.volume);
    } catch (e) {
      this.node.append(element('p', { className: 'missing', textContent: `No picture of the volume: ${e.message}. The slices need none of it.` }));
      return;
    }
    this.casting.set_transfer(transfer);
    transfer.on_change(() => (this.casting.set_transfer(transfer), this.moved()));
    state.on_change((what) => (what === 'place' ? this.draw_lines() : what === 'window' && cut.axis && this.moved()));
    this.listen();
    new ResizeObserver(() => this.moved()).observe(this.canvas);
    this.first_picture = new Promise((done) => (this.first = done));
  }
  camera(width = this.canvas.clientWidth, height = this.canvas.clientHeight) {
    return this.orbit.camera(width, height);
  }

  // ---- drawing

  // After a change that may go on: a quick picture now, the full one when it rests.
  moved() {
    if (!this.casting) return;
    this.resting = false, ++this.change;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.rest(), kRest);
    this.waiting ??= requestAnimationFrame(() => {
      this.waiting = null;
      this.paint(this.scale, this.scale < 1);
    });
  }
  // Size of a picture.
  size(scale) {
    const { clientWidth: width, clientHeight: height } = this.canvas, density = Math.min(devicePixelRatio || 1, kMostSide / Math.max(width, height, 1));
    return width && height && !this.lost ? [width, height].map((length) => Math.max(1, Math.round(length * density * scale))) : null;
  }
  what(size, coarse) {
    const camera = this.camera(...size);
    return { camera, cut: this.cut.plane(camera), grey: [this.state.black, this.state.white], coarse };
  }
  // A whole picture at once; the scale of the next moving one follows from the time it took.
  paint(scale, coarse) {
    const size = this.size(scale);
    if (!size) return;
    const begin = performance.now();
    this.casting.draw(this.what(size, coarse), ...size);
    const wanted = scale * Math.sqrt(kSlow / Math.max(performance.now() - begin, 1)) * (coarse ? 1 : kCoarseGain);
    if (coarse || scale === 1) this.scale = wanted >= (coarse ? 1.2 : kCoarseGain) ? 1 : Math.max(kLeastScale, Math.min(0.8, wanted));
    this.draw_lines();
  }
  // The full picture, in bands that let the browser breathe; a change ends it.
  async rest() {
    const size = this.size(1), { change } = this;
    if (!size) return;
    if (this.scale === 1) this.paint(1, false);
    else {
      const what = this.what(size, false);
      this.casting.begin(...size);
      for (let row = 0, rows = kFirstRows; row < size[1]; ) {
        const begin = performance.now(), count = Math.min(rows, size[1] - row);
        this.casting.band(what, row, count);
        row += count, rows = Math.max(1, Math.round(Math.min(2, kSlow / Math.max(performance.now() - begin, 1)) * count));
        await new Promise((done) => setTimeout(done));
        if (change !== this.change || this.lost) return;
      }
      this.casting.show();
      this.draw_lines();
    }
    this.resting = true;
    this.first();
  }
  draw_lines() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    this.lines.setAttribute('viewBox', `0 0 ${width || 1} ${height || 1}`);
    this.lines.innerHTML = this.framed ? outlines(this.volume, this.state.place, this.camera()) : '';
  }

  // The first place along the ray of a pixel that hides half of what is behind it; null without one.
  hit(at) {
    const { volume } = this, camera = this.camera(), way = direction(camera, at), plane = this.cut.plane(camera), step = volume.cell / 2;
    const { opacities } = this.transfer.table(1024), far = Math.hypot(...camera.eye.map((v, c) => v - volume.middle[c]));
    let left = 1;
    for (let t = Math.max(0, far - volume.diagonal); t < far + volume.diagonal; t += step) {
      const place = camera.eye.map((v, c) => v + t * way[c]);
      if (plane[0] * place[0] + plane[1] * place[1] + plane[2] * place[2] < plane[3]) continue;
      const density = volume.density(place);
      if (density === null) continue;
      const opacity = opacities[Math.round(((density - volume.low) / (volume.high - volume.low || 1)) * 1023)];
      left *= (1 - opacity) ** ((100 * step) / volume.diagonal);
      if (left < 0.5) return place;
    }
    return null;
  }

  // ---- mouse, fingers, keys

  listen() {
    const { canvas, orbit } = this, fingers = new Map();
    let from = null, last = null, what = null;
    const point = (e) => {
      const box = canvas.getBoundingClientRect();
      return [e.clientX - box.left, e.clientY - box.top];
    };
    const short = () => Math.min(canvas.clientWidth, canvas.clientHeight) || 1;
    const middle = () => {
      const all = [...fingers.values()];
      return { at: [0, 1].map((c) => all.reduce((sum, p) => sum + p[c], 0) / all.length), span: all.length > 1 ? Math.hypot(all[0][0] - all[1][0], all[0][1] - all[1][1]) : 1 };
    };
    canvas.addEventListener('pointerdown', (e) => {
      canvas.setPointerCapture(e.pointerId);
      canvas.focus({ preventScroll: true });
      e.preventDefault();
      fingers.set(e.pointerId, point(e));
      what = fingers.size > 1 || e.button !== 0 || e.shiftKey ? 'move' : 'turn';
      from = what === 'turn' ? point(e) : null, last = middle();
    });
    canvas.addEventListener('pointermove', (e) => {
      if (!fingers.has(e.pointerId)) return;
      fingers.set(e.pointerId, point(e));
      const now = middle(), [dx, dy] = [now.at[0] - last.at[0], now.at[1] - last.at[1]];
      if (what === 'turn') orbit.rotate(-dx * kTurn, dy * kTurn);
      else orbit.move(dx / short(), -dy / short()), orbit.zoom(now.span / last.span || 1);
      last = now;
      this.moved();
    });
    const release = (e) => {
      const at = point(e), place = from && e.type === 'pointerup' && Math.hypot(at[0] - from[0], at[1] - from[1]) <= kClick ? this.hit(at) : null;
      if (place) this.state.go(place);
      fingers.delete(e.pointerId);
      from = what = null;
      if (fingers.size) what = 'move', last = middle();
    };
    canvas.addEventListener('pointerup', release);
    canvas.addEventListener('pointercancel', release);
    canvas.addEventListener('contextmenu', (e) => e.preventDefault());
    canvas.addEventListener('wheel', (e) => {
      e.preventDefault();
      orbit.zoom(kZoomStep ** Math.max(-3, Math.min(3, -e.deltaY / 100)));
      this.moved();
    }, { passive: false });
    canvas.addEventListener('keydown', (e) => this.key(e));
    canvas.addEventListener('webglcontextlost', (e) => {
      e.preventDefault();
      this.lost = true;
      this.tell('The browser took the memory of the picture of the volume back; it is drawn again when it can be.');
    });
    canvas.addEventListener('webglcontextrestored', () => {
      this.casting = new Casting(canvas, this.volume);
      this.casting.set_transfer(this.transfer);
      this.lost = false;
      this.tell('');
      this.moved();
    });
  }
  key(e) {
    const { orbit } = this, way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[e.key];
    if (way && e.shiftKey) orbit.move(way[0] * kKeyMove, way[1] * kKeyMove);
    else if (way) orbit.rotate(way[0] * kKeyTurn, way[1] * kKeyTurn);
    else if (e.key === '+' || e.key === '=') orbit.zoom(kZoomStep);
    else if (e.key === '-') orbit.zoom(1 / kZoomStep);
    else if (e.key === 'r') orbit.reset();
    else return;
    e.preventDefault();
    this.moved();
  }
}
