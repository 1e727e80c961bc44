// The scene's mesh without WebGL: triangles painted from far to near. Dragging turns it, the wheel moves nearer.
import { PerspectiveCamera, Vector3 } from 'three';
import { from_three, projected, stand_at } from './cameras.js';

// Draws into `canvas` from the first photo's camera; false where the page has no mesh.
export function show_mesh(canvas, { scene, blocks }) {
  const { mesh_position: places, mesh_color: colors, mesh_face: faces } = blocks;
  if (!faces?.length) return false;
  const eye = new PerspectiveCamera(), target = new Vector3(), up = new Vector3(0, 0, 1);
  eye.up.copy(up);
  stand_at(eye, target, scene.cameras[0], scene.middle);

  const draw = () => {
    const width = (canvas.width = canvas.clientWidth), height = (canvas.height = canvas.clientHeight), context = canvas.getContext('2d');
    const camera = from_three(eye, width, height), on_screen = [];
    for (let v = 0; v < places.length; v += 3) on_screen.push(projected(camera, places.subarray(v, v + 3)));
    const order = [];
    for (let f = 0; f < faces.length; f += 3) {
      const [a, b, c] = [0, 1, 2].map((k) => on_screen[faces[f + k]]);
      if (Math.min(a[2], b[2], c[2]) > 0.01) order.push([f, a[2] + b[2] + c[2]]);
    }
    order.sort((a, b) => b[1] - a[1]);
    context.fillStyle = '#777';
    context.fillRect(0, 0, width, height);
    for (const [f] of order) {
      const corners = [0, 1, 2].map((k) => faces[f + k]);
      const rgb = [0, 1, 2].map((c) => Math.round(corners.reduce((sum, v) => sum + colors[3 * v + c], 0) / 3));
      context.fillStyle = context.strokeStyle = `rgb(${rgb})`;
      context.beginPath();
      corners.forEach((v, k) => context[k ? 'lineTo' : 'moveTo'](on_screen[v][0], on_screen[v][1]));
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
  draw();
  return true;
}
