// The control panel.
import { button, download, element } from '../../page/elements.js';
import { annotations_section } from './annotations.js';
import { clip_section } from './clip_plane.js';
import { confidence_legend } from './confidence.js';
import { file_button, slider } from '../../page/controls.js';
import { edits_section } from './edits_panel.js';
import { lamps_section } from './lamps_panel.js';
import { measures_section } from './measures.js';
import { objects_section } from './objects.js';
import { kModes } from './picture.js';
import { two_runs_section } from './two_runs.js';

export function make_panel(view, page) {
  const { scene, photos } = page;
  const panel = document.getElementById('panel'), changes = [];
  const section = (title, ...children) => panel.append(element('h2', { textContent: title }), ...children);
  panel.append(element('h1', { textContent: 'The scene' }));

  const modes = element('div', { className: 'grid', id: 'modes' });
  for (const [mode, { name, lit }] of Object.entries(kModes)) {
    const b = button(name, () => view.set({ mode }), { id: `mode_${mode}`, disabled: !!lit && !scene.relit });
    changes.push((s) => b.setAttribute('aria-pressed', s.mode === mode));
    modes.append(b);
  }
  const legend = confidence_legend();
  changes.push(legend.show);
  section('Show', modes, ...legend.nodes);
  if (!scene.relit) panel.append(element('p', { textContent: 'No materials are there yet (stage decompose), so the scene cannot be relit: finish vitrine run, then vitrine view.' }));

  if (scene.relit) {
    const names = { photos: 'light of the photos', studio: 'studio', evening: 'evening sun' };
    const select = element('select', { id: 'light', onchange: () => view.set({ light: select.value, mode: 'relit', exposure: null }) });
    const turn = slider('Turn', 'turn', 0, 360, 1, '\u00b0', (v) => view.adjust({ turn: v, mode: 'relit', exposure: view.state.exposure }));
    const exposure = slider('Exposure', 'exposure', -8, 8, 0.1, '', (v) => view.adjust({ exposure: v }));
    const background = element('input', { type: 'checkbox', id: 'background', onchange: () => view.set({ background: background.checked }) });
    changes.push((s) => {
      select.replaceChildren(...Object.keys(view.skies).map((key) => element('option', { value: key, textContent: names[key] ?? key })));
      select.value = s.light, background.checked = s.background;
      turn.show(s.turn), exposure.show(s.exposure);
    });
    section('Light', element('div', { className: 'row' }, select, file_button('HDRI\u2026', 'hdri', '.hdr,.exr', (file) => view.light_of(file))),
            turn.row, exposure.row, element('label', { className: 'row' }, background, 'show the light behind the scene'),
            element('p', { textContent: 'Or drop a .hdr or .exr file on the picture.' }));
    const lamps = lamps_section(view);
    changes.push(lamps.show);
    section('Lamps', ...lamps.parts);
  }

  section('Camera', element('div', { className: 'row' }, button('Start', () => view.reset(), { id: 'reset' }), button('Frame', () => view.frame_scene(), { id: 'frame_scene' })),
          element('p', { textContent: 'Drag turns, right button or two fingers move, wheel or pinch zooms. Keys: arrows, shift and arrows, + and -, r, f, 1 to 9.' }));

  const count = element('output', { id: 'path_count' });
  changes.push(() => (count.value = view.path.length ? `${view.path.length} on the path` : ''));
  const json = (path) => download(path ? 'path.json' : 'view.json', new Blob([view.views_json(path)], { type: 'application/json' }));
  section('Keep', element('div', { className: 'row' },
    button('Picture', async () => download('view.png', await view.screenshot()), { id: 'screenshot' }), button('View', () => json(false), { id: 'save_view' }),
    button('Add to path', () => view.add_to_path(), { id: 'add_path' }),
    button('Path', () => (view.path.length ? json(true) : view.tell('The path is empty: \u201cAdd to path\u201d puts this view on it.')), { id: 'save_path' }), count),
    element('p', { textContent: 'Views and paths are for vitrine render --views and vitrine relight --views.' }));

  const clip = clip_section(view.clip, scene.metres_per_unit === 1 ? ' m' : '', () => view.eye.position.toArray());
  const edits = edits_section(view, page);
  for (const { nodes, show } of [clip, measures_section(view), annotations_section(view), two_runs_section(view), objects_section(view.objects, edits.begin)]) {
    panel.append(...nodes);
    changes.push(show);
  }

  changes.push(edits.show);
  section('Edits', ...edits.parts);

  if (photos.length) {
    const list = element('div', { className: 'photos', id: 'photos' });
    scene.cameras.forEach((c, i) => list.append(button('', () => view.show_photo(i), { title: c.name + (c.heldout ? ' (held out)' : '') })));
    [...list.children].forEach((b, i) => {
      const { name, width, height } = scene.cameras[i];  // reserves the space before the picture loads
      b.append(element('img', { src: photos[i], alt: name, width, height, loading: 'lazy' }));
    });
    section('Photos', element('p', { textContent: 'A click goes where the photo was taken; the slider at the foot compares.' }), list);
  }
  const licences = document.getElementById('licences').content.textContent;
  panel.append(element('details', {}, element('summary', { textContent: 'Licences' }), element('pre', { textContent: `Made by vitrine, Apache-2.0.\n\n${licences}` })));

  view.on_change((s) => changes.forEach((f) => f(s)));
  view.changed();
}
