// Environment maps: lat-long maps of linear radiance, first row +z, centre +x, u = 3/4 is -y (core/scene/light/README.md); their
// spherical harmonics; dropped files.
import { DataTexture, DataUtils, FloatType, HalfFloatType, LinearFilter, LinearMipmapLinearFilter, RepeatWrapping, RGBAFormat } from 'three';
import { EXRLoader } from 'three/addons/loaders/EXRLoader.js';
import { HDRLoader } from 'three/addons/loaders/HDRLoader.js';

const kTextureWidth = 512;  // sufficient for reflections
const kBuiltInHeight = 64;

// data: [3 w h], row by row.
export const sky = (name, width, height, data) => ({ name, width, height, data });

export function direction(u, v) {
  const azimuth = -2 * Math.PI * (u - 0.5), elevation = Math.PI * (0.5 - v), c = Math.cos(elevation);
  return [c * Math.cos(azimuth), c * Math.sin(azimuth), Math.sin(elevation)];
}

export function sh_basis([x, y, z]) {
  const xx = x * x, yy = y * y, zz = z * z;
  return [
    0.28209479177387814, -0.4886025119029199 * y, 0.4886025119029199 * z, -0.4886025119029199 * x,
    1.0925484305920792 * x * y, -1.0925484305920792 * y * z, 0.31539156525252005 * (2 * zz - xx - yy),
    -1.0925484305920792 * x * z, 0.5462742152960396 * (xx - yy),
    -0.5900435899266435 * y * (3 * xx - yy), 2.890611442640554 * x * y * z, -0.4570457994644658 * y * (4 * zz - xx - yy),
    0.3731763325901154 * z * (2 * zz - 3 * xx - 3 * yy), -0.4570457994644658 * x * (4 * zz - xx - yy),
    1.445305721320277 * z * (xx - yy), -0.5900435899266435 * x * (xx - 3 * yy),
  ];
}

// Light of a map rotated about +z by `radians` in each of side x side cells of the octahedral map
// (core/render/relight/light_transfer.h): flux [3 cells] and mean direction [3 cells].
export function cell_light({ width, height, data }, radians, side) {
  const flux = new Float32Array(3 * side * side), towards = new Float64Array(3 * side * side), middle = new Float64Array(3 * side * side);
  const cell = (v) => Math.min(side - 1, Math.max(0, Math.floor((0.5 * v + 0.5) * side)));
  for (let row = 0; row < height; ++row) {
    const angle = ((2 * Math.PI) / width) * (Math.cos((Math.PI * row) / height) - Math.cos((Math.PI * (row + 1)) / height));
    const elevation = Math.PI * (0.5 - (row + 0.5) / height), z = Math.sin(elevation), c = Math.cos(elevation);
    for (let x = 0; x < width; ++x) {
      const azimuth = -2 * Math.PI * ((x + 0.5) / width - 0.5) + radians, d = [c * Math.cos(azimuth), c * Math.sin(azimuth), z];
      const s = 1 / (Math.abs(d[0]) + Math.abs(d[1]) + Math.abs(z));
      let px = s * d[0], py = s * d[1];
      if (z < 0) [px, py] = [(1 - Math.abs(py)) * (px < 0 ? -1 : 1), (1 - Math.abs(px)) * (py < 0 ? -1 : 1)];
      const at = 3 * (cell(py) * side + cell(px)), from = 3 * (row * width + x), light = data[from] + data[from + 1] + data[from + 2];
      for (let k = 0; k < 3; ++k) {
        flux[at + k] += angle * data[from + k], towards[at + k] += angle * light * d[k], middle[at + k] += angle * d[k];
      }
    }
  }
  const directions = new Float32Array(flux.length);
  for (let at = 0; at < flux.length; at += 3) {
    const d = Math.hypot(towards[at], towards[at + 1], towards[at + 2]) > 0 ? towards : middle, size = Math.hypot(d[at], d[at + 1], d[at + 2]);
    for (let k = 0; k < 3; ++k) directions[at + k] = size > 0 ? d[at + k] / size : 0;
  }
  return { flux, directions };
}

// SH coefficients of a map with constant texels, 16 x 3.
export function harmonics({ width, height, data }) {
  const sum = Array.from({ length: 16 }, () => [0, 0, 0]);
  for (let row = 0; row < height; ++row) {
    const angle = ((2 * Math.PI) / width) * (Math.cos((Math.PI * row) / height) - Math.cos((Math.PI * (row + 1)) / height));
    for (let x = 0; x < width; ++x) {
      const basis = sh_basis(direction((x + 0.5) / width, (row + 0.5) / height)), at = 3 * (row * width + x);
      for (let k = 0; k < 16; ++k)
        for (let c = 0; c < 3; ++c) sum[k][c] += angle * basis[k] * data[at + c];
    }
  }
  return sum;
}

// Coefficients of the map rotated about +z, counter-clockwise seen from above: terms of order m rotate by m times the angle.
export function turned(coefficients, radians) {
  const out = coefficients.map((c) => [...c]);
  for (let l = 1, middle = 2; l <= 3; ++l, middle += 2 * l)
    for (let m = 1; m <= l; ++m) {
      const cos = Math.cos(m * radians), sin = Math.sin(m * radians), a = coefficients[middle + m], b = coefficients[middle - m];
      out[middle + m] = a.map((v, c) => cos * v - sin * b[c]);
      out[middle - m] = a.map((v, c) => sin * v + cos * b[c]);
    }
  return out;
}

function halved({ name, width, height, data }) {
  const w = width >> 1, h = height >> 1, out = new Float32Array(3 * w * h);
  for (let y = 0; y < h; ++y)
    for (let x = 0; x < w; ++x)
      for (let c = 0; c < 3; ++c) {
        const at = (i, j) => data[3 * ((2 * y + j) * width + 2 * x + i) + c];
        out[3 * (y * w + x) + c] = 0.25 * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1));
      }
  return sky(name, w, h, out);
}

export function sky_texture(map) {
  while (map.width > kTextureWidth) map = halved(map);
  const data = new Uint16Array(4 * map.width * map.height);
  for (let i = 0; i < map.width * map.height; ++i)
    for (let c = 0; c < 4; ++c) data[4 * i + c] = DataUtils.toHalfFloat(c === 3 ? 1 : Math.min(map.data[3 * i + c], 65000));
  const t = new DataTexture(data, map.width, map.height, RGBAFormat, HalfFloatType);
  t.wrapS = RepeatWrapping;
  t.magFilter = LinearFilter, t.minFilter = LinearMipmapLinearFilter;
  t.generateMipmaps = true;
  t.needsUpdate = true;
  return t;
}

// radiance(d) -> [r, g, b]
function painted(name, radiance) {
  const height = kBuiltInHeight, width = 2 * height, data = new Float32Array(3 * width * height);
  for (let y = 0; y < height; ++y)
    for (let x = 0; x < width; ++x) data.set(radiance(direction((x + 0.5) / width, (y + 0.5) / height)), 3 * (y * width + x));
  return sky(name, width, height, data);
}
const towards = (d, azimuth, elevation) => {
  const a = (azimuth * Math.PI) / 180, e = (elevation * Math.PI) / 180;
  return d[0] * Math.cos(e) * Math.cos(a) + d[1] * Math.cos(e) * Math.sin(a) + d[2] * Math.sin(e);
};
const lobe = (cosine, degrees) => Math.exp((cosine - 1) / (1 - Math.cos((degrees * Math.PI) / 180)));

// Studio: two soft boxes and a pale ceiling in a grey room.
export const studio = () =>
  painted('studio', (d) => {
    const key = 9 * lobe(towards(d, 40, 40), 16), fill = 3 * lobe(towards(d, 190, 25), 22), top = 0.8 * Math.max(0, d[2]);
    return [0.25 + top + key + 0.9 * fill, 0.25 + top + 0.97 * key + 0.95 * fill, 0.25 + top + 0.92 * key + fill];
  });
// Evening: a low sun in a clear sky over diffuse ground.
export const evening = () =>
  painted('evening', (d) => {
    const up = Math.max(0, d[2]), sun = 60 * lobe(towards(d, 120, 18), 7), glow = 1.2 * lobe(towards(d, 120, 5), 35), haze = Math.exp(-6 * up);
    if (d[2] < 0) return [0.12, 0.1, 0.08].map((v) => v * (1 + 2 * glow));
    return [0.25 + 0.5 * haze + glow + sun, 0.4 + 0.35 * haze + 0.7 * glow + 0.75 * sun, 0.8 + 0.1 * haze + 0.35 * glow + 0.45 * sun];
  });

const kBeginnings = [['ffd8ff', 'a JPEG picture'], ['89504e47', 'a PNG picture'], ['52494646', 'a WebP picture'], ['25504446', 'a PDF document'], ['49492a00', 'a TIFF picture'], ['47494638', 'a GIF picture']];

// Parses a dropped .hdr or .exr. Throws Error with a message for the user: cause and advice.
export function read_sky(name, buffer) {
  const bytes = new Uint8Array(buffer), start = [...bytes.subarray(0, 4)].map((b) => b.toString(16).padStart(2, '0')).join('');
  const exr = start === '762f3101', hdr = bytes[0] === 0x23 && bytes[1] === 0x3f;
  if (!exr && !hdr) {
    const what = bytes.length === 0 ? 'it is empty' : `it begins like ${kBeginnings.find(([b]) => start.startsWith(b))?.[1] ?? 'no picture of light'}`;
    throw new Error(`${name} is no HDRI: ${what}. Drop a .hdr or .exr file.`);
  }
  let parsed;
  try {
    parsed = new (exr ? EXRLoader : HDRLoader)().setDataType(FloatType).parse(buffer);
  } catch (e) {
    throw new Error(`${name} cannot be read: ${String(e?.message ?? e).replace(/^THREE\.\w+: /, '')}. Save it anew as a Radiance .hdr, or as an .exr with ZIP compression.`);
  }
  const { width, height } = parsed, channels = parsed.data.length / (width * height);
  if (width !== 2 * height) throw new Error(`${name} is ${width} x ${height} pixels; a map of all directions is twice as wide as it is high.`);
  const data = new Float32Array(3 * width * height);
  for (let y = 0; y < height; ++y)
    for (let x = 0; x < width; ++x)
      for (let c = 0; c < 3; ++c) {
        const row = exr ? height - 1 - y : y;  // three.js stores EXR rows bottom up
        const v = parsed.data[channels * (row * width + x) + (channels > 2 ? c : 0)];
        if (!Number.isFinite(v)) throw new Error(`${name} has pixels that are no numbers; repair it in the program that made it.`);
        data[3 * (y * width + x) + c] = Math.max(0, v);
      }
  return sky(name, width, height, data);
}
