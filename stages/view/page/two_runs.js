// Comparison with another run: its page is parsed, never executed, and shown on the right with the same camera, light and mode.
import { WebGLRenderer } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { button, element } from '../../page/elements.js';
import { alignment, carried, carried_camera, carried_plane, yaw } from './alignment.js';
import { file_button, section } from '../../page/controls.js';
import { listen_to_keys } from './keys.js';
import { kModes, Picture } from './picture.js';
import { read_page } from './scene_data.js';

const kRough = 0.02;  // relative to the radius of the camera ring: alignment errors above this are reported

export class TwoRuns {
  constructor(view) {
    this.view = view, this.other = null;
    this.opens = /\.html?$/i;
  }
  async open(file) {
    const { view } = this;
    try {
      const page = await read_page(new DOMParser().parseFromString(await file.text(), 'text/html'));
      this.begin(file.name, page);
      view.tell('');
    } catch (e) {
      view.tell(`${file.name} cannot be shown beside this page: ${e.message}.`);
    }
  }
  begin(name, page) {
    const { view } = this, canvas = element('canvas', { tabIndex: 0 }), caption = element('p', { textContent: name });
    canvas.setAttribute('aria-label', 'the other run');
    const renderer = new WebGLRenderer({ canvas, antialias: false, alpha: false, preserveDrawingBuffer: true });
    let picture, aligned;
    try {
      picture = new Picture(renderer, page), aligned = alignment(view.scene, page.scene);
    } catch (e) {
      renderer.dispose(), renderer.forceContextLoss();
      throw new Error('its data are damaged', { cause: e });
    }
    this.end();
    const frame = element('div', { id: 'other' }, canvas, caption), facing = view.eye.quaternion.clone();
    document.getElementById('frame').after(frame);
    document.body.classList.add('two');
    // Both controls move the same camera around the same point.
    const controls = new OrbitControls(view.eye, canvas);
    Object.assign(controls, { enableDamping: false, zoomToCursor: true, target: view.controls.target });
    view.eye.quaternion.copy(facing);
    controls.addEventListener('change', () => view.moved());
    listen_to_keys(canvas, view);
    this.other = { name, page, renderer, picture, frame, controls, aligned };
    view.changed(), view.draw();
  }
  end() {
    if (!this.other) return;
    const { renderer, frame, controls } = this.other;
    controls.dispose(), renderer.dispose(), renderer.forceContextLoss(), frame.remove();
    this.other = null;
    document.body.classList.remove('two');
    this.view.changed(), this.view.draw();
  }

  // State of the last left picture.
  draw(camera, state) {
    if (!this.other) return;
    const { page, renderer, picture, frame, aligned } = this.other, { view } = this, lit = page.scene.relit;
    frame.style.cssText = view.frame.style.cssText;
    const photo = view.photo === undefined ? null : page.scene.cameras.find((c) => c.name === view.scene.cameras[view.photo].name);
    if (lit && view.lighting && this.other.lighting !== view.lighting) {
      const [map, turn, direct] = view.lighting;
      picture.set_light(map, turn + yaw(aligned), direct);
      this.other.lighting = view.lighting;
    }
    this.other.drawn = carried_camera(aligned, camera);
    renderer.setSize(camera.width, camera.height, false);
    picture.draw(this.other.drawn, {
      ...state, ...(lit && view.lighting ? {} : { mode: kModes[state.mode].lit ? 'photo' : state.mode, base: 'photo' }), gain: photo?.gain ?? state.gain,
      clip: carried_plane(aligned, state.clip), around: { middle: carried(aligned, view.scene.middle), radius: aligned.scale * view.scene.radius },
    });
    const gl = renderer.getContext();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));  // waits for the GPU
  }
  // Notes for the user about the right picture.
  text() {
    if (!this.other) return '';
    const { name, page, aligned: { cameras, by, scale, error } } = this.other, photos = cameras === 1 ? 'one photo' : `${cameras} photos`;
    const how = { centres: `aligned by the places of ${photos} of the same names`, rotations: `aligned by the rotations of ${photos} of the same names`,
                  nothing: 'no photo has the same name in both, so the same frame is assumed' }[by];
    const more = [scale === 1 ? '' : `, ${scale.toFixed(3)} times as large`, error > kRough ? `; the cameras are ${(100 * error).toFixed(0)} % of their ring apart` : ''];
    return `Right: ${name}, ${how}${more.join('')}.${page.scene.relit ? '' : ' It has no materials: where they are needed it is shown as photographed.'}${this.view.edits?.list.length || this.view.objects.hidden.size ? ' Edits and hidden objects concern the left alone.' : ''}`;
  }
}

export function two_runs_section(view) {
  const { runs } = view, told = element('p', { id: 'other_told' }), end = button('End', () => runs.end(), { id: 'end_other' });
  const show = () => {
    end.disabled = !runs.other;
    told.textContent = runs.text() || 'The view.html of another run is shown beside this one.';
  };
  return { nodes: section('Two runs', element('div', { className: 'row' }, file_button('Open view.html\u2026', 'open_other', '.html,.htm', (file) => runs.open(file)), end), told), show };
}
