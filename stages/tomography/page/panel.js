// The control panel.
import { button, download, element } from '../../page/elements.js';
import { file_button, section } from '../../page/controls.js';
import { cut_section } from './cut.js';
import { root_field } from './fields.js';
import { place_text, short } from './numbers.js';
import { measure_section } from './measure.js';
import { kStarts } from './transfer.js';
import { TransferEditor } from './transfer_editor.js';

const kHelp = [
  ['Slices', 'Drag moves the crosshair, the wheel goes to the next slice, shift and drag (or the right button) changes the grey values, control and wheel (or two fingers) zooms, the middle button moves.'],
  ['Volume', 'Drag turns, shift and drag (or two fingers) moves, the wheel zooms; a click puts the crosshair on what it hits.'],
  ['Keys', 'On a slice: arrows, page up and page down, + and \u2212, 0 for the whole. On the volume: arrows, shift and arrows, + and \u2212, r for the start. On a point of the curve: arrows, Delete. A double click, or m, shows one picture alone.'],
];

function of_volume({ size, cell, scan_size, scan_cell, unit, radius }) {
  const times = (v) => v.join('\u2009\u00d7\u2009'), nodes = [element('p', { textContent: `${times(scan_size)} voxels of ${short(scan_cell)} ${unit}` })];
  if (cell !== scan_cell)
    nodes.push(element('p', { id: 'averaged', textContent: `This page has means of them: ${times(size)} voxels of ${short(cell)} ${unit}. All of them are in volume.nrrd.` }));
  if (radius !== null) nodes.push(element('p', { textContent: `Hatched: outside of the cylinder, ${short(2 * radius)} ${unit} wide, that all projections show.` }));
  return nodes;
}

function grey_values(state) {
  const { volume } = state, { low, high, per_length } = volume;
  const black = root_field('Black', 'black', volume, (v) => state.set_window(v, Math.max(state.white, v)));
  const white = root_field('White', 'white', volume, (v) => state.set_window(Math.min(state.black, v), v));
  const show = () => (black.show(state.black), white.show(state.white));
  state.on_change((what) => what === 'window' && show());
  show();
  return section(`Slices: grey values, ${per_length}`, black.row, white.row, element('div', { className: 'row' },
    button('Reset', () => state.reset_window(), { id: 'reset_window' }), button('All densities', () => state.set_window(low, high), { id: 'all_densities' }),
    button('Whole slice', () => state.show_whole(), { id: 'show_whole', title: 'without zoom' })));
}

function transfer_section(transfer, open) {
  const editor = new TransferEditor(transfer), { volume } = transfer;
  const starts = Object.keys(kStarts).map((name) => button(name, () => transfer.start(name), { id: `start_${name}` }));
  const surface = root_field('Surface at', 'surface_at', volume, (v) => transfer.surface(v));
  const show = () => {
    starts.forEach((b) => b.setAttribute('aria-pressed', b.id === `start_${transfer.name}`));
    if (transfer.name === 'surface') surface.show((transfer.points[1].density + transfer.points[2].density) / 2);
  };
  surface.show(volume.iso);
  transfer.on_change(show);
  show();
  const save = button('Save', () => download('transfer_function.json', new Blob([transfer.json()], { type: 'application/json' })), { id: 'save_transfer' });
  const nodes = section('Volume: colour and opacity', element('div', { className: 'row', id: 'starts' }, ...starts), ...editor.nodes, surface.row,
    element('div', { className: 'row' }, save, file_button('Open\u2026', 'open_transfer', '.json', open)),
    element('p', { className: 'hint', textContent: 'Double click adds a point, right click removes it. A saved function can also be dropped on the page.' }));
  return { nodes, editor };
}

export function make_panel({ state, transfer, cut, view, slices, open }) {
  const panel = document.getElementById('panel'), { volume } = state;
  const { nodes, editor } = transfer_section(transfer, open);
  panel.append(element('h1', { textContent: 'The volume' }), ...of_volume(volume), ...grey_values(state), ...measure_section(state));
  if (view.casting) {
    const cutting = cut_section(cut, state, () => view.camera());
    cut.on_change = () => (cutting.show(), view.moved());
    const framed = element('input', { type: 'checkbox', id: 'framed', checked: view.framed, onchange: () => ((view.framed = framed.checked), view.draw_lines()) });
    const start = button('Start', () => (view.orbit.reset(), view.moved()), { id: 'reset_camera' });
    panel.append(...nodes, ...cutting.nodes, ...section('Camera', element('div', { className: 'row' }, start, element('label', { className: 'row' }, framed, 'outlines'))));
  }
  const keep = (name, canvas) => button(name, () => canvas.toBlob((blob) => download(`${canvas.id}.png`, blob)), { id: `keep_${canvas.id}` });
  const pictures = [...slices.map((s) => keep('xyz'[s.axis], s.canvas)), ...(view.casting ? [keep('Volume', view.canvas)] : [])];
  panel.append(...section('Keep as PNG', element('div', { className: 'row' }, ...pictures)),
    element('details', {}, element('summary', { textContent: 'Mouse, fingers and keys' }), ...kHelp.map(([name, text]) => element('p', {}, element('b', { textContent: `${name}. ` }), text))),
    element('details', {}, element('summary', { textContent: 'Licences' }),
            element('pre', { textContent: `Made by vitrine, Apache-2.0.\n\n${document.getElementById('licences').content.textContent}`.trim() })));

  // Place and density below the pointer, or at the crosshair.
  const readout = document.getElementById('readout');
  const show = () => {
    const place = state.hovered && volume.contains(state.hovered) ? state.hovered : state.place, density = volume.density(place);
    const at = place.map((p, c) => `${'xyz'[c]}\u2009${place_text(p, volume.cell)}`).join('  ');
    readout.value = `${state.hovered === place ? 'pointer' : 'crosshair'}: ${at} ${volume.unit}   ${density === null ? 'not shown by the scan' : `density ${short(density)} ${volume.per_length}`}`;
    editor.show_density(density);
  };
  state.on_change(show);
  show();
}
