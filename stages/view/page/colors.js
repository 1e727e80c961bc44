// Colours: #rrggbb in sRGB, and linear ones.
const decoded = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
const encoded = (v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);

export const linear_of = (hex) => [1, 3, 5].map((at) => decoded(parseInt(hex.slice(at, at + 2), 16) / 255));
export const hex_of = (linear) => `#${linear.map((v) => Math.round(255 * encoded(Math.min(1, Math.max(0, v)))).toString(16).padStart(2, '0')).join('')}`;
export const is_hex = (text) => /^#[0-9a-f]{6}$/.test(text);
