// Panel section of the lamps: list, properties of the selected lamp, files of the light.
import { button, download, element } from '../../page/elements.js';
import { kLampRanges, lamps_yaml, new_lamp, saved_map, towards_lamp, wrapped } from './lamps.js';
import { radiance_hdr } from './radiance_hdr.js';
import { keep_rows, slider } from '../../page/controls.js';

const kTool = 'lamp', kDegreesPerPixel = 0.4;
const rounded = (v) => Math.round(10 * v) / 10;

// Returns { parts: elements, show(state) }
export function lamps_section(view) {
  let chosen = -1;
  const lamps = () => view.state.lamps;
  const relit = () => (view.state.mode === 'relit' ? {} : { mode: 'relit' });
  const change = (some) => view.adjust({ lamps: lamps().map((l, i) => (i === chosen ? { ...l, ...some } : l)), ...relit() });

  // A drag moves the lamp with the mouse, on the visible side of the scene.
  function dragged({ dx, dy }) {
    const lamp = lamps()[chosen], d = towards_lamp(lamp), eye = view.eye.position.clone().sub(view.controls.target);
    const side = d[0] * eye.x + d[1] * eye.y >= 0 ? 1 : -1;
    change({ azimuth: rounded(wrapped(lamp.azimuth + side * kDegreesPerPixel * dx)), elevation: rounded(Math.min(90, Math.max(-90, lamp.elevation - kDegreesPerPixel * dy))) });
  }
  function choose(index) {
    if (view.hand.has(kTool)) view.hand.drop();
    chosen = index;
    if (index >= 0) view.hand.take({ name: kTool, drags: true, moved: dragged, dropped: () => (chosen = -1) });
    else view.changed();
  }
  const add = () => {
    view.set({ lamps: [...lamps(), new_lamp(view.eye.position.toArray(), view.controls.target.toArray())], ...relit() });
    choose(lamps().length - 1);
  };
  const remove = () => {
    const kept = lamps().filter((_, i) => i !== chosen);
    choose(-1);
    view.set({ lamps: kept });
  };

  const range = (text, key, step, unit) => slider(text, `lamp_${key}`, ...kLampRanges[key], step, unit, (v) => change({ [key]: v }));
  const sliders = { azimuth: range('Azimuth', 'azimuth', 1, '\u00b0'), elevation: range('Elevation', 'elevation', 1, '\u00b0'), size: range('Size', 'size', 0.5, '\u00b0'), power: range('Brightness', 'power', 0.1, '') };
  const color = element('input', { type: 'color', id: 'lamp_color', oninput: () => change({ color: color.value }) });
  const on = element('input', { type: 'checkbox', id: 'lamp_on', onchange: () => change({ on: on.checked }) });
  const one = element('div', { id: 'lamp', hidden: true }, ...Object.values(sliders).map((s) => s.row),
    element('div', { className: 'row' }, element('label', { htmlFor: 'lamp_color', textContent: 'Colour' }), color, element('label', { className: 'row' }, on, 'on'), button('Remove', remove, { id: 'remove_lamp' })),
    element('p', { textContent: 'A drag over the picture moves the chosen lamp; choose it again to turn the scene.' }));
  const list = element('div', { className: 'row', id: 'lamps' });
  const dimmed = slider('Sky', 'sky', 0, 1, 0.01, '', (v) => view.adjust({ sky: v, ...relit() }));
  const map = () => view.skies[view.state.light];
  const parts = [dimmed.row, element('div', { className: 'row' }, button('Add a lamp', add, { id: 'add_lamp' }), list), one,
    element('div', { className: 'row' },
      button('Save light.hdr', () => download('light.hdr', radiance_hdr(saved_map(map(), view.state))), { id: 'save_light' }),
      button('lamps.yaml', () => download('lamps.yaml', new Blob([lamps_yaml(map(), lamps())], { type: 'text/yaml' })), { id: 'save_lamps' })),
    element('p', { textContent: 'light.hdr has sky and lamps, for vitrine relight --env; lamps.yaml the lamps alone, for --lights.' })];

  function show(state) {
    if (chosen >= state.lamps.length) chosen = -1;
    keep_rows(list, state.lamps.length, (i) => button('', () => choose(i === chosen ? -1 : i), { title: `lamp ${i + 1}` }), (b, i) => {
      b.textContent = `${i + 1}${state.lamps[i].on ? '' : ' (off)'}`;
      b.setAttribute('aria-pressed', i === chosen);
    });
    dimmed.show(state.sky);
    const lamp = state.lamps[chosen];
    one.hidden = !lamp;
    if (!lamp) return;
    for (const [key, s] of Object.entries(sliders)) s.show(lamp[key]);
    color.value = lamp.color, on.checked = lamp.on;
  }
  return { parts, show };
}
