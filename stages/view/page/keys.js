// Keys on the picture: arrows rotate the scene, with shift they move it; + and - zoom, digits select modes, r and f views.
import { Vector3 } from 'three';
import { kModes } from './picture.js';

const kTurn = 0.06, kZoom = 0.9, kPan = 0.04;

export function listen_to_keys(canvas, view) {
  canvas.addEventListener('keydown', (e) => pressed(e, view));
}

function pressed(e, view) {
  const { eye, controls } = view;
  const turn = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[e.key];
  const target = controls.target, way = eye.position.clone().sub(target), up = new Vector3(0, 0, 1);
  const side = new Vector3().crossVectors(up, way).normalize();
  const modes = Object.keys(kModes);
  if (turn && e.shiftKey) {
    const step = side.multiplyScalar(-turn[0]).addScaledVector(up, turn[1]).multiplyScalar(-kPan * way.length());
    target.add(step), eye.position.add(step);
  } else if (turn) {
    const turned = way.clone().applyAxisAngle(up, turn[0] * kTurn).applyAxisAngle(side, turn[1] * kTurn);
    if (Math.abs(turned.z) < 0.995 * turned.length()) eye.position.copy(target).add(turned);
  } else if (e.key === '+' || e.key === '=' || e.key === '-') {
    eye.position.copy(target).addScaledVector(way, e.key === '-' ? 1 / kZoom : kZoom);
  } else if (e.key >= '1' && e.key <= String(modes.length)) {
    return view.set({ mode: modes[e.key - 1] });
  } else if (e.key === 'r') {
    return view.reset();
  } else if (e.key === 'f') {
    return view.frame_scene();
  } else {
    return;
  }
  e.preventDefault();
  controls.update();
  view.moved();
}
