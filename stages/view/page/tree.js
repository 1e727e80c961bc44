// Bounding volume hierarchy over surfels for mirror_rays.glsl: nodes in depth-first order, two texels each,
//   least x y z, right child (inner nodes: the left one is the next) or first item;   greatest x y z, -1 - axis or number of items
const kLeaf = 4;

// first, last: range of surfels in `order` (order.js); surfels with a flag of `without` are excluded. Returns {nodes: [8 per
// node], items: surfels}
export function surfel_tree({ places, axes, trained: opacities, flags }, { first, last, without = 0 }) {
  const chosen = [];
  for (let i = first; i < last; ++i) if (!(flags[i] & without)) chosen.push(i);
  const n = chosen.length, low = new Float32Array(3 * n), high = new Float32Array(3 * n), items = new Uint32Array(n);
  for (let k = 0; k < n; ++k) {
    const i = chosen[k], reach = Math.sqrt(Math.max(0, 2 * Math.log(255 * opacities[i])));
    items[k] = k;
    for (let c = 0; c < 3; ++c) {
      const half = reach * Math.hypot(axes[6 * i + c], axes[6 * i + 3 + c]) + 1e-5;
      low[3 * k + c] = places[3 * i + c] - half, high[3 * k + c] = places[3 * i + c] + half;
    }
  }
  const nodes = [];
  const build = (from, to) => {
    const at = nodes.length / 8, least = [Infinity, Infinity, Infinity], most = [-Infinity, -Infinity, -Infinity];
    for (let k = from; k < to; ++k)
      for (let c = 0; c < 3; ++c) {
        least[c] = Math.min(least[c], low[3 * items[k] + c]), most[c] = Math.max(most[c], high[3 * items[k] + c]);
      }
    nodes.push(...least, from, ...most, to - from);
    if (to - from <= kLeaf) return;
    const size = most.map((v, c) => v - least[c]), axis = size.indexOf(Math.max(...size)), middle = (from + to) >> 1;
    items.subarray(from, to).sort((a, b) => low[3 * a + axis] + high[3 * a + axis] - low[3 * b + axis] - high[3 * b + axis] || a - b);
    build(from, middle);
    nodes[8 * at + 3] = nodes.length / 8, nodes[8 * at + 7] = -1 - axis;
    build(middle, to);
  };
  if (n > 0) build(0, n);
  return { nodes: Float32Array.from(nodes), items: items.map((k) => chosen[k]) };
}
