// View state and interaction: camera, mode, light, photo, clicks. Pictures are drawn on changes only: reduced and without
// reflections in panes while the camera moves in a slow browser, in full when it rests.
import { PerspectiveCamera, Vector3, WebGLRenderer } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { Annotations } from './annotations.js';
import { ClipPlane } from './clip_plane.js';
import { from_three, projected, resized, stand_at, transforms_json, unprojected } from './cameras.js';
import { take_dropped_files } from './dropped_files.js';
import { Hand } from './hand.js';
import { listen_to_keys } from './keys.js';
import { lit } from './lamps.js';
import { Measures } from './measures.js';
import { Objects } from './objects.js';
import { kModes, Picture } from './picture.js';
import { evening, read_sky, sky, studio } from './sky.js';
import { TwoRuns } from './two_runs.js';
import { read_state, write_state } from './url_state.js';

const kSlow = 80;  // milliseconds per picture; above it moving pictures are reduced
const kMovingScale = 0.4;
const kRest = 180;  // milliseconds without movement
const kMostSide = 4095;  // maximum side of a picture, pixels

export class View {
  constructor(page, tell) {
    this.page = page, this.scene = page.scene, this.tell = tell;
    this.canvas = document.getElementById('picture');
    this.frame = document.getElementById('frame');
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: false, alpha: false, preserveDrawingBuffer: true });
    this.picture = new Picture(this.renderer, page);
    this.listeners = [];
    this.skies = this.scene.relit ? { photos: this.captured(), studio: studio(), evening: evening() } : {};
    this.path = [];
    this.clip = new ClipPlane(this.scene.middle, this.picture.surfels.places.subarray(0, 3 * this.scene.solid));
    this.clip.on_change = () => (this.show_state(), this.adjusting());
    this.objects = new Objects(this.scene.objects);
    this.objects.on_change = () => (this.picture.hide_objects(this.objects.hidden), this.show_state(), this.adjusting());
    this.measures = new Measures(this), this.notes = new Annotations(this), this.runs = new TwoRuns(this);
    this.kept = [this.clip, this.notes, this.objects];  // parts with entries in the page address: address(), restore(query)
    this.marked = [this.measures, this.notes];  // parts that draw over the picture: marks(on_screen, {camera, sx, sy: screen pixels per camera pixel})
    this.filed = [this.notes, this.runs];  // parts that open files: opens, open(file)

    this.eye = new PerspectiveCamera();
    this.eye.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.eye, this.canvas);
    this.controls.enableDamping = false;
    this.controls.zoomToCursor = true;
    this.controls.addEventListener('change', () => this.moved());
    this.reset(false);
    this.state = { mode: 'photo', base: 'photo', light: 'photos', turn: 0, exposure: null, background: true, sky: 1, lamps: [], photo: null };
    this.slow = true;  // until measured

    listen_to_keys(this.canvas, this);
    this.hand = new Hand(this);
    new ResizeObserver(() => this.draw()).observe(document.getElementById('stage'));
    take_dropped_files(this);
    const wanted = read_state();
    this.set(wanted, false);
    for (const part of this.kept) part.restore(wanted.query);
    if (wanted.eye && wanted.target) this.look(wanted.eye, wanted.target);
    if (wanted.photo) this.show_photo(this.scene.cameras.findIndex((c) => c.name === wanted.photo));
    this.first_picture = new Promise((done) => (this.first = done));
    this.draw();
  }

  captured() {
    const data = this.page.blocks.captured, height = Math.sqrt(data.length / 6);
    return sky('photos', 2 * height, height, data);
  }

  // Calls `listener` after every state change.
  on_change(listener) {
    this.listeners.push(listener);
  }
  show_state() {
    for (const f of this.listeners) f(this.state);
  }
  changed() {
    this.show_state();
    const photo = this.photo === undefined ? null : this.scene.cameras[this.photo].name;
    write_state(this.state, this.eye.position.toArray(), this.controls.target.toArray(), photo, this.kept.flatMap((part) => part.address()));
  }

  // Any of: mode, light, turn (degrees), sky (brightness), lamps (lamps.js), exposure (stops), background.
  set(some, draw = true) {
    const s = this.state;
    for (const key of ['mode', 'light', 'turn', 'sky', 'lamps', 'exposure', 'background']) if (some[key] !== undefined) s[key] = some[key];
    if (!kModes[s.mode] || (kModes[s.mode].lit && !this.scene.relit)) s.mode = 'photo';
    if (s.mode === 'photo' || s.mode === 'relit') s.base = s.mode;
    if (!this.skies[s.light]) s.light = Object.keys(this.skies)[0] ?? '';
    const light = this.skies[s.light];
    const shining = [light, s.turn, s.sky, s.lamps];
    if (light && shining.some((v, i) => v !== this.shining?.[i])) {
      this.lighting = lit(light, s);
      this.picture.set_light(...this.lighting);
      if (this.shining?.[0] !== light && some.exposure === undefined) s.exposure = null;
      this.shining = shining;
    }
    if (s.exposure === null) s.exposure = light ? this.picture.exposure_of_scene() : 0;
    if (draw) this.changed(), this.draw();
  }

  // Like `set` for values that follow the mouse: reduced pictures and no address update until it rests.
  adjust(some) {
    this.set(some, false);
    this.show_state(), this.adjusting();
  }

  // ---- camera

  look(eye, target) {
    this.eye.position.fromArray(eye), this.controls.target.fromArray(target);
    this.controls.update();
  }
  // Camera of the first photo.
  reset(draw = true) {
    this.leave_photo();
    const [width, height] = this.room();
    stand_at(this.eye, this.controls.target, this.scene.cameras[0], this.scene.middle, width / height);
    this.controls.update();
    if (draw) this.changed(), this.draw();
  }
  // Frames the whole scene from the current side.
  frame_scene() {
    this.leave_photo();
    const middle = new Vector3(...this.scene.middle), way = this.eye.position.clone().sub(this.controls.target).normalize();
    this.controls.target.copy(middle);
    this.eye.position.copy(middle).addScaledVector(way, (0.75 * this.scene.radius) / Math.tan((this.eye.fov * Math.PI) / 360));
    this.controls.update();
    this.changed(), this.draw();
  }
  moved() {
    if (this.photo !== undefined) this.leave_photo();
    if (this.state) this.adjusting();
  }
  // Reduced pictures until the movement ends.
  adjusting() {
    this.resting = false;
    this.draw();
    clearTimeout(this.rest);
    this.rest = setTimeout(() => ((this.resting = true), this.changed(), this.draw()), kRest);
  }
  // ---- photos

  show_photo(index) {
    const camera = this.scene.cameras[index];
    if (!camera) return;
    stand_at(this.eye, this.controls.target, camera, this.scene.middle);
    this.photo = undefined;  // ignores the controls' event of this move
    this.controls.update();
    this.photo = index;
    const img = document.getElementById('photo'), split = document.getElementById('split');
    img.hidden = split.hidden = !this.page.photos[index];
    if (this.page.photos[index]) img.src = this.page.photos[index], img.alt = camera.name;
    split.oninput = () => img.style.setProperty('--split', `${split.value}%`);
    split.oninput();
    clearTimeout(this.rest);
    this.resting = true;
    this.changed(), this.draw();
  }
  leave_photo() {
    this.photo = undefined;
    document.getElementById('photo').hidden = document.getElementById('split').hidden = true;
    this.frame.style.cssText = '';
  }

  // ---- rendering

  // Available size on the screen.
  room() {
    const { clientWidth, clientHeight } = document.getElementById('stage');
    return [clientWidth / (this.runs?.other ? 2 : 1), clientHeight];
  }
  // Camera of a picture of this size.
  camera(width, height) {
    return this.photo === undefined ? from_three(this.eye, width, height) : resized(this.scene.cameras[this.photo], width, height);
  }
  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.paint();
    });
  }
  paint() {
    if (this.photo !== undefined) {  // aspect of the photo
      const { width, height } = this.scene.cameras[this.photo], [wide, high] = this.room(), scale = Math.min(wide / width, high / height);
      this.frame.style.cssText = `width:${Math.floor(width * scale)}px;height:${Math.floor(height * scale)}px`;
    }
    const small = this.first || (!this.resting && this.slow), scale = Math.min(devicePixelRatio, 2) * (small ? kMovingScale : 1);
    const size = [this.canvas.clientWidth, this.canvas.clientHeight].map((v) => Math.min(kMostSide, Math.max(1, Math.round(v * scale))));
    const began = performance.now(), camera = this.camera(...size);
    this.runs.draw(camera, this.draw_now(camera, { panes: !small }));
    const gl = this.renderer.getContext(), one = new Uint8Array(4);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, one);  // waits for the GPU
    this.slow = (performance.now() - began) * (small ? 1 / kMovingScale ** 2 : 1) > kSlow;
    this.draw_marks();
    if (!this.first) return;
    this.first(this), (this.first = null), (this.resting = true);
    this.draw();
  }
  // Draws immediately at the size of the camera; `more`: overrides of the state (gain, exposure, mode ...). Returns the state
  // used
  draw_now(camera, more = {}) {
    this.renderer.setSize(camera.width, camera.height, false);
    const gain = this.photo === undefined ? [1, 1, 1] : this.scene.cameras[this.photo].gain;
    this.drawn = camera;
    const state = { ...this.state, clip: this.clip.plane(camera), gain, ...more };
    this.picture.draw(camera, state);
    return state;
  }
  // Draws the current view and returns it as PNG.
  async screenshot() {
    this.draw_now(this.camera(this.canvas.width, this.canvas.height));
    return new Promise((done) => this.canvas.toBlob(done, 'image/png'));
  }
  views_json(path) {
    return transforms_json(path ? this.path : [this.camera(this.canvas.width, this.canvas.height)]);
  }
  add_to_path() {
    this.path.push(this.camera(this.canvas.width, this.canvas.height));
    this.changed();
  }

  // ---- light from files

  async light_of(file) {
    try {
      const map = read_sky(file.name, await file.arrayBuffer());
      this.skies[file.name] = map;
      this.tell('');
      this.set({ light: file.name, turn: 0, mode: 'relit', exposure: null });
    } catch (e) {
      this.tell(e.message);
    }
  }
  // ---- clicks on surfaces

  // Active tool for clicks on surfaces (take(place), nothing: message where there is no surface, ended()), or null.
  get tool() {
    return this.hand.tool?.on_surface ?? null;
  }
  // Makes a tool active; a second call deactivates it.
  use(tool) {
    if (this.tool === tool) return this.hand.drop();
    this.hand.take({ name: 'surface', on_surface: tool, clicked: (at) => this.touched(tool, at), dropped: () => (tool.ended(), this.draw_marks()) });
  }
  touched(tool, { x, y }) {
    const z = this.picture.depth_at(x, y);
    if (!(z > 0)) return this.tell(tool.nothing);
    this.tell('');
    tool.take(unprojected(this.drawn, x, y, z));
    this.draw_marks(), this.changed();
  }
  draw_marks() {
    const svg = document.getElementById('marks'), k = this.drawn, sx = svg.clientWidth / k.width, sy = svg.clientHeight / k.height;
    const on_screen = (place) => {
      const [x, y, z] = projected(k, place);
      return [x * sx, y * sy, z];
    };
    svg.replaceChildren(...this.marked.flatMap((part) => part.marks(on_screen, { camera: k, sx, sy })));
  }
}
