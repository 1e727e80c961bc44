// The camera of the picture of the volume: it looks at `target` from a distance, turned about z and tilted.
import { clamped } from './numbers.js';

const kFar = 1.6;  // start, in diagonals of the volume
const kHalf_deg = 16;  // half the field of view along the shorter side
const kMostTilt = 1.55;

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

export class Orbit {
  constructor(volume) {
    this.volume = volume;
    this.reset();
  }
  reset() {
    this.target = [...this.volume.middle];
    this.turn = -1.05, this.tilt = 0.42, this.far = kFar;
  }
  rotate(turn, tilt) {
    this.turn += turn, this.tilt = clamped(this.tilt + tilt, -kMostTilt, kMostTilt);
  }
  zoom(factor) {
    this.far = clamped(this.far / factor, 0.05, 20);
  }
  // By shares of the shorter side of the picture, to the right and up.
  move(dx, dy) {
    const { right, up } = this.axes(), reach = 2 * Math.tan((kHalf_deg * Math.PI) / 180) * this.far * this.volume.diagonal;
    this.target = this.target.map((t, c) => t - (dx * right[c] + dy * up[c]) * reach);
  }
  axes() {
    const back = [Math.cos(this.tilt) * Math.cos(this.turn), Math.cos(this.tilt) * Math.sin(this.turn), Math.sin(this.tilt)];
    const right = [-Math.sin(this.turn), Math.cos(this.turn), 0];
    return { back, right, up: cross(back, right) };
  }
  // For casting.js, and for `projected`.
  camera(width, height) {
    const { back, right, up } = this.axes(), t = Math.tan((kHalf_deg * Math.PI) / 180), short = Math.min(width, height);
    return {
      eye: this.target.map((v, c) => v + back[c] * this.far * this.volume.diagonal), ahead: back.map((v) => -v),
      right: right.map((v) => (v * t * width) / short), up: up.map((v) => (v * t * height) / short), width, height,
    };
  }
}

// Pixel of a point; null behind the eye.
export function projected({ eye, ahead, right, up, width, height }, point) {
  const p = point.map((v, c) => v - eye[c]), depth = dot(p, ahead);
  if (depth <= 0) return null;
  return [((dot(p, right) / dot(right, right) / depth + 1) / 2) * width, ((1 - dot(p, up) / dot(up, up) / depth) / 2) * height];
}
// Direction through a pixel, of length 1.
export function direction({ ahead, right, up, width, height }, [x, y]) {
  const way = ahead.map((v, c) => v + ((2 * x) / width - 1) * right[c] + (1 - (2 * y) / height) * up[c]), length = Math.hypot(...way);
  return way.map((v) => v / length);
}
