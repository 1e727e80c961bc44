// Mesh without WebGL: triangles painted from far to near. Dragging rotates, the wheel zooms.
import { PerspectiveCamera, Vector3 } from 'three';
import { clipped } from './clip_plane.js';
import { from_three, projected, stand_at } from './cameras.js';

// Draws the part visible under `clip` from the first photo's camera, without faces whose majority of corners belongs to hidden
// `objects`. Returns the camera; null if the page has no mesh.
export function show_mesh(canvas, { scene, blocks }, clip, objects) {
  const { mesh_position: places, mesh_color: colors, mesh_face: faces, mesh_object: ids = [] } = blocks;
  if (!faces?.length) return null;
  const eye = new PerspectiveCamera(), target = new Vector3(), up = new Vector3(0, 0, 1);
  eye.up.copy(up);
  stand_at(eye, target, scene.cameras[0], scene.middle);

  const draw = () => {
    const width = (canvas.width = canvas.clientWidth), height = (canvas.height = canvas.clientHeight), context = canvas.getContext('2d');
    const camera = from_three(eye, width, height), on_screen = [];
    for (let v = 0; v < places.length; v += 3) on_screen.push(projected(camera, places.subarray(v, v + 3)));
    const order = [], plane = clip.plane(camera), outlines = new Map();  // of faces cut by the plane
    const hidden = on_screen.map((_, v) => places[3 * v] * plane[0] + places[3 * v + 1] * plane[1] + places[3 * v + 2] * plane[2] < plane[3]);
    for (let f = 0; f < faces.length; f += 3) {
      const corners = [...faces.subarray(f, f + 3)], [a, b, c] = corners.map((v) => on_screen[v]), cut = corners.filter((v) => hidden[v]).length;
      if (corners.filter((v) => objects.hidden.has(ids[v])).length >= 2) continue;
      if (cut === 3 || Math.min(a[2], b[2], c[2]) <= 0.01) continue;
      order.push([f, a[2] + b[2] + c[2]]);
      if (cut > 0) outlines.set(f, clipped(corners.map((v) => [...places.subarray(3 * v, 3 * v + 3)]), plane).map((p) => projected(camera, p)));
    }
    order.sort((a, b) => b[1] - a[1]);
    context.fillStyle = '#777';
    context.fillRect(0, 0, width, height);
    for (const [f] of order) {
      const corners = [0, 1, 2].map((k) => faces[f + k]);
      const rgb = [0, 1, 2].map((c) => Math.round(corners.reduce((sum, v) => sum + colors[3 * v + c], 0) / 3));
      context.fillStyle = context.strokeStyle = `rgb(${rgb})`;
      context.beginPath();
      (outlines.get(f) ?? corners.map((v) => on_screen[v])).forEach(([x, y], k) => context[k ? 'lineTo' : 'moveTo'](x, y));
      context.closePath();
      context.fill();
      context.stroke();
    }
  };
  let held = null;
  canvas.addEventListener('pointerdown', (e) => ((held = [e.clientX, e.clientY]), canvas.setPointerCapture(e.pointerId)));
  canvas.addEventListener('pointerup', () => (held = null));
  canvas.addEventListener('pointermove', (e) => {
    if (!held) return;
    const way = eye.position.clone().sub(target), side = new Vector3().crossVectors(up, way).normalize();
    way.applyAxisAngle(up, (held[0] - e.clientX) * 0.008).applyAxisAngle(side, (held[1] - e.clientY) * 0.006);
    if (Math.abs(way.z) < 0.98 * way.length()) eye.position.copy(target).add(way);
    eye.lookAt(target);
    held = [e.clientX, e.clientY];
    draw();
  });
  canvas.addEventListener('wheel', (e) => {
    e.preventDefault();
    eye.position.lerp(target, e.deltaY < 0 ? 0.1 : -0.1);
    draw();
  }, { passive: false });
  addEventListener('resize', draw);
  clip.on_change = objects.on_change = draw;
  draw();
  return eye;
}
