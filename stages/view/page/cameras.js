// Cameras in vitrine's convention: rotation (camera from world, nine numbers, rows first) and translation; x right, y down, z
// forward; fx, fy, cx, cy in pixels of a picture of width x height, pixel centres at .5.
import { Matrix3, Vector3 } from 'three';

export const centre_of = (camera) => {
  const r = camera.rotation, t = camera.translation;
  return [0, 1, 2].map((i) => -(r[i] * t[0] + r[3 + i] * t[1] + r[6 + i] * t[2]));
};

// The same camera for another picture size, with the same angle of view along the longer side.
export function resized(camera, width, height) {
  const sx = width / camera.width, sy = height / camera.height;
  return { ...camera, width, height, fx: camera.fx * sx, cx: camera.cx * sx, fy: camera.fy * sy, cy: camera.cy * sy };
}

// From a three.js camera with this picture size.
export function from_three(eye, width, height) {
  eye.updateMatrixWorld();
  const e = eye.matrixWorld.elements, axis = (k, sign) => [0, 1, 2].map((i) => sign * e[4 * k + i]);
  const rotation = [...axis(0, 1), ...axis(1, -1), ...axis(2, -1)], c = [e[12], e[13], e[14]];
  const translation = [0, 1, 2].map((k) => -(rotation[3 * k] * c[0] + rotation[3 * k + 1] * c[1] + rotation[3 * k + 2] * c[2]));
  const f = (0.5 * height) / Math.tan((eye.fov * Math.PI) / 360);
  return { rotation, translation, width, height, fx: f, fy: f, cx: width / 2, cy: height / 2 };
}

// Moves a three.js camera to a photo's camera; its target lies on the optical axis at the distance of `middle`. In a window with
// this aspect (width over height) it covers the photo, and more above and below if the window is narrower.
export function stand_at(eye, target, camera, middle, aspect = Infinity) {
  const c = new Vector3(...centre_of(camera)), r = camera.rotation, forward = new Vector3(r[6], r[7], r[8]);
  eye.position.copy(c);
  target.copy(c).addScaledVector(forward, Math.max(0.1, forward.dot(new Vector3(...middle).sub(c))));
  const half = Math.max(camera.height / 2 / camera.fy, camera.width / 2 / camera.fx / aspect);
  eye.fov = (2 * Math.atan(half) * 180) / Math.PI;
  eye.lookAt(target);
}

// Camera of the reflection in the plane dot(n, p) = offset, flipped left to right (core/render/model/pane_pass.h).
export function mirrored(camera, n, offset) {
  const r = camera.rotation, row = (k) => r.slice(3 * k, 3 * k + 3), dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const rotation = [0, 1, 2].flatMap((k) => row(k).map((v, i) => (k === 0 ? -1 : 1) * (v - 2 * dot(row(k), n) * n[i])));
  const c = centre_of(camera), eye = c.map((v, i) => v - 2 * (dot(c, n) - offset) * n[i]);
  const translation = [0, 1, 2].map((k) => -dot(rotation.slice(3 * k, 3 * k + 3), eye));
  return { ...camera, rotation, translation, cx: camera.width - camera.cx };
}

// Uniforms of camera.glsl.
export const camera_uniforms = () =>
  Object.fromEntries(['rotation', 'translation', 'eye', 'pinhole', 'size'].map((name) => [name, { value: null }]));
export function set_camera(uniforms, camera) {
  uniforms.rotation.value = new Matrix3().set(...camera.rotation);
  uniforms.translation.value = camera.translation;
  uniforms.eye.value = centre_of(camera);
  uniforms.pinhole.value = [camera.fx, camera.fy, camera.cx, camera.cy];
  uniforms.size.value = [camera.width, camera.height];
}

// Projects to a pixel: [x, y, z]; z <= 0: behind the camera.
export function projected(camera, p) {
  const r = camera.rotation, t = camera.translation;
  const q = [0, 1, 2].map((k) => r[3 * k] * p[0] + r[3 * k + 1] * p[1] + r[3 * k + 2] * p[2] + t[k]);
  return [(camera.fx * q[0]) / q[2] + camera.cx, (camera.fy * q[1]) / q[2] + camera.cy, q[2]];
}
// Inverse projection at depth z.
export function unprojected(camera, x, y, z) {
  const p = [((x - camera.cx) / camera.fx) * z, ((y - camera.cy) / camera.fy) * z, z].map((v, i) => v - camera.translation[i]);
  return [0, 1, 2].map((i) => camera.rotation[i] * p[0] + camera.rotation[3 + i] * p[1] + camera.rotation[6 + i] * p[2]);
}

// Cameras to world, OpenGL axes: the format of `vitrine render --views` and `vitrine relight --views`.
export function transforms_json(cameras) {
  const frames = cameras.map((camera, i) => {
    const r = camera.rotation, c = centre_of(camera);
    const rows = [0, 1, 2].map((k) => [r[k], -r[3 + k], -r[6 + k], c[k]]);
    return {
      file_path: `view_${String(i).padStart(4, '0')}.png`,
      w: camera.width, h: camera.height, fl_x: camera.fx, fl_y: camera.fy, cx: camera.cx, cy: camera.cy,
      transform_matrix: [...rows, [0, 0, 0, 1]],
    };
  });
  return JSON.stringify({ camera_model: 'PINHOLE', frames }, null, 1) + '\n';
}
