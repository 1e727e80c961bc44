// Lines over the picture of the volume: the cylinder that the scan shows, or its box; the three slices; the crosshair.
import { projected } from './orbit.js';
import { kAxisColors } from './slice.js';

const kParts = 72;  // of a circle

function rings({ radius, origin, end }) {
  const circle = (z) => Array.from({ length: kParts + 1 }, (_, i) => [radius * Math.cos((2 * Math.PI * i) / kParts), radius * Math.sin((2 * Math.PI * i) / kParts), z]);
  return [circle(origin[2]), circle(end[2])];
}
function edges({ origin, end }) {
  const corner = (k) => [0, 1, 2].map((c) => ((k >> c) & 1 ? end[c] : origin[c])), out = [];
  for (let k = 0; k < 8; ++k)
    for (let c = 0; c < 3; ++c) if (!((k >> c) & 1)) out.push([corner(k), corner(k | (1 << c))]);
  return out;
}
// The border of the slice across an axis.
function border({ origin, end }, axis, place) {
  const [a, b] = [0, 1, 2].filter((c) => c !== axis);
  return [[origin, origin], [end, origin], [end, end], [origin, end], [origin, origin]].map(([p, q]) => {
    const at = [0, 0, 0];
    at[axis] = place, at[a] = p[a], at[b] = q[b];
    return at;
  });
}

export function outlines(volume, place, camera) {
  const path = (points) => {
    const on_screen = points.map((p) => projected(camera, p));
    return on_screen.some((p) => !p) ? '' : `M${on_screen.map((p) => p.map((v) => v.toFixed(1)).join(' ')).join('L')}`;
  };
  const frame = (volume.radius === null ? edges(volume) : rings(volume)).map(path).join('');
  const slices = [0, 1, 2].map((axis) => `<path d="${path(border(volume, axis, place[axis]))}" stroke="${kAxisColors[axis]}"/>`).join('');
  const at = projected(camera, place);
  return `<path d="${frame}" stroke="#8b8f98"/>${slices}${at ? `<circle cx="${at[0].toFixed(1)}" cy="${at[1].toFixed(1)}" r="4"/>` : ''}`;
}
