// Panel controls that several sections share.
import { element } from './elements.js';

export function slider(text, id, least, most, step, unit, set) {
  const shown = element('output', { htmlFor: id });
  const input = element('input', { type: 'range', id, min: least, max: most, step, oninput: () => set(Number(input.value)) });
  const show = (value) => ((input.value = value), (shown.value = `${Math.round(value * 100) / 100}${unit}`));
  return { row: element('div', { className: 'row' }, element('label', { htmlFor: id, textContent: text }), input, shown), input, show };
}

// Heading and content of a section.
export const section = (title, ...children) => [element('h2', { textContent: title }), ...children];

// File chooser button; the same file can be opened twice.
export function file_button(text, id, accept, open) {
  const input = element('input', { type: 'file', id, accept, onchange: () => {
    if (input.files[0]) open(input.files[0]);
    input.value = '';
  } });
  return element('label', { className: 'file', textContent: text }, input);
}

// Keeps `count` rows in `list`; recreates them only if their number changes, so that a click is not interrupted; show(row, i)
// updates a row.
export function keep_rows(list, count, make, show) {
  if (list.children.length !== count) list.replaceChildren(...Array.from({ length: count }, (_, i) => make(i)));
  [...list.children].forEach(show);
}
