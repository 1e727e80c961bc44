// Annotations: numbered texts at surface points. Drawn over the picture, faint where occluded; stored in the page address
// (note=X,Y,Z,TEXT) while short, and in a file.
import { button, download, element } from '../../page/elements.js';
import { file_button, section } from '../../page/controls.js';
import { svg } from './marks.js';
import { projected } from './cameras.js';

const kMostAddress = 1500;   // characters
const kMostText = 200;
const kCovering = 0.02;  // relative depth tolerance of the occlusion test
const kFormat = 'vitrine annotations 1';

const is_place = (p) => Array.isArray(p) && p.length === 3 && p.every((v) => typeof v === 'number' && Number.isFinite(v));

// Returns [{text, place}]; throws with a message for the user.
export function read_annotations(json) {
  let file;
  try {
    file = JSON.parse(json);
  } catch {
    throw new Error('it is no JSON');
  }
  if (file?.format !== kFormat || !Array.isArray(file.annotations)) throw new Error(`it has no "format": "${kFormat}" with a list "annotations"`);
  return file.annotations.map(({ text, position }, i) => {
    if (typeof text !== 'string' || !is_place(position)) throw new Error(`annotation ${i + 1} has no text, or no position of three numbers`);
    return { text: text.slice(0, kMostText), place: position };
  });
}

export class Annotations {
  constructor(view) {
    this.view = view, this.list = [];
    this.nothing = 'There is no surface to annotate.';
    this.opens = /\.json$/i;
  }
  take(place) {
    this.set([...this.list, { text: '', place }]);
  }
  ended() {}
  set(list) {
    this.list = list;
    if (!this.view.drawn) return;  // the first picture draws them
    this.view.draw_marks(), this.view.changed();
  }
  write(i, text) {
    this.list[i].text = text;
    this.view.draw_marks(), this.view.changed();
  }

  address() {
    const all = this.list.map(({ text, place }) => ['note', `${place.map((v) => v.toFixed(4))},${text}`]);
    return new URLSearchParams(all).toString().length <= kMostAddress ? all : [];
  }
  restore(query) {
    const read = query.getAll('note').map((note) => note.match(/^([^,]*),([^,]*),([^,]*),(.*)$/s)).filter(Boolean);
    this.set(read.map(([, x, y, z, text]) => ({ text: text.slice(0, kMostText), place: [x, y, z].map(Number) })).filter((n) => is_place(n.place)));
  }
  json() {
    const { metres_per_unit } = this.view.scene;
    return JSON.stringify({
      format: kFormat, frame: 'that of scene.json, z up', unit: metres_per_unit ? `${metres_per_unit} m` : 'radius of the camera ring, scale unknown',
      annotations: this.list.map(({ text, place }) => ({ text, position: place })),
    }, null, 1) + '\n';
  }
  async open(file) {
    try {
      const list = read_annotations(await file.text());
      this.view.tell('');
      this.set(list);
    } catch (e) {
      this.view.tell(`${file.name} holds no annotations: ${e.message}. Open a file that this page saved.`);
    }
  }

  // True if a surface occludes the point in the last picture, or the clip plane hides its surface.
  covered(place) {
    const { drawn, picture, clip } = this.view, [x, y, z] = projected(drawn, place), n = clip.plane(drawn);
    const depth = x >= 0 && y >= 0 && x < drawn.width && y < drawn.height ? picture.depth_at(x, y) : 0;
    return (depth > 0 && depth < (1 - kCovering) * z) || place.reduce((sum, v, i) => sum + n[i] * v, 0) < n[3];
  }
  marks(on_screen) {
    return this.list.flatMap(({ text, place }, i) => {
      const [x, y, z] = on_screen(place);
      if (!(z > 0)) return [];
      const mark = svg('g', { class: this.covered(place) ? 'note covered' : 'note' });
      mark.append(svg('circle', { cx: x, cy: y, r: 9 }), svg('text', { x, y: y + 4, class: 'number' }, i + 1), svg('text', { x: x + 14, y: y + 5 }, text));
      return [mark];
    });
  }
}

export function annotations_section(view) {
  const { notes } = view, list = element('ol', { id: 'notes' });
  const annotate = button('Annotate', () => view.use(notes), { id: 'annotate' });
  const save = button('Save', () => download('annotations.json', new Blob([notes.json()], { type: 'application/json' })), { id: 'save_notes' });
  const row_of = ({ text }, i) => {
    const input = element('input', { type: 'text', value: text, maxLength: kMostText, placeholder: 'text', oninput: () => notes.write(i, input.value) });
    input.setAttribute('aria-label', `text of annotation ${i + 1}`);
    const remove = button('\u00d7', () => notes.set(notes.list.filter((_, k) => k !== i)));
    remove.setAttribute('aria-label', `delete annotation ${i + 1}`);
    return element('li', {}, element('div', { className: 'row' }, input, remove));
  };
  let shown = null;
  const show = () => {
    annotate.setAttribute('aria-pressed', view.tool === notes);
    save.disabled = notes.list.length === 0;
    if (shown === notes.list) return;  // keeps the cursor in a text being typed
    const added = shown && notes.list.length === shown.length + 1 && view.tool === notes;
    shown = notes.list;
    list.replaceChildren(...shown.map(row_of));
    if (added) list.querySelector('li:last-child input').focus();
  };
  const hint = element('p', { textContent: 'A click on a surface sets a number; its text is written here.' });
  return { nodes: section('Annotations', element('div', { className: 'row' }, annotate, save, file_button('Open\u2026', 'open_notes', '.json', (file) => notes.open(file))), hint, list), show };
}
