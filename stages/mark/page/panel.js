// Toolbar above the photo; side panel with objects, photos and the file.
import { button, element } from '../../page/elements.js';
import { open_file, save, yaml_text } from './file.js';
import { color_of, kClasses, marks_in } from './marks.js';

const kTools = { outline: ['Outline', 'o'], box: ['Box', 'b'], change: ['Change', 'c'] };
const kKeys = [
  ['o b c', 'outline, box, change'], ['Enter', 'closes the outline; or a click on its first corner, or a double click'], ['Backspace', 'takes back a corner, removes what is selected'],
  ['Esc', 'gives up the outline'], ['Ctrl Z, Ctrl Y', 'undo, redo'], ['1 to 9', 'the object to mark'], ['n p', 'next, previous photo'], ['+ - f', 'larger, smaller, the whole photo'],
  ['arrows', 'move the photo, or the corner that is selected (with shift: ten times as far)'], ['space, drag', 'moves the photo, as the right button does'], ['h', 'hides the marks'],
  ['m', 'shows the masks of the run'], ['Ctrl S', 'saves'],
];
const kSources = { boxes: 'from marks', proposed: 'proposed from the photos', files: 'from files', onnx: 'from a network' };

async function copy(text, said) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    const area = element('textarea', { value: text });
    document.body.append(area);
    area.select();
    document.execCommand('copy');
    area.remove();
  }
  said();
}

function toolbar(work) {
  const tools = document.getElementById('tools'), turn = document.getElementById('turn'), { sheet } = work;
  const middle = () => [sheet.width / 2, sheet.height / 2];
  const group = (...children) => element('div', { className: 'group' }, ...children);
  const choices = Object.entries(kTools).map(([tool, [word, key]]) => button(word, () => work.set_tool(tool), { id: `tool_${tool}`, title: `${word} (${key})` }));
  const undo = button('Undo', () => work.undo(), { id: 'undo', title: 'Undo (Ctrl Z)' }), redo = button('Redo', () => work.redo(), { id: 'redo', title: 'Redo (Ctrl Y)' });
  const close = button('Close', () => work.pen.close(), { id: 'close', title: 'Close the outline (Enter)' });
  const away = button('Delete', () => work.delete(), { id: 'delete', title: 'Take back a corner, or remove what is selected (Backspace)' });
  tools.append(group(...choices), group(close, undo, redo, away),
               group(button('\u2212', () => sheet.zoom_at(middle(), 0.8), { title: 'Smaller (-)', ariaLabel: 'smaller' }), button('Fit', () => sheet.fit(), { id: 'fit', title: 'The whole photo (f)' }),
                     button('+', () => sheet.zoom_at(middle(), 1.25), { title: 'Larger (+)', ariaLabel: 'larger' })));
  const name = element('output', { id: 'photo_name' });
  turn.append(group(button('\u2039', () => work.show(work.photo_index - 1), { title: 'Previous photo (p)', ariaLabel: 'previous photo' }), name,
                    button('\u203a', () => work.show(work.photo_index + 1), { title: 'Next photo (n)', ariaLabel: 'next photo' })));
  work.on_change(() => {
    for (const b of choices) b.setAttribute('aria-pressed', b.id === `tool_${work.tool}`);
    undo.disabled = !work.pen.drawing && !work.history.can_undo, redo.disabled = !!work.pen.drawing || !work.history.can_redo;
    close.disabled = !(work.pen.drawing?.corners.length > 2), away.disabled = !work.pen.drawing && !marks_in(work.doc, work.photo.name).length;
    const lost = work.scene.has_cameras && !work.photo.camera ? ' \u2013 no camera' : '';
    name.value = `${work.photo.name}  ${work.photo_index + 1} / ${work.scene.photos.length}${lost}`;
  });
}

function thing_row(work, thing, number) {
  const state = work.state_of(thing), { word, doc } = kClasses[thing.kind];
  const row = element('div', { className: `thing ${state.level}`, onclick: () => work.choose(thing.id) });
  row.dataset.thing = thing.id;
  row.style.setProperty('--own', color_of(work.doc, thing));
  row.classList.toggle('chosen', thing.id === work.thing);
  const name = element('input', { value: thing.name, placeholder: 'name', ariaLabel: `name of ${word}`, maxLength: 60, onchange: () => work.rename(thing.id, name.value) });
  const away = button('\u00d7', (e) => (e.stopPropagation(), work.remove(thing.id)), { title: 'Remove it and its marks', ariaLabel: `remove ${word} ${thing.name}` });
  row.append(element('div', { className: 'row' }, element('strong', { textContent: word, title: doc }), name, number < 10 ? element('kbd', { textContent: number, title: 'its key' }) : '', away));
  const text = element('p', {}, element('span', { className: 'level', textContent: { none: '', few: '\u25cb ', enough: '\u25cf ', well: '\u25cf ' }[state.level] }), state.text);
  if (state.next) text.append(' Good next: ', button(state.next, (e) => (e.stopPropagation(), work.choose(thing.id), work.show_named(state.next)), { className: 'link' }), '.');
  row.append(text);
  for (const p of state.problems) {
    const line = element('p', { className: 'wrong' });
    if (p.photo && p.here) line.append('The outline in ', button(p.photo, (e) => (e.stopPropagation(), work.choose(thing.id), work.show_named(p.photo)), { className: 'link' }), ` ${p.text}.`);
    else if (p.photo) line.append(`The outline in ${p.photo} ${p.text}. `, button('Remove it', (e) => (e.stopPropagation(), work.remove_mark(thing.id, p.photo)), { className: 'link' }));
    else line.append(`It ${p.text}.`);
    row.append(line);
  }
  return row;
}

function objects(work) {
  const list = element('div', { className: 'things', id: 'things' });
  const add = element('div', { className: 'row', id: 'add' }, ...Object.entries(kClasses).map(([kind, { word, doc }]) => button(`+ ${word}`, () => work.add(kind), { id: `add_${kind}`, title: doc })));
  work.on_change(() => list.replaceChildren(...work.doc.things.map((t, i) => thing_row(work, t, i + 1))));
  return [list, add];
}

function photos(work) {
  const list = element('div', { className: 'photos', id: 'photos' });
  work.scene.photos.forEach((p, i) => {
    const lost = work.scene.has_cameras && !p.camera;
    list.append(button('', () => work.show(i), { title: p.name + (lost ? ': the run found no camera for it' : ''), className: lost ? 'lost' : '' }));
    list.lastChild.append(element('img', { src: work.small[i], alt: p.name, loading: 'lazy' }), element('i'));
  });
  let shown = -1;
  work.on_change(() => {
    work.scene.photos.forEach((p, i) => {
      const dots = marks_in(work.doc, p.name).map((m) => {
        const dot = element('b');
        dot.style.setProperty('--own', color_of(work.doc, work.doc.things.find((t) => t.id === m.thing)));
        return dot;
      });
      list.children[i].setAttribute('aria-pressed', i === work.photo_index);
      list.children[i].querySelector('i').replaceChildren(...dots);
    });
    const at = list.children[work.photo_index];
    if (shown !== work.photo_index) list.scrollTop = Math.min(Math.max(list.scrollTop, at.offsetTop - list.offsetTop + at.offsetHeight - list.clientHeight), at.offsetTop - list.offsetTop);
    shown = work.photo_index;
  });
  return list;
}

function masks(work) {
  const shown = element('input', { type: 'checkbox', id: 'masks_shown', onchange: () => ((work.masks_shown = shown.checked), work.changed()) });
  work.on_change(() => (shown.checked = work.masks_shown));
  const kinds = Object.entries(work.scene.mask_sources).filter(([kind]) => work.scene.photos.some((p) => p.masks?.runs[kind]));
  if (!kinds.length) return element('p', { textContent: 'This run has no masks yet. After the stage \u201cmasks\u201d, vitrine mark shows here what the marks became in every photo.' });
  const words = kinds.map(([kind, source]) => `${kClasses[kind].word.toLowerCase()} ${kSources[source] ?? source}`);
  return element('div', {}, element('label', { className: 'row' }, shown, 'show them (m)'), element('p', { textContent: `What the run took in every photo: ${words.join('; ')}.` }));
}

function file(work) {
  const open = element('input', { type: 'file', id: 'open_file', accept: '.yaml,.yml', onchange: () => open.files[0] && open_file(work, open.files[0]).then(() => (open.value = '')) });
  const text = element('textarea', { id: 'yaml', readOnly: true, ariaLabel: 'the file' });
  const state = element('p', { id: 'unsaved' });
  work.on_change(() => {
    text.value = yaml_text(work);
    const refused = work.doc.marks.length ? work.refusals().length : 0;
    state.textContent = [work.dirty ? 'Not saved yet.' : work.doc.marks.length ? 'Saved.' : '', refused ? 'A run would refuse it as it is: see above.' : ''].join(' ').trim();
    state.classList.toggle('wrong', refused > 0);
  });
  const command = element('pre', { className: 'command', id: 'command', textContent: work.scene.command });
  return [
    element('div', { className: 'row' }, button('Save marks.yaml', () => save(work), { id: 'save', className: 'primary', title: 'Save (Ctrl S)' }), element('label', { className: 'file', textContent: 'Open\u2026' }, open),
            button('Copy', () => copy(yaml_text(work), () => work.tell('The text of marks.yaml is copied.')), { id: 'copy' })),
    state, element('p', { textContent: 'Then run, with the path of the saved file:' }), command,
    element('div', { className: 'row' }, button('Copy command', () => copy(work.scene.command, () => work.tell('The command is copied.')), { id: 'copy_command' })),
    element('details', {}, element('summary', { textContent: 'Text of the file' }), text),
  ];
}

export function make_panel(work) {
  const panel = document.getElementById('panel'), { scene } = work;
  const section = (title, ...children) => panel.append(element('h2', { textContent: title }), ...children);
  toolbar(work);
  panel.append(element('h1', { textContent: 'Glass, metal, mirrors' }),
               element('p', { textContent: 'Draw the whole outline of each in two or three photos from different sides, through what stands in front of it. A run carries it to all other photos.' }));
  section('Objects', ...objects(work));
  section('Photos', photos(work));
  if (scene.has_cameras) section('Masks of the run', masks(work));
  section('File', ...file(work));
  if (scene.left_out.length)
    panel.append(element('details', { id: 'left_out' }, element('summary', { textContent: `${scene.left_out.length} left out, which cannot be read` }), ...scene.left_out.map((p) => element('p', { textContent: `${p.name}: ${p.why}` }))));
  panel.append(element('details', { id: 'keys' }, element('summary', { textContent: 'Keys' }), element('table', {}, ...kKeys.map(([key, what]) => element('tr', {}, element('td', {}, element('kbd', { textContent: key })), element('td', { textContent: what }))))),
               element('p', { textContent: 'Mouse wheel or two fingers zoom; dragging moves the photo. This browser keeps what you draw until you save.' }));
  const licences = document.getElementById('licences').content.textContent;
  panel.append(element('details', {}, element('summary', { textContent: 'Licences' }), element('pre', { textContent: `Made by vitrine, Apache-2.0.\n\n${licences}`.trim() })));
  work.changed();
}
