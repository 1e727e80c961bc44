// Alignment of two runs: the similarity transform between the cameras of the same photos (Horn 1987; Umeyama 1991). Result:
// {rotation: nine numbers, rows first; scale; translation; cameras; by: centres, rotations or nothing; error}
import { centre_of } from './cameras.js';

const kThin = 0.01;  // relative to their extent: centres closer to a line determine no rotation
const kIdentity = 1e-9;
const kSweeps = 30;

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const less = (a, b) => a.map((v, i) => v - b[i]);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const mean = (points) => [0, 1, 2].map((c) => points.reduce((sum, p) => sum + p[c], 0) / points.length);
const turned = (r, p) => [0, 3, 6].map((k) => dot(r.slice(k, k + 3), p));

// Eigenvector of the largest eigenvalue of a symmetric matrix (rows), by Jacobi rotations.
function greatest_eigenvector(m) {
  const n = m.length, a = m.map((row) => [...row]), v = m.map((_, i) => m.map((_, k) => (i === k ? 1 : 0)));
  for (let sweep = 0; sweep < kSweeps; ++sweep)
    for (let p = 0; p < n; ++p)
      for (let q = p + 1; q < n; ++q) {
        if (a[p][q] === 0) continue;
        const angle = 0.5 * Math.atan2(2 * a[p][q], a[q][q] - a[p][p]), c = Math.cos(angle), s = Math.sin(angle);
        for (let k = 0; k < n; ++k) [a[k][p], a[k][q]] = [c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]];
        for (let k = 0; k < n; ++k) [a[p][k], a[q][k]] = [c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]];
        for (let k = 0; k < n; ++k) [v[k][p], v[k][q]] = [c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]];
      }
  const best = a.reduce((k, row, i) => (row[i] > a[k][k] ? i : k), 0);
  return v.map((row) => row[best]);
}

// Least-squares rotation of each a onto its b: pairs [[a, b] ...].
export function best_rotation(pairs) {
  const s = (i, k) => pairs.reduce((sum, [a, b]) => sum + a[i] * b[k], 0);
  const [xx, xy, xz, yx, yy, yz, zx, zy, zz] = [0, 1, 2].flatMap((i) => [0, 1, 2].map((k) => s(i, k)));
  const [w, x, y, z] = greatest_eigenvector([
    [xx + yy + zz, yz - zy, zx - xz, xy - yx], [yz - zy, xx - yy - zz, xy + yx, zx + xz],
    [zx - xz, xy + yx, yy - xx - zz, yz + zy], [xy - yx, zx + xz, yz + zy, zz - xx - yy],
  ]);
  return [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
          2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)];
}

// True if they are nearly collinear, or too few.
function on_a_line(offsets) {
  const far = offsets.reduce((a, b) => (dot(a, a) > dot(b, b) ? a : b)), size = Math.hypot(...far);
  return offsets.length < 3 || offsets.every((p) => Math.hypot(...cross(p, far)) <= kThin * size * size);
}

const identity = { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], scale: 1, translation: [0, 0, 0], cameras: 0, by: 'nothing', error: 0 };

// A point p of `from` is at scale * rotation * p + translation in `to`. error: of the centres, relative to the radius of the
// camera ring.
export function alignment(from, to) {
  const there = new Map(to.cameras.map((c) => [c.name, c])), both = from.cameras.filter((c) => there.has(c.name)).map((c) => [c, there.get(c.name)]);
  if (both.length === 0) return identity;
  const a = both.map(([c]) => centre_of(c)), b = both.map(([, c]) => centre_of(c)), a0 = mean(a), b0 = mean(b);
  const pairs = a.map((p, i) => [less(p, a0), less(b[i], b0)]), by = on_a_line(pairs.map(([p]) => p)) ? 'rotations' : 'centres';
  const axes = () => both.flatMap(([p, q]) => [0, 3, 6].map((k) => [p.rotation.slice(k, k + 3), q.rotation.slice(k, k + 3)]));
  const rotation = best_rotation(by === 'centres' ? pairs : axes());
  const spread = pairs.reduce((sum, [p]) => sum + dot(p, p), 0), fits = pairs.reduce((sum, [p, q]) => sum + dot(q, turned(rotation, p)), 0);
  const scale = spread > 0 && fits > 0 ? fits / spread : to.radius / from.radius;
  const translation = less(b0, turned(rotation, a0).map((v) => scale * v));
  const found = { rotation, scale, translation, cameras: both.length, by };
  const off = a.reduce((sum, p, i) => sum + less(carried(found, p), b[i]).reduce((s, v) => s + v * v, 0), 0);
  const same = [...rotation.map((v, i) => v - identity.rotation[i]), scale - 1, ...translation].every((v) => Math.abs(v) < kIdentity);
  return { ...found, ...(same ? { rotation: identity.rotation, scale: 1, translation: [0, 0, 0] } : {}), error: Math.sqrt(off / both.length) / to.radius };
}

export const carried = ({ rotation, scale, translation }, p) => turned(rotation, p).map((v, i) => scale * v + translation[i]);

// Transforms a camera into the other scene.
export function carried_camera(frame, camera) {
  const centre = carried(frame, centre_of(camera)), r = camera.rotation, rows = [0, 3, 6].map((k) => turned(frame.rotation, r.slice(k, k + 3)));
  return { ...camera, rotation: rows.flat(), translation: rows.map((row) => 0 - dot(row, centre)) };
}
// Transforms a plane [normal, offset].
export function carried_plane(frame, [x, y, z, offset]) {
  const n = turned(frame.rotation, [x, y, z]);
  return [...n, frame.scale * offset + dot(n, frame.translation)];
}
// Rotation about the z axis, degrees, counter-clockwise seen from above.
export const yaw = ({ rotation: r }) => (Math.atan2(r[3] - r[1], r[0] + r[4]) * 180) / Math.PI;
