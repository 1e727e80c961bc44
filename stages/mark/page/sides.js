// Checks whether the marked photos look from different sides; needs the cameras of a run.
import { outline_of } from './marks.js';

const add = (a, b, s = 1) => a.map((v, i) => v + s * b[i]);
const dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0);
const unit = (a) => a.map((v) => v / Math.hypot(...a));

// Ray through a pixel of the photo; lens distortion is ignored.
function ray(photo, [x, y]) {
  const { right, down, ahead, across, along } = photo.camera;
  return unit(add(add(ahead, right, (x / photo.width - 0.5) * across), down, (y / photo.height - 0.5) * along));
}

const middle_of = (mark) => {
  const corners = outline_of(mark);
  return [0, 1].map((k) => (Math.min(...corners.map((c) => c[k])) + Math.max(...corners.map((c) => c[k]))) / 2);
};

// Point closest to all rays: sum (I - d d^T) p = sum (I - d d^T) eye.
function meeting(rays) {
  const a = [[0, 0, 0], [0, 0, 0], [0, 0, 0]], b = [0, 0, 0];
  for (const { eye, d } of rays)
    for (let i = 0; i < 3; ++i)
      for (let j = 0; j < 3; ++j) {
        const m = (i === j ? 1 : 0) - d[i] * d[j];
        a[i][j] += m, b[i] += m * eye[j];
      }
  const det = (m) => m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  const whole = det(a);
  if (Math.abs(whole) < 1e-9) return null;
  return [0, 1, 2].map((k) => det(a.map((row, i) => row.map((v, j) => (j === k ? b[i] : v)))) / whole);
}

// For a single ray: its point closest to the common centre of all cameras.
function before_the_middle({ eye, d }, photos) {
  const middle = meeting(photos.filter((p) => p.camera).map((p) => ({ eye: p.camera.eye, d: p.camera.ahead })));
  return middle && add(eye, d, dot(add(middle, eye, -1), d));
}

// `marks`: of one object, in photos with a camera. one_sided: all photos look from one side, i.e. the mean direction towards the
// cameras is longer than the scene's `most_one_sided`; next: the photo that adds most.
export function sides(marks, { photos, most_one_sided }) {
  const of = (mark) => photos.find((p) => p.name === mark.photo);
  const rays = marks.map((m) => ({ eye: of(m).camera.eye, d: ray(of(m), middle_of(m)) }));
  const place = rays.length > 1 ? meeting(rays) : before_the_middle(rays[0], photos);
  if (!place) return { one_sided: marks.length > 1, next: null };
  const towards = (eye) => unit(add(eye, place, -1));
  const known = rays.map(({ eye }) => towards(eye));
  const mean = known.reduce((sum, d) => add(sum, d, 1 / known.length), [0, 0, 0]);
  let next = null, least = Infinity;
  for (const p of photos) {
    if (!p.camera || marks.some((m) => m.photo === p.name)) continue;
    const from = add(place, p.camera.eye, -1), z = dot(from, p.camera.ahead);
    const seen = z > 0 && Math.abs(dot(from, p.camera.right) / z) < p.camera.across / 2 && Math.abs(dot(from, p.camera.down) / z) < p.camera.along / 2;
    const nearest = Math.max(...known.map((d) => dot(d, towards(p.camera.eye))));
    if (seen && nearest < least) least = nearest, next = p.name;
  }
  return { one_sided: Math.hypot(...mean) > most_one_sided, next };
}
