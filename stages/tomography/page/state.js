// What all parts of the page share: the place of the crosshair, the range of grey values, the zoom of the slices.
import { clamped } from './numbers.js';

const kMostZoom = 40;
const kBright = 0.9, kAbove = 1.25;  // quantile of the material, times which white is at the start

export class State {
  constructor(volume) {
    this.volume = volume, this.listeners = [];
    this.place = [0, 1, 2].map((c) => volume.centre(volume.size[c] >> 1, c));
    this.hovered = null;  // place under the pointer
    this.measuring = false, this.measure = null;
    this.show_whole();
    this.reset_window();
  }
  on_change(listener) {
    this.listeners.push(listener);
  }
  changed(what) {
    for (const f of this.listeners) f(what);
  }

  go(place) {
    const { volume } = this;
    this.place = place.map((p, c) => clamped(p, volume.origin[c], volume.end[c]));
    this.changed('place');
  }
  // By voxels along one axis.
  step(axis, count) {
    const { volume } = this, voxel = clamped(volume.voxel(this.place[axis], axis) + count, 0, volume.size[axis] - 1);
    this.go(this.place.map((p, c) => (c === axis ? volume.centre(voxel, c) : p)));
  }
  hover(place) {
    this.hovered = place;
    this.changed('hover');
  }

  // measure: {axis, from, to}, places in a slice across the axis; null without one.
  set_measure(measure) {
    this.measure = measure;
    this.changed('measure');
  }
  set_measuring(on) {
    this.measuring = on;
    this.changed('measure');
  }

  // Densities that are black and white.
  set_window(black, white) {
    const { low, high } = this.volume, least = (high - low) / 1000 || 1, reach = high - low || 1;
    this.black = clamped(black, low - reach, high - least);
    this.white = clamped(white, this.black + least, high + reach);
    this.changed('window');
  }
  reset_window() {
    const { low, high } = this.volume, bright = kAbove * this.volume.quantile(kBright);
    this.set_window(low, Math.min(high, bright > low ? bright : high));
  }

  // `focus`: the place in the middle of the slices.
  set_zoom(zoom, focus = this.focus) {
    const { volume } = this;
    this.zoom = clamped(zoom, 1, kMostZoom);
    this.focus = this.zoom === 1 ? [...volume.middle] : focus.map((p, c) => clamped(p, volume.origin[c], volume.end[c]));
    this.changed('zoom');
  }
  show_whole() {
    this.set_zoom(1);
  }
}
