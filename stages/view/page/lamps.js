// Lamps: round distant sources. They are added to the environment map as discs, so that everything lit by the map includes them:
// surfels through their open cells, mirrors, the background.
//   {azimuth, elevation: degrees, azimuth counter-clockwise from +x seen from above, independent of the rotation of the light;
//    size: diameter in degrees, color: #rrggbb, on,
//    power: irradiance of a surface facing a white lamp, relative to a uniform sky with the mean luminance of the map}
import { is_hex, linear_of } from './colors.js';
import { direction, sky } from './sky.js';

const kRadians = Math.PI / 180;
const kWidth = 512;  // width of the map with lamps
const kSavedWidth = 1024, kMostSaved = 4096;
const kTexelsAcross = 2;  // across the smallest disc: avoids holes
const kSubsamples = 4;  // per texel and axis: coverage of a texel by a disc
const kCell = 9;  // degrees; size of the cells that shadows use (core/render/relight/light_transfer.h)
const kFar = 1000;  // distance of lamps in a file, in radii of the camera ring

export const kLampRanges = { azimuth: [-180, 180], elevation: [-90, 90], size: [0.5, 60], power: [0, 20] };
const within = (v, [least, most]) => Number.isFinite(v) && v >= least && v <= most;

// Over the left shoulder of a viewer at `eye` looking at `target`.
export function new_lamp(eye, target) {
  const seen_from = Math.atan2(eye[1] - target[1], eye[0] - target[0]) / kRadians;
  return { azimuth: wrapped(Math.round(seen_from - 50)), elevation: 40, size: 12, color: '#ffffff', power: 3, on: true };
}
export const wrapped = (degrees) => ((((degrees + 180) % 360) + 360) % 360) - 180;
export const towards_lamp = ({ azimuth, elevation }) => {
  const a = azimuth * kRadians, e = elevation * kRadians;
  return [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
};

// ---- page address: azimuth,elevation,size,power,rrggbb,on;...

export const lamps_text = (lamps) => lamps.map((l) => [l.azimuth, l.elevation, l.size, l.power, l.color.slice(1), l.on ? 1 : 0].join(',')).join(';');
export function lamps_of(text) {
  return text.split(';').flatMap((one) => {
    const [azimuth, elevation, size, power, rgb, on] = one.split(',');
    const lamp = { azimuth: Number(azimuth), elevation: Number(elevation), size: Number(size), power: Number(power), color: `#${rgb}`, on: on !== '0' };
    return is_hex(lamp.color) && Object.entries(kLampRanges).every(([key, range]) => within(lamp[key], range)) ? [lamp] : [];
  });
}

// ---- environment map

// Mean luminance over all directions; 1 for a black map, so that lamps are visible there.
const means = new WeakMap();
function mean_luminance(map) {
  if (means.has(map)) return means.get(map);
  const { width, height, data } = map;
  let sum = 0, all = 0;
  for (let y = 0; y < height; ++y) {
    const angle = Math.cos((Math.PI * y) / height) - Math.cos((Math.PI * (y + 1)) / height);
    for (let at = 3 * y * width; at < 3 * (y + 1) * width; at += 3) sum += angle * (0.2126 * data[at] + 0.7152 * data[at + 1] + 0.0722 * data[at + 2]);
    all += angle * width;
  }
  means.set(map, sum > 0 ? sum / all : 1);
  return means.get(map);
}
// Irradiance of a surface that faces the lamp.
const irradiance_of = (lamp, map) => linear_of(lamp.color).map((c) => lamp.power * Math.PI * mean_luminance(map) * c);

// The map rotated about +z by `turn` degrees, resampled to width w.
function resampled({ name, width, height, data }, turn, w) {
  const h = w / 2, out = new Float32Array(3 * w * h), across = Math.max(1, Math.round(width / w));  // samples per texel and axis
  for (let y = 0; y < h; ++y)
    for (let x = 0; x < w; ++x)
      for (let k = 0; k < across * across; ++k) {
        const px = ((x + (0.5 + (k % across)) / across) / w + turn / 360) * width - 0.5, py = ((y + (0.5 + Math.floor(k / across)) / across) / h) * height - 0.5;
        const left = Math.floor(px), top = Math.floor(py), fx = px - left, fy = py - top;
        for (const [column, row, weight] of [[left, top, (1 - fx) * (1 - fy)], [left + 1, top, fx * (1 - fy)], [left, top + 1, (1 - fx) * fy], [left + 1, top + 1, fx * fy]]) {
          if (weight === 0) continue;
          const from = 3 * (Math.min(height - 1, Math.max(0, row)) * width + (((column % width) + width) % width));
          for (let c = 0; c < 3; ++c) out[3 * (y * w + x) + c] += (weight * data[from + c]) / (across * across);
        }
      }
  return sky(name, w, h, out);
}

// Adds a disc of at least `least` degrees; its energy is exact at any resolution.
function add_disc({ width, height, data }, lamp, irradiance, least) {
  const texel = 360 / width, half = 0.5 * Math.max(lamp.size, least, kTexelsAcross * texel), d = towards_lamp(lamp);
  const dot = ([x, y, z]) => x * d[0] + y * d[1] + z * d[2], inside = Math.cos(half * kRadians), near = Math.cos(Math.min(180, half + texel) * kRadians);
  const first = Math.max(0, Math.floor((90 - lamp.elevation - half) / texel - 1)), last = Math.min(height, Math.ceil((90 - lamp.elevation + half) / texel + 1));
  const covered = [];
  let all = 0;
  for (let y = first; y < last; ++y) {
    const angle = ((2 * Math.PI) / width) * (Math.cos((Math.PI * y) / height) - Math.cos((Math.PI * (y + 1)) / height));
    for (let x = 0; x < width; ++x) {
      if (dot(direction((x + 0.5) / width, (y + 0.5) / height)) < near) continue;
      let hits = 0;
      for (let k = 0; k < kSubsamples ** 2; ++k) {
        const u = (x + (0.5 + (k % kSubsamples)) / kSubsamples) / width, v = (y + (0.5 + Math.floor(k / kSubsamples)) / kSubsamples) / height;
        hits += dot(direction(u, v)) >= inside;
      }
      if (hits === 0) continue;
      all += angle * hits;
      covered.push([3 * (y * width + x), hits]);
    }
  }
  const flux = 2 / (1 + Math.cos(0.5 * lamp.size * kRadians));  // flux of a disc over the irradiance of a surface facing it
  for (const [at, hits] of covered) for (let c = 0; c < 3; ++c) data[at + c] += (hits * flux * irradiance[c]) / all;
}

let base = {};  // last map without lamps
function composed(map, { turn, sky: dimmed, lamps }, width, least) {
  if (base.map !== map || base.turn !== turn || base.all.width !== width) base = { map, turn, all: resampled(map, turn, width) };
  const out = sky(map.name, width, width / 2, base.all.data.map((v) => v * dimmed));
  for (const lamp of lamps) if (lamp.on && lamp.power > 0) add_disc(out, lamp, irradiance_of(lamp, map), least);
  return out;
}
const changes_nothing = ({ sky: dimmed, lamps }) => dimmed === 1 && !lamps.some((l) => l.on && l.power > 0);

// Arguments of Picture.set_light: the map, its rotation, and the map for the direct light of surfels, in which lamps are at least
// one cell wide: shadows of smaller lamps would jump from cell to cell.
export function lit(map, state) {
  if (changes_nothing(state)) return [map, state.turn, map];
  return [composed(map, state, kWidth, 0), 0, composed(map, state, kWidth, kCell)];
}

// ---- files

// The whole light with its rotation applied, for `vitrine relight --env`; resolution for the map and its smallest lamp.
export function saved_map(map, state) {
  const smallest = Math.min(...state.lamps.filter((l) => l.on).map((l) => l.size), Infinity), wanted = Math.max(map.width, (360 * kTexelsAcross) / smallest);
  let width = kSavedWidth;
  while (width < wanted && width < kMostSaved) width *= 2;
  return composed(map, state, width, 0);
}

// The lamps only, for `vitrine relight --lights`: distant discs (core/scene/light/lighting.h).
export function lamps_yaml(map, lamps) {
  const short = (v) => String(Number(v.toPrecision(6))), list = (v) => `[${v.map(short).join(', ')}]`;
  const lines = lamps.filter((l) => l.on && l.power > 0).map((lamp) => {
    const d = towards_lamp(lamp), half = 0.5 * lamp.size * kRadians, radiance = irradiance_of(lamp, map).map((e) => e / (Math.PI * Math.sin(half) ** 2));
    return `  - {type: disc, center: ${list(d.map((v) => kFar * v))}, facing: ${list(d.map((v) => -v))}, radius: ${short(kFar * Math.tan(half))}, radiance: ${list(radiance)}}\n`;
  });
  return `# Lamps of a page of vitrine view, for vitrine relight --lights; the sky is not among them.\nlights:${lines.length ? `\n${lines.join('')}` : ' []\n'}`;
}
