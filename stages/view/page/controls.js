// Controls of the panel that several sections use.
import { element } from '../../page/elements.js';

export function slider(text, id, least, most, step, unit, set) {
  const shown = element('output', { htmlFor: id });
  const input = element('input', { type: 'range', id, min: least, max: most, step, oninput: () => set(Number(input.value)) });
  const show = (value) => ((input.value = value), (shown.value = `${Math.round(value * 100) / 100}${unit}`));
  return { row: element('div', { className: 'row' }, element('label', { htmlFor: id, textContent: text }), input, shown), input, show };
}

// The heading of a section and what stands below it.
export const section = (title, ...children) => [element('h2', { textContent: title }), ...children];
