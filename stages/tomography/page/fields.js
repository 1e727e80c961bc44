// Sliders whose value is shown as a text.
import { slider } from '../../page/controls.js';
import { short } from './numbers.js';

export function field(name, id, least, most, set, text) {
  const { row, input } = slider(name, id, least, most, 'any', '', (v) => (set(v), show(v)));
  const show = (value) => {
    input.value = value, row.lastChild.value = text(value);
    input.setAttribute('aria-valuetext', row.lastChild.value);
  };
  return { row, input, show };
}

// Share of the axis of densities, 0 to 1, and back: the square root, since metal is far denser than most of what lies around it.
export const axis_of = ({ low, high }, density) => Math.sqrt(Math.max(0, density - low) / (high - low || 1));
export const density_at = ({ low, high }, share) => low + share * share * (high - low);

// A slider for a density.
export function root_field(name, id, volume, set) {
  const { row, input, show } = field(name, id, 0, 1, (share) => set(density_at(volume, share)), (share) => short(density_at(volume, share)));
  return { row, input, show: (density) => show(axis_of(volume, density)) };
}
