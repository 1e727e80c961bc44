// Overlays of the masks of a run: a tint with an edge per class. Glass also counts as metal and is shown as glass only.
import { kClasses } from './marks.js';

const kTint = 80, kEdge = 255;  // alpha of interior and edge, of 255

const rgb = (color) => [1, 3, 5].map((i) => parseInt(color.slice(i, i + 2), 16));

function filled(lengths, size) {
  const inside = new Uint8Array(size);
  lengths.reduce((at, length, i) => (i % 2 && inside.fill(1, at, at + length), at + length), 0);
  return inside;
}

// Canvases of one photo by class.
export function mask_pictures({ width, height, runs }) {
  const pictures = {}, glass = runs.transparent && filled(runs.transparent, width * height);
  for (const [kind, lengths] of Object.entries(runs)) {
    const inside = filled(lengths, width * height);
    if (kind === 'specular' && glass) glass.forEach((v, i) => v && (inside[i] = 0));
    const canvas = Object.assign(document.createElement('canvas'), { width, height }), context = canvas.getContext('2d');
    const image = context.createImageData(width, height), [r, g, b] = rgb(kClasses[kind].colors[0]);
    for (let i = 0; i < inside.length; ++i) {
      if (!inside[i]) continue;
      const x = i % width, edge = x === 0 || x === width - 1 || !inside[i - 1] || !inside[i + 1] || !inside[i - width] || !inside[i + width];
      image.data.set([r, g, b, edge ? kEdge : kTint], 4 * i);
    }
    context.putImageData(image, 0, 0);
    pictures[kind] = canvas;
  }
  return pictures;
}
