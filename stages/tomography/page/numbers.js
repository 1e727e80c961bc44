// Numbers as text.

// Three significant digits, without an exponent for usual sizes.
export function short(value, digits = 3) {
  if (!Number.isFinite(value)) return '';
  const size = Math.abs(value);
  if (size > 0 && (size < 1e-4 || size >= 1e6)) return value.toExponential(digits - 1).replace('-', '\u2212');
  const places = size > 0 ? Math.max(0, digits - 1 - Math.floor(Math.log10(size))) : 0;
  return value.toFixed(Math.min(8, places)).replace('-', '\u2212');
}

// A length with the decimals that a cell of the volume needs.
export function place_text(value, cell) {
  return value.toFixed(Math.max(0, Math.min(6, 1 - Math.floor(Math.log10(cell))))).replace('-', '\u2212');
}

// The largest of 1, 2, 5, 10, 20 ... that is at most `value`.
export function round_length(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [5, 2, 1].find((d) => d * power <= value * 1.0001) * power;
}

export const clamped = (value, least, most) => Math.max(least, Math.min(most, value));
