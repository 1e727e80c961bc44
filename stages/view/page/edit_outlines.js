// SVG outlines over the picture: the box of the selected edit, and its marks in the photo of the current camera.
import { projected } from './cameras.js';
import { svg } from './marks.js';

const kEdges = [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];
const kNear = 1e-3;

// Part of a line segment in front of the camera, in pixels; null if none.
function line_before(camera, a, b) {
  const depth = (p) => projected(camera, p)[2], za = depth(a), zb = depth(b);
  if (za <= kNear && zb <= kNear) return null;
  const at = (t) => a.map((v, c) => v + t * (b[c] - v)), cut = (kNear - za) / (zb - za);
  return [za > kNear ? a : at(cut), zb > kNear ? b : at(cut)].map((p) => projected(camera, p));
}

// sx, sy: screen pixels per camera pixel.
export function edit_outlines(edits, camera, sx, sy) {
  const { one, view, drawn_corners = [] } = edits, photo = edits.photos[view.photo], box = one?.select.box;
  const out = [];
  if (box) {
    const corners = Array.from({ length: 8 }, (_, k) => [0, 1, 2].map((c) => box[c + ((k >> c) & 1 ? 3 : 0)]));
    for (const [a, b] of kEdges) {
      const line = line_before(camera, corners[a], corners[b]);
      if (line) out.push(svg('line', { x1: line[0][0] * sx, y1: line[0][1] * sy, x2: line[1][0] * sx, y2: line[1][1] * sy }));
    }
  }
  if (photo === undefined) return out;
  const [width, height] = edits.page.scene.cameras[view.photo].photo;
  const polygon = (corners, size) => svg('polygon', { points: corners.map(([x, y]) => `${(x / size[0]) * camera.width * sx},${(y / size[1]) * camera.height * sy}`).join(' ') });
  for (const { photo: name, box: b, polygon: p, size } of one?.select.marks ?? [])
    if (name === photo) out.push(polygon(p ?? [[b[0], b[1]], [b[2], b[1]], [b[2], b[3]], [b[0], b[3]]], size ?? [width, height]));
  if (drawn_corners.length) out.push(polygon(drawn_corners, [width, height]));
  return out;
}
