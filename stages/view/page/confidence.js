// Confidence: coverage of the surfels by photos (core/render/picture/confidence.h) as a number: 0 for one photo or a single
// direction, 1 for at least twelve photos with at least 60 degrees between two of them; the minimum of both criteria. Displayed
// with a colour map.
import { element } from '../../page/elements.js';

const kMostPhotos = 12, kMostAngleSteps = 6;
// Colour map from 0 to 1, piecewise linear, in display values (viridis: perceptually uniform); and the grey of unseen surfels.
export const kScale = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
const kUnseen = 128;

// Byte of the block `seen` -> [confidence, 1 if no photo saw the surfel].
export function confidence(byte) {
  const photos = byte >> 3;
  return photos === 0 ? [0, 1] : [Math.min((photos - 1) / (kMostPhotos - 1), (byte & 7) / kMostAngleSteps), 0];
}

// Uniforms of composite.glsl.
export const scale_uniforms = () => ({ scale: { value: kScale.flat().map((v) => v / 255) }, unseen: { value: kUnseen / 255 } });

// Returns {nodes, show(state)} for the panel.
export function confidence_legend() {
  const rgb = (c) => `rgb(${c})`, row = (...children) => element('div', { className: 'row' }, ...children);
  const bar = element('div', { className: 'scale' }), none = element('span', { className: 'swatch' });
  bar.style.background = `linear-gradient(to right, ${kScale.map(rgb)})`;
  none.style.background = rgb([kUnseen, kUnseen, kUnseen]);
  const legend = element('div', { id: 'legend' }, bar,
    element('div', { className: 'ends' }, element('span', { textContent: 'seen by 1 photo, or from one side' }),
            element('span', { textContent: 'by 12 and more, from 60\u00b0 apart and more' })),
    row(none, 'seen by no photo'));
  return { nodes: [legend], show: (state) => (legend.hidden = state.mode !== 'confidence') };
}
