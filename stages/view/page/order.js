// Projects surfels and builds the list of surfels of each screen tile, sorted approximately by depth; surfel_fragment.glsl
// completes the sorting per pixel. The sort key is the depth of the surfel's plane at the centre of the tile: for nearly coplanar
// surfels, as on a table, the order is then right in all pixels, regardless of their size.
const kTile = 8, kMostTiles = 1 << 16;
const kMinAlpha = 1 / 255, kEdgeOn = 1e-4;
const kBits = 11, kBuckets = 1 << kBits;
export const kMap = 12;  // cx cy z0 opacity, m00 m01 m10 m11, h0 h1 - -

// Radix sort of items by 32-bit keys, ascending; `spare` has the same length.
function radix_sort(keys, items, count, spare) {
  const starts = new Uint32Array(kBuckets + 1);
  for (let shift = 0; shift < 32; shift += kBits) {
    starts.fill(0);
    for (let i = 0; i < count; ++i) ++starts[1 + ((keys[i] >>> shift) & (kBuckets - 1))];
    for (let k = 0; k < kBuckets; ++k) starts[k + 1] += starts[k];
    for (let i = 0; i < count; ++i) {
      const to = starts[(keys[i] >>> shift) & (kBuckets - 1)]++;
      spare.keys[to] = keys[i], spare.items[to] = items[i];
    }
    keys.set(spare.keys.subarray(0, count)), items.set(spare.items.subarray(0, count));
  }
}

function grown(array, count) {
  if (array.length >= count) return array;
  const more = new array.constructor(Math.ceil(1.5 * count));
  more.set(array);
  return more;
}

export class Order {
  // places [3 n], turns [4 n] (w x y z), spans [2 n] (standard deviations), opacities [n], flags [n]
  constructor({ places, turns, spans, opacities, flags, maps }) {
    Object.assign(this, { places, opacities, flags, trained: opacities.slice() });  // opacities before Surfels.leave_out
    const n = opacities.length;
    this.axes = new Float32Array(6 * n);  // both axes, scaled by the standard deviations
    for (let i = 0; i < n; ++i) {
      const [w, x, y, z] = turns.subarray(4 * i, 4 * i + 4), u = spans[2 * i], v = spans[2 * i + 1];
      this.axes.set([u * (1 - 2 * (y * y + z * z)), u * 2 * (x * y + w * z), u * 2 * (x * z - w * y),
                     v * 2 * (x * y - w * z), v * (1 - 2 * (x * x + z * z)), v * 2 * (y * z + w * x)], 6 * i);
    }
    this.maps = maps;  // [kMap n], overwritten
    this.surfels = new Uint32Array(n), this.tiles = new Uint32Array(n);
    this.keys = new Uint32Array(n), this.depths = new Float32Array(this.keys.buffer);
    this.spare = { keys: new Uint32Array(n), items: new Uint32Array(n) };
    this.lists = new Uint32Array(n), this.starts = new Uint32Array(1);
  }

  reserve(count) {
    for (const name of ['surfels', 'tiles']) this[name] = grown(this[name], count);
    if (this.keys.length < count) {
      this.keys = grown(this.keys, count), this.depths = new Float32Array(this.keys.buffer);
      this.spare = { keys: grown(this.spare.keys, count), items: grown(this.spare.items, count) };
    }
  }

  // Returns {tile: side in pixels, columns, rows, left, top: of the first, count}. Fills this.maps (projected surfels),
  // this.lists (surfels of each tile) and this.starts [tiles + 1] (start of each list). what: {first, last, near_z, without:
  // flags of excluded surfels, plane: [normal, offset] that centres must be in front of, clip: the same for any part of a surfel,
  // window: [left, top, right, bottom] in pixels}
  tile_lists(camera, what) {
    const { places, axes, opacities, flags, maps } = this, { first, last, near_z, without = 0, plane, clip } = what;
    const r = camera.rotation, t = camera.translation, { fx, fy, cx, cy, width, height } = camera;
    const [w0, w1, w2, w3] = what.window ?? [0, 0, width, height];
    let tile = kTile;
    while (Math.ceil((w2 - w0) / tile) * Math.ceil((w3 - w1) / tile) > kMostTiles) tile *= 2;
    const columns = Math.ceil((w2 - w0) / tile), rows = Math.ceil((w3 - w1) / tile);
    let count = 0;
    for (let i = first; i < last; ++i) {
      const o = opacities[i], p = 3 * i, a = 6 * i, x = places[p], y = places[p + 1], w = places[p + 2];
      if (!(o > kMinAlpha) || (flags[i] & without) !== 0) continue;
      if (plane && plane[0] * x + plane[1] * y + plane[2] * w < plane[3]) continue;
      const z0 = r[6] * x + r[7] * y + r[8] * w + t[2];
      if (!(z0 > near_z)) continue;
      const r2 = 2 * Math.log(255 * o), cu = clip[0] * axes[a] + clip[1] * axes[a + 1] + clip[2] * axes[a + 2];
      const cv = clip[0] * axes[a + 3] + clip[1] * axes[a + 4] + clip[2] * axes[a + 5];
      if (clip[0] * x + clip[1] * y + clip[2] * w + Math.sqrt(r2 * (cu * cu + cv * cv)) < clip[3]) continue;
      const X = r[0] * x + r[1] * y + r[2] * w + t[0], Y = r[3] * x + r[4] * y + r[5] * w + t[1];
      const ux = r[0] * axes[a] + r[1] * axes[a + 1] + r[2] * axes[a + 2], uy = r[3] * axes[a] + r[4] * axes[a + 1] + r[5] * axes[a + 2];
      const uz = r[6] * axes[a] + r[7] * axes[a + 1] + r[8] * axes[a + 2], vx = r[0] * axes[a + 3] + r[1] * axes[a + 4] + r[2] * axes[a + 5];
      const vy = r[3] * axes[a + 3] + r[4] * axes[a + 4] + r[5] * axes[a + 5], vz = r[6] * axes[a + 3] + r[7] * axes[a + 4] + r[8] * axes[a + 5];
      const xn = X / z0, yn = Y / z0, mx = fx * xn + cx, my = fy * yn + cy;
      // Extent of the low-pass filter around the centre, and of the projected disc u^2 + v^2 = r2.
      const low_pass = Math.sqrt(0.5 * r2);
      let left = mx - low_pass, right = mx + low_pass, top = my - low_pass, bottom = my + low_pass;
      const ww = r2 * (uz * uz + vz * vz) - z0 * z0;
      if (ww < -1e-12) {
        const ax = fx * (r2 * (ux * uz + vx * vz) - X * z0), ay = fy * (r2 * (uy * uz + vy * vz) - Y * z0);
        const sx = Math.sqrt(Math.max(ax * ax - fx * fx * (r2 * (ux * ux + vx * vx) - X * X) * ww, 0));
        const sy = Math.sqrt(Math.max(ay * ay - fy * fy * (r2 * (uy * uy + vy * vy) - Y * Y) * ww, 0));
        left = Math.min(left, (ax + sx) / ww + cx), right = Math.max(right, (ax - sx) / ww + cx);
        top = Math.min(top, (ay + sy) / ww + cy), bottom = Math.max(bottom, (ay - sy) / ww + cy);
      } else {
        left = top = 0, right = width, bottom = height;
      }
      left = Math.max(w0, Math.floor(left)), right = Math.min(w2, Math.ceil(right));
      top = Math.max(w1, Math.floor(top)), bottom = Math.min(w3, Math.ceil(bottom));
      if (!(right > left && bottom > top)) continue;
      // den = 1 + h.(pixel - middle), (u, v) = M (pixel - middle)/den, z = z0/den
      const Au = fx * (ux - xn * uz), Av = fx * (vx - xn * vz), Bu = fy * (uy - yn * uz), Bv = fy * (vy - yn * vz), det = Au * Bv - Av * Bu;
      const area = fx * fy * Math.sqrt((axes[a] ** 2 + axes[a + 1] ** 2 + axes[a + 2] ** 2) * (axes[a + 3] ** 2 + axes[a + 4] ** 2 + axes[a + 5] ** 2));
      if (!(Math.abs(det) > kEdgeOn * area)) continue;
      const m = kMap * i, s = z0 / det, h0 = (vz * Bu - uz * Bv) / det, h1 = (uz * Av - vz * Au) / det;
      maps[m] = mx, maps[m + 1] = my, maps[m + 2] = z0, maps[m + 3] = o, maps[m + 4] = s * Bv, maps[m + 5] = -s * Av, maps[m + 6] = -s * Bu;
      maps[m + 7] = s * Au, maps[m + 8] = h0, maps[m + 9] = h1;
      const c0 = Math.floor((left - w0) / tile), c1 = Math.floor((right - 1 - w0) / tile), r0 = Math.floor((top - w1) / tile), r1 = Math.floor((bottom - 1 - w1) / tile);
      this.reserve(count + (c1 - c0 + 1) * (r1 - r0 + 1));
      const { surfels, tiles, depths } = this, reach = Math.sqrt(r2 * (uz * uz + vz * vz));
      const nearest = Math.max(z0 - reach, near_z), farthest = z0 + reach;  // depth range of the disc
      for (let row = r0; row <= r1; ++row)
        for (let column = c0; column <= c1; ++column) {
          const den = 1 + h0 * (w0 + (column + 0.5) * tile - mx) + h1 * (w1 + (row + 0.5) * tile - my);
          depths[count] = den > 0 ? Math.min(Math.max(z0 / den, nearest), farthest) : farthest;
          tiles[count] = row * columns + column, surfels[count++] = i;
        }
    }
    const order = new Uint32Array(count), n_tiles = columns * rows;
    for (let i = 0; i < count; ++i) order[i] = i;
    radix_sort(this.keys, order, count, this.spare);
    const starts = (this.starts = new Uint32Array(n_tiles + 1)), next = new Uint32Array(n_tiles);
    for (let i = 0; i < count; ++i) ++starts[1 + this.tiles[i]];
    for (let k = 0; k < n_tiles; ++k) (starts[k + 1] += starts[k]), (next[k] = starts[k]);
    this.lists = grown(this.lists, count);
    for (const i of order) this.lists[next[this.tiles[i]]++] = this.surfels[i];
    return { tile, columns, rows, left: w0, top: w1, count };
  }
}
