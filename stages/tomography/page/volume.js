// The volume in the page (stages/tomography/page_volume.h): head (JSON) and steps (all low bytes, then all high bytes).
import { inflated } from '../../page/inflated.js';

const kFormat = 1;  // version of the data, as in page_volume.cpp

// Throws if the page has no volume, one of another version, or a damaged one.
export async function read_volume(from = document) {
  const text = (id) => from.querySelector(`script#${id}`)?.textContent;
  if (!text('head') || !text('steps')) throw new Error('it holds no volume: `vitrine ct` puts one in, into ct/page.html');
  let head, values;
  try {
    head = JSON.parse(text('head'));
    if (head.format === kFormat) {
      const count = head.size[0] * head.size[1] * head.size[2], bytes = await inflated(text('steps'));
      if (bytes.length !== 2 * count) throw new Error('the number of its voxels is wrong');
      values = Uint16Array.from({ length: count }, (_, i) => bytes[i] | (bytes[count + i] << 8));
    }
  } catch (e) {
    throw new Error('its data are damaged', { cause: e });
  }
  if (head.format !== kFormat) throw new Error(`its volume is of format ${head.format}, and this page reads format ${kFormat}: make it with the same vitrine`);
  return new Volume(head, values);
}

// Voxel i spans origin + cell [i, i + 1) along each axis; lengths in `unit`, densities in 1 / unit.
export class Volume {
  constructor(head, values) {
    Object.assign(this, head);  // size, cell, origin, end, low, high, steps, unit, iso, radius, scan_size, scan_cell
    this.values = values;
    this.strides = [1, this.size[0], this.size[0] * this.size[1]];
    this.last = this.size.map((n, c) => this.origin[c] + n * this.cell);  // the end of the last voxels, which may lie past `end`
    this.middle = this.origin.map((o, c) => (o + this.end[c]) / 2);
    this.per_length = `${this.unit}\u207b\u00b9`;
    this.diagonal = Math.hypot(...this.end.map((e, c) => e - this.origin[c]));
  }
  density_of(step) {
    return this.low + (step * (this.high - this.low)) / this.steps;
  }
  step_of(density) {
    return Math.max(0, Math.min(this.steps, Math.round(((density - this.low) / (this.high - this.low || 1)) * this.steps)));
  }
  // Of the voxel at a place; null outside of what the scan shows.
  density(place) {
    if (!this.shows(place)) return null;
    return this.density_of(this.values[place.reduce((sum, p, c) => sum + this.voxel(p, c) * this.strides[c], 0)]);
  }
  voxel(place, axis) {
    return Math.max(0, Math.min(this.size[axis] - 1, Math.floor((place - this.origin[axis]) / this.cell)));
  }
  centre(voxel, axis) {
    return this.origin[axis] + (voxel + 0.5) * this.cell;
  }
  contains(place) {
    return place.every((p, c) => p >= this.origin[c] && p <= this.end[c]);
  }
  // The axis of rotation is z through 0; outside of the cylinder around it not all projections show the place.
  shows(place) {
    return this.contains(place) && (this.radius === null || Math.hypot(place[0], place[1]) <= this.radius);
  }
  // Number of shown voxels at each step.
  histogram() {
    if (this.counts) return this.counts;
    const counts = (this.counts = new Float64Array(this.steps + 1)), [nx, ny, nz] = this.size;
    for (let y = 0; y < ny; ++y)
      for (let x = 0; x < nx; ++x) {
        if (!this.shows([this.centre(x, 0), this.centre(y, 1), this.middle[2]])) continue;
        for (let z = 0, i = x + y * this.strides[1]; z < nz; ++z, i += this.strides[2]) ++counts[this.values[i]];
      }
    return counts;
  }
  // Density below which that share of the shown voxels lies, of those denser than `iso`.
  quantile(share) {
    const counts = this.histogram(), first = this.step_of(this.iso), all = counts.subarray(first).reduce((a, b) => a + b, 0);
    let sum = 0, step = first;
    while (step < this.steps && (sum += counts[step]) < share * all) ++step;
    return this.density_of(step);
  }
}
