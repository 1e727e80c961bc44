// Renders surfels: textures of their data, their colours for a camera (one pass, a texel each), their order along the view axis,
// and the blended channels.
import {
  DataTexture, DataUtils, FloatType, GLSL3, HalfFloatType, NearestFilter, NoBlending, RawShaderMaterial, RedIntegerFormat, RGBAFormat,
  UnsignedByteType, UnsignedIntType, WebGLRenderTarget,
} from 'three';
import { FullScreenQuad } from 'three/addons/postprocessing/Pass.js';
import { kNoClip } from './clip_plane.js';
import { camera_uniforms, set_camera } from './cameras.js';
import { confidence } from './confidence.js';
import { kMap, Order } from './order.js';
import { surfel_constants, surfel_places, surfel_turns } from './scene_data.js';
import camera_glsl from './camera.glsl';
import blend_glsl from './blend.glsl';
import fragment_glsl from './surfel_fragment.glsl';
import color_glsl from './surfel_color.glsl';
import harmonics_glsl from './harmonics.glsl';

export const kWidth = 1024;
const kTableWidth = 2048, kPerTable = 16;  // texels per row; texels per surfel in coefficient tables
export const kGuess = 1, kSky = 2;
const kInside = 4;                         // flags of surfels (stages/view/page_surfels.h)

export const kInsideAlbedo = 8;  // scale of the albedo behind glass (kMostAlbedo in page_surfels.cpp)
export const Paint = { Photographed: 0, Matt: 1, Albedo: 2, Returned: 3, Confidence: 4 };

export function texture(data, width, type) {
  const t = new DataTexture(data, width, data.length / 4 / width, RGBAFormat, type);
  t.minFilter = t.magFilter = NearestFilter;
  t.needsUpdate = true;
  return t;
}
// Zeroed array for `count` integers.
export function whole_numbers(count) {
  const rows = Math.max(1, Math.ceil(count / kTableWidth));
  const t = new DataTexture(new Uint32Array(kTableWidth * rows), kTableWidth, rows, RedIntegerFormat, UnsignedIntType);
  t.internalFormat = 'R32UI';
  t.minFilter = t.magFilter = NearestFilter;
  return t;
}
// fill(out, i) writes four numbers of surfel i at 4 i.
function per_surfel(count, Kind, type, fill) {
  const data = new Kind(4 * kWidth * Math.ceil(count / kWidth));
  for (let i = 0; i < count; ++i) fill(data, 4 * i, i);
  return texture(data, kWidth, type);
}
// `width` bytes per surfel, three per texel, in the first of its sixteen texels.
function table(count, bytes, width) {
  const data = new Uint8Array(4 * kTableWidth * Math.max(1, Math.ceil((count * kPerTable) / kTableWidth)));
  for (let i = 0; i < count; ++i)
    for (let k = 0; k < width; ++k) data[4 * (kPerTable * i + Math.floor(k / 3)) + (k % 3)] = bytes[i * width + k];
  return texture(data, kTableWidth, UnsignedByteType);
}
const squared = (byte) => (byte / 255) ** 2;
const half = (x) => DataUtils.toHalfFloat(x);

export class Surfels {
  constructor(renderer, { scene, blocks }) {
    const n = scene.surfels, b = blocks;
    this.renderer = renderer;
    this.solid = scene.solid, this.drawn = scene.drawn;
    this.near_z = scene.near_z;
    this.clip = kNoClip;  // clip_plane.js
    this.places = surfel_places(b.place);
    const turns = surfel_turns(b.turn), constants = surfel_constants(b.constant), opacities = Float32Array.from(b.opacity, (v) => v / 255);
    this.maps = texture(new Float32Array(kMap * kWidth * Math.ceil(n / kWidth)), 3 * kWidth, FloatType);
    this.by = new Order({
      places: this.places, turns, spans: Float32Array.from(b.span, DataUtils.fromHalfFloat), opacities, flags: b.flags,
      maps: this.maps.image.data,
    });
    const material = (m) => [
      per_surfel(n, Uint16Array, HalfFloatType, (o, at, i) => {
        for (let c = 0; c < 4; ++c) o[at + c] = half(squared(m[6 * i + c]));
      }),
      per_surfel(n, Uint16Array, HalfFloatType, (o, at, i) => {
        for (let c = 0; c < 2; ++c) o[at + c] = half(squared(m[6 * i + 4 + c]));
      }),
    ];
    const t = (this.textures = {
      places: per_surfel(n, Float32Array, FloatType, (o, at, i) => {
        o.set(this.places.subarray(3 * i, 3 * i + 3), at);
        o[at + 3] = opacities[i];
      }),
      turns: per_surfel(n, Float32Array, FloatType, (o, at, i) => o.set(turns.subarray(4 * i, 4 * i + 4), at)),
      spans: per_surfel(n, Uint16Array, HalfFloatType, (o, at, i) => o.set(b.span.subarray(2 * i, 2 * i + 2), at)),
      constants: per_surfel(n, Uint16Array, HalfFloatType, (o, at, i) => {
        for (let c = 0; c < 3; ++c) o[at + c] = half(constants[3 * i + c]);
      }),
      scales: per_surfel(n, Uint16Array, HalfFloatType, (o, at, i) => {
        o[at] = b.sh_scale.length ? b.sh_scale[i] : 0, o[at + 1] = half(b.flags[i] & kInside ? kInsideAlbedo : 1);
        o.set(confidence(b.seen[i]).map(half), at + 2);
      }),
    });
    t.tints = per_surfel(n, Uint16Array, HalfFloatType, (o, at) => o.fill(half(1), at, at + 3));  // by edits
    const sh_width = b.sh.length / Math.max(1, n);
    this.sh_count = sh_width / 3;
    t.sh = table(n, b.sh, sh_width);
    [t.materials, t.weights] = material(b.material);
    [t.lit_materials, t.lit_weights] = scene.relit ? material(b.lit_material) : [t.materials, t.weights];
    if (scene.relit) {
      t.albedo = per_surfel(n, Uint8Array, UnsignedByteType, (o, at, i) => o.set(b.albedo.subarray(3 * i, 3 * i + 3), at));
      t.irradiance = per_surfel(n, Uint16Array, HalfFloatType, () => {});
    } else {
      t.albedo = t.irradiance = t.constants;
    }

    this.color_target = new WebGLRenderTarget(kWidth, t.places.image.height, {
      count: 2, type: HalfFloatType, minFilter: NearestFilter, magFilter: NearestFilter, depthBuffer: false,
    });
    const textures = (...names) => Object.fromEntries(names.map((name) => [name, { value: t[name] }]));
    this.color_uniforms = {
      ...textures('places', 'turns', 'weights', 'constants', 'tints', 'sh', 'scales', 'albedo', 'lit_materials', 'lit_weights', 'irradiance'),
      eye: { value: null }, paint: { value: 0 }, clear: { value: false }, sh_count: { value: this.sh_count }, count: { value: n },
      layered: { value: scene.blend === 'layered' },
    };
    this.color_quad = new FullScreenQuad(new RawShaderMaterial({
      glslVersion: GLSL3, uniforms: this.color_uniforms, depthTest: false, depthWrite: false, blending: NoBlending,
      vertexShader: 'in vec3 position; void main() { gl_Position = vec4(position, 1.0); }',
      fragmentShader: `precision highp float;\n${blend_glsl}${harmonics_glsl}${color_glsl}`,
    }));

    this.uniforms = {
      ...camera_uniforms(), ...textures('materials'), near_z: { value: 0 }, clip: { value: null },
      colors: { value: this.color_target.textures[0] }, facings: { value: this.color_target.textures[1] },
      maps: { value: this.maps }, lists: { value: null }, starts: { value: null }, tiles: { value: [1, 1, 0, 0] }, tile_rows: { value: [0, 0] },
    };
    const drawn = (defines) => new FullScreenQuad(new RawShaderMaterial({
      glslVersion: GLSL3, uniforms: this.uniforms, defines, depthTest: false, depthWrite: false, blending: NoBlending,
      vertexShader: 'in vec3 position; void main() { gl_Position = vec4(position, 1.0); }',
      fragmentShader: `precision highp float;\n${camera_glsl}${fragment_glsl}`,
    }));
    this.quads = { surface: drawn({ SURFACE: 1 }), color: drawn({}) };
  }

  // values: [3 n], irradiance of each surfel.
  set_irradiance(values) {
    const { image } = this.textures.irradiance;
    for (let i = 0; 3 * i < values.length; ++i) for (let c = 0; c < 3; ++c) image.data[4 * i + c] = half(Math.min(values[3 * i + c], 65000));
    this.textures.irradiance.needsUpdate = true;
  }

  // Hides surfels with is_gone(i) from pictures and rays.
  leave_out(is_gone) {
    const { opacities, trained } = this.by, { data } = this.textures.places.image;
    for (let i = 0; i < this.drawn; ++i) opacities[i] = data[4 * i + 3] = is_gone(i) ? 0 : trained[i];
    this.textures.places.needsUpdate = true;
  }

  // Computes colours and normals for `camera`. what: {paint, lit, clear: tau instead of k_s}
  paint(camera, { paint, lit, clear }) {
    const u = this.color_uniforms;
    set_camera({ ...camera_uniforms(), eye: u.eye }, camera);
    u.paint.value = paint, u.clear.value = clear ?? false;
    u.weights.value = lit ? this.textures.lit_weights : this.textures.weights;
    this.renderer.setRenderTarget(this.color_target);
    this.color_quad.render(this.renderer);
  }

  // Uploads per-picture data to a texture; reallocates it if too small.
  upload(name, values, count) {
    const u = this.uniforms[name];
    if (!u.value || u.value.image.data.length < count) {
      u.value?.dispose();
      u.value = whole_numbers(Math.ceil(1.3 * count));
    }
    u.value.image.data.set(values.subarray(0, count));
    u.value.needsUpdate = true;
  }

  // Draws into the bound target. what: {first, last: range of surfels; surface: false for colour only; plane, window: order.js;
  // mirrors: exclude guessed surfels; near_z; lit}
  draw(camera, what = {}) {
    const u = this.uniforms, near_z = what.near_z ?? this.near_z;
    const without = (what.mirrors ? kGuess : 0) | (what.lit ? kSky : 0);
    const { tile, columns, rows, left, top, count } = this.by.tile_lists(camera, { first: 0, last: this.solid, ...what, near_z, without, clip: this.clip });
    this.upload('lists', this.by.lists, count);
    this.upload('starts', this.by.starts, this.by.starts.length);
    this.maps.needsUpdate = true;
    u.tiles.value = [tile, columns, left, top], u.tile_rows.value = [rows, 0];
    set_camera(u, camera);
    u.near_z.value = near_z, u.clip.value = this.clip;
    u.materials.value = what.lit ? this.textures.lit_materials : this.textures.materials;
    (what.surface === false ? this.quads.color : this.quads.surface).render(this.renderer);
  }
}
