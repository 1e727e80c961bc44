// Irradiance of every surfel under a light (core/render/relight/light_transfer.h): direct light from its open cells, and light from the
// scene by spherical harmonics of degree 1.
import { DataUtils } from 'three';

const kWords = 18, kNoSide = 255, kBounced = 3, kSteps = 48, kZero = 128;

// Light leaves wax and marble around the place where it entered (core/render/relight/subsurface.h). lender, lent_share: of each
// surfel in `scattering`. Changes `light`, [3 count].
export function scatter_below({ scattering, lender, lent_share }, light) {
  if (!scattering) return light;
  const lenders = lender.length / scattering.length, entered = light.slice();
  for (let s = 0; s < scattering.length; ++s)
    for (let c = 0; c < 3; ++c) {
      let sum = 0, shares = 0;
      for (let j = s * lenders; j < (s + 1) * lenders; ++j) (sum += lent_share[3 * j + c] * entered[3 * lender[j] + c]), (shares += lent_share[3 * j + c]);
      if (shares > 0) light[3 * scattering[s] + c] = sum / shares;
    }
  return light;
}

// Returns [3 count]. cells: {flux, directions} (sky.js); harmonics: 16 x 3.
export function irradiance({ open, side, bounced, bounced_constant }, count, cells, harmonics) {
  const out = new Float32Array(3 * count), { flux, directions } = cells;
  const constants = Float32Array.from(bounced_constant, DataUtils.fromHalfFloat);
  for (let i = 0; i < count; ++i) {
    const all_sides = side[2 * i] === kNoSide;
    let nx = (side[2 * i] - 127) / 127, ny = (side[2 * i + 1] - 127) / 127, nz = 1 - Math.abs(nx) - Math.abs(ny);
    if (nz < 0) [nx, ny] = [(1 - Math.abs(ny)) * (nx < 0 ? -1 : 1), (1 - Math.abs(nx)) * (ny < 0 ? -1 : 1)];
    const size = 1 / Math.hypot(nx, ny, nz);
    nx *= size, ny *= size, nz *= size;
    let r = 0, g = 0, b = 0;
    for (let word = 0; word < kWords; ++word)
      for (let bits = open[kWords * i + word]; bits !== 0; bits &= bits - 1) {
        const at = 3 * (32 * word + 31 - Math.clz32(bits & -bits));
        const cosine = all_sides ? 0.25 : nx * directions[at] + ny * directions[at + 1] + nz * directions[at + 2];
        if (cosine > 0) (r += cosine * flux[at]), (g += cosine * flux[at + 1]), (b += cosine * flux[at + 2]);
      }
    const direct = [r, g, b];
    for (let c = 0; c < 3; ++c) {
      let e = harmonics[0][c];
      for (let k = 0; k < kBounced; ++k) e += (harmonics[k + 1][c] * (bounced[kBounced * i + k] - kZero)) / kSteps;
      out[3 * i + c] = direct[c] + Math.max(0, e) * constants[3 * i + c];
    }
  }
  return out;
}
