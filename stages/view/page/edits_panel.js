// Panel section of the edits: list, selection and materials of the selected edit, file.
import { button, download, element } from '../../page/elements.js';
import { hex_of, linear_of } from './colors.js';
import { kMostTint } from './edit_list.js';
import { edit_outlines } from './edit_outlines.js';
import { Edits } from './edits.js';
import { file_button, keep_rows, slider } from '../../page/controls.js';

const row = (...children) => element('div', { className: 'row' }, ...children);
const label = (text, ...children) => element('label', { className: 'row' }, ...children, text);
const kKinds = { class: 'a class', object: 'an object', component: 'a component', box: 'a box', marks: 'marks in photos', all: 'everything' };
const kind_of = (select) => (select === 'all' ? 'all' : Object.keys(kKinds).find((k) => select[k] !== undefined) ?? '');

// Rows of the selection: one condition; selections with several conditions, from a file, are kept.
function selection_rows(edits, scene) {
  const { classes, no_classes, components } = scene.edits, objects = scene.objects.map((o) => o.name), rows = {};
  const kinds = Object.keys(kKinds).filter((k) => (k !== 'class' || classes.length) && (k !== 'object' || objects.length) && (k !== 'component' || components > 0));
  const by = element('select', { id: 'edit_by', onchange: () => (edits.view.hand.drop(), edits.change({ select: start[by.value]() })) }, element('option', { value: '', textContent: 'choose \u2026', hidden: true }), ...kinds.map((k) => element('option', { value: k, textContent: kKinds[k] })));
  const start = { class: () => ({ class: classes[0] }), object: () => ({ object: objects[0] }), component: () => (edits.pick_component(), { component: 1 }), box: () => ({ box: box_around() }), marks: () => ({ marks: [] }), all: () => 'all' };
  const box_around = () => [...scene.middle.map((v) => v - 0.25 * scene.radius), ...scene.middle.map((v) => v + 0.25 * scene.radius)].map((v) => Math.round(1000 * v) / 1000);

  const kind = element('select', { id: 'edit_class', onchange: () => edits.change({ select: { class: kind.value } }) }, ...classes.map((c) => element('option', { textContent: c })));
  rows.class = row(kind);
  const object = element('select', { id: 'edit_object', 'aria-label': 'object', onchange: () => edits.change({ select: { object: object.value } }) }, ...objects.map((name) => element('option', { value: name, textContent: name })));
  rows.object = row(object);
  const component = element('input', { type: 'number', id: 'edit_component', min: 1, max: components, step: 1, onchange: () => edits.change({ select: { component: Math.max(1, Math.round(Number(component.value))) } }) });
  rows.component = row(component, button('Click it in the picture', () => edits.pick_component(), { id: 'pick_component' }));
  const ends = Array.from({ length: 6 }, (_, i) => element('input', { type: 'number', id: `box_${i}`, step: 0.01, 'aria-label': `${'xyz'[i % 3]} ${i < 3 ? 'from' : 'to'}`, onchange: () => edits.change({ select: { box: ends.map((e) => Number(e.value)) } }) }));
  rows.box = element('div', {}, element('div', { className: 'thirds' }, ...ends), row(button('Two clicks in the picture', () => edits.pick_box(), { id: 'pick_box' })));
  const marks = element('div');
  rows.marks = element('div', {}, marks, row(button('Rectangle', () => edits.draw_mark('box'), { id: 'mark_box' }), button('Polygon', () => edits.draw_mark('polygon'), { id: 'mark_polygon' })),
    element('p', { textContent: 'Drawn at the place of a photo; two photos from different sides enclose a volume.' }));

  function show({ select }) {
    const shown = kind_of(select), { hand } = edits.view;
    by.value = shown;
    for (const [k, r] of Object.entries(rows)) r.hidden = k !== shown;
    if (shown === 'class') kind.value = select.class;
    if (shown === 'object') object.value = select.object;
    if (shown === 'component') component.value = select.component;
    if (shown === 'box') ends.forEach((e, i) => (e.value = Number(select.box[i].toFixed(4))));
    marks.replaceChildren(...(select.marks ?? []).map((m, i) => row(m.photo, button('\u00d7', () => edits.change({ select: { ...select, marks: select.marks.filter((_, k) => k !== i) } }), { title: 'remove this mark' }))));
    for (const b of ['pick_component', 'pick_box', 'mark_box', 'mark_polygon']) document.getElementById(b)?.setAttribute('aria-pressed', hand.has(b.replace('pick_', '')));
  }
  const why = no_classes ? [element('p', { textContent: `No classes to select: ${no_classes}.` })] : [];
  return { parts: [row(element('label', { htmlFor: 'edit_by', textContent: 'Select' }), by), ...Object.values(rows), ...why], show };
}

// Rows of the materials: a check box enables each value.
function material_rows(edits) {
  const shows = [], parts = [];
  const value = (key, text, usual, controls, show) => {
    const on = element('input', { type: 'checkbox', id: `edit_${key}_on`, onchange: () => edits.set(key, on.checked ? usual : undefined) });
    const box = element('div', {}, ...controls);
    shows.push(({ set, remove }) => {
      on.checked = set[key] !== undefined, on.disabled = remove, box.hidden = remove || !on.checked;
      if (on.checked) show(set[key]);
    });
    parts.push(label(text, on), box);
  };
  // A colour with the hue of the picker, times a factor.
  const tint = element('input', { type: 'color', id: 'edit_tint', oninput: () => tinted() });
  const factor = slider('Factor', 'edit_factor', 0, kMostTint, 0.05, '', () => tinted());
  const tinted = () => edits.set('tint', linear_of(tint.value).map((v) => Math.min(kMostTint, v * Number(document.getElementById('edit_factor').value))));
  value('tint', 'tint the albedo', [1, 1, 1], [row(tint), factor.row], (v) => {
    const most = Math.max(...v), now = Number(document.getElementById('edit_factor')?.value), shown = linear_of(tint.value).map((c) => c * now);
    if (v.some((c, i) => Math.abs(c - shown[i]) > 1e-4)) tint.value = hex_of(v.map((c) => (most > 0 ? c / Math.max(1, most) : 0))), factor.show(Math.max(1, most));
    else factor.show(now);
  });
  const f0 = element('input', { type: 'color', id: 'edit_f0', oninput: () => edits.set('f0', linear_of(f0.value)) });
  value('f0', 'reflectance head on (f0)', [0.04, 0.04, 0.04], [row(f0)], (v) => (f0.value = hex_of(v)));
  for (const [key, text, usual] of [['roughness', 'roughness', 0.3], ['k_s', 'specular weight (k_s)', 0.5]]) {
    const s = slider('', `edit_${key}`, 0, 1, 0.01, '', (v) => edits.set(key, v));
    s.input.setAttribute('aria-label', text);
    value(key, text, usual, [s.row], s.show);
  }
  const remove = element('input', { type: 'checkbox', id: 'edit_delete', onchange: () => edits.change({ remove: remove.checked, ...(remove.checked ? { set: {} } : {}) }) });
  shows.push((edit) => (remove.checked = edit.remove));
  return { parts: [label('delete it', remove), ...parts], show: (edit) => shows.forEach((f) => f(edit)) };
}

// Returns { parts: elements, show(), begin(object): a new edit of that object; missing where edits are unavailable }
export function edits_section(view, page) {
  const { scene } = page;
  if (!scene.edits.there) view.filed.push({ opens: /\.ya?ml$/i, open: (file) => view.tell(`${file.name} is not opened: ${scene.edits.why}`) });
  if (!scene.edits.there) return { parts: [element('p', { textContent: scene.edits.why })], show: () => {} };
  const edits = (view.edits = new Edits(view, page));
  view.marked.push({ marks: (_, { camera, sx, sy }) => edit_outlines(edits, camera, sx, sy) });
  view.filed.push({ opens: /\.ya?ml$/i, open: (file) => edits.open(file) });
  const select = selection_rows(edits, scene), material = material_rows(edits);
  const name = element('input', { type: 'text', id: 'edit_name', 'aria-label': 'name of the edit', onchange: () => edits.change({ name: name.value }) });
  const one = element('div', { id: 'edit', hidden: true }, row(name, button('Remove', () => edits.remove(), { id: 'remove_edit' })), ...select.parts, ...material.parts);
  const list = element('div', { id: 'edits' });
  const save = () => {
    const text = edits.yaml();
    if (text) download('edits.yaml', new Blob([text], { type: 'text/yaml' }));
  };
  const parts = [row(button('Add an edit', () => edits.add(), { id: 'add_edit' })), list, one,
    row(button('Save edits.yaml', save, { id: 'save_edits' }), file_button('Open\u2026', 'open_edits', '.yaml,.yml', (file) => edits.open(file))),
    element('p', {}, 'Then: ', element('code', { textContent: 'vitrine edit OUT edits.yaml' }))];
  function show() {
    keep_rows(list, edits.list.length, (i) => row(button('', () => edits.choose(i === edits.chosen ? -1 : i)), element('span')), ({ children: [choose, found] }, i) => {
      const count = edits.counts[i] ?? 0, wrong = edits.mistake(i);
      choose.textContent = edits.list[i].name, found.textContent = count ? `${count} surfels${wrong ? `; ${wrong}` : ''}` : wrong;
      choose.setAttribute('aria-pressed', i === edits.chosen);
    });
    one.hidden = !edits.one;
    if (!edits.one) return;
    if (document.activeElement !== name) name.value = edits.one.name;
    select.show(edits.one), material.show(edits.one);
  }
  const begin = (object) => (edits.add(object, { object }), edits.changed(), name.focus(), name.select());
  return { parts, show, begin };
}
