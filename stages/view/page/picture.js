// Renders a picture: surfels blended into channels, known shapes, mirrored pictures of flat panes and mirrors, probes, and the
// compositing pass (composite.glsl).
import {
  GLSL3, HalfFloatType, LinearFilter, LinearMipmapLinearFilter, NearestFilter, NoBlending, RawShaderMaterial, UnsignedByteType,
  WebGLArrayRenderTarget, WebGLRenderTarget, DataUtils,
} from 'three';
import { FullScreenQuad } from 'three/addons/postprocessing/Pass.js';
import { kNoClip } from './clip_plane.js';
import { camera_uniforms, centre_of, mirrored, projected, set_camera } from './cameras.js';
import { scale_uniforms } from './confidence.js';
import { Shapes } from './shapes.js';
import { irradiance, scatter_below } from './irradiance.js';
import { cell_light, harmonics, sky_texture, turned } from './sky.js';
import { Rays } from './rays.js';
import { kGuess, kSky, Paint, Surfels, texture } from './surfels.js';
import blend_glsl from './blend.glsl';
import camera_glsl from './camera.glsl';
import composite_glsl from './composite.glsl';
import light_glsl from './light.glsl';
import harmonics_glsl from './harmonics.glsl';
import mirror_rays_glsl from './mirror_rays.glsl';
import probe_glsl from './probe.glsl';
import surface_glsl from './surface.glsl';

const kMostPictures = 8;  // mirrored pictures per frame; further panes use the probes
const kMirrorNear = 1e-3;
const kProbes = 4;
const kCellSide = 24, kTransferSteps = 48;  // core/render/relight/light_transfer.h, stages/view/page_surfels.cpp

// Modes, their labels, and whether they need materials.
export const kModes = {
  photo: { name: 'As photographed', lit: false }, relit: { name: 'Relit', lit: true },
  open: { name: 'Without the glass' }, glass: { name: 'The glass alone' },
  albedo: { name: 'Albedo', lit: true }, normals: { name: 'Normals' }, roughness: { name: 'Roughness' }, depth: { name: 'Depth' },
  confidence: { name: 'Confidence' },
};
const kShow = { albedo: 1, normals: 2, roughness: 3, depth: 4, glass: 5, confidence: 6 };

const full_screen = 'in vec3 position; void main() { gl_Position = vec4(position, 1.0); }';

export class Picture {
  constructor(renderer, page) {
    const { scene, blocks } = page;
    this.renderer = renderer, this.scene = scene, this.blocks = blocks;
    renderer.autoClear = false;
    renderer.setClearColor(0x000000, 0);
    this.surfels = new Surfels(renderer, page);
    this.shapes = new Shapes(renderer, page);
    const channels = (count) => new WebGLRenderTarget(1, 1, {
      count, type: HalfFloatType, minFilter: NearestFilter, magFilter: NearestFilter, depthBuffer: false,
    });
    this.channels = channels(4);
    this.has_glass = scene.drawn > scene.solid;
    this.glass = this.has_glass ? channels(4) : null;
    this.pictures = null;  // created when there are panes
    this.left_out = {};  // set by leave_out
    this.make_probes(page);

    const { facets, entries } = scene.shapes, role = { mirror: 0, sheet: 1, coat: 2 };
    const list = (items, f) => (items.length ? items.flatMap(f) : [0, 0, 0, 0]);
    const texture_of = (i) => ({ value: this.channels.textures[i] });
    const surface = {
      ...camera_uniforms(),
      color_sum: texture_of(0), normal_sum: texture_of(1), f0_sum: texture_of(2), depth_sum: texture_of(3),
      glass_normal: { value: (this.glass ?? this.channels).textures[1] }, glass_depth: { value: (this.glass ?? this.channels).textures[3] },
      glass_surfels: { value: this.has_glass },
      opaque_shape: { value: this.shapes.targets.opaque.texture }, near_pane: { value: this.shapes.targets.near.texture },
      far_pane: { value: this.shapes.targets.far.texture },
      facet_facts: { value: list(facets, (f) => [-1, f.clear ? 1 : 0, f.at_pane, f.entry]) },
      entries: { value: list(entries, (e) => [e.tolerance, role[e.role], e.exact ? 1 : 0, e.closed ? 1 : 0]) },
      reflects: { value: scene.reflects }, lit: { value: false }, panes: { value: true },
    };
    this.uniforms = {
      ...surface, ...this.sky_uniforms, reflected: { value: null }, pictures: { value: null },
      probe_places: { value: Array.from({ length: kProbes }, (_, i) => scene.probes[i] ?? [0, 0, 0]).flat() },
      probe_count: { value: scene.probes.length }, probe_side: { value: scene.probe_side },
      layered: { value: scene.blend === 'layered' }, background: { value: true }, traced: { value: false }, show: { value: 0 }, gain: { value: [1, 1, 1] },
      depth_range: { value: [0, 1] }, ...scale_uniforms(),
    };
    for (let i = 0; i < kProbes; ++i) this.uniforms[`probe${i}`] = { value: this.lit_probes[Math.min(i, scene.probes.length - 1)]?.texture ?? null };
    const over_screen = (uniforms, fragmentShader, defines = {}) => new FullScreenQuad(new RawShaderMaterial({
      glslVersion: GLSL3, uniforms, depthTest: false, depthWrite: false, blending: NoBlending,
      defines: { ...defines, MOST_FACETS: Math.max(1, facets.length), MOST_ENTRIES: Math.max(1, entries.length) },
      vertexShader: full_screen, fragmentShader: `precision highp float;\n${camera_glsl}${surface_glsl}${fragmentShader}`,
    }));
    this.composite = over_screen(this.uniforms, `${blend_glsl}${light_glsl}${composite_glsl}`);
    const rays = (through, defines) => new Rays(this.surfels, through, (more) => over_screen({ ...surface, ...more }, `${harmonics_glsl}${mirror_rays_glsl}`, defines));
    this.rays = rays({ first: scene.drawn, last: scene.surfels, near: scene.reflection_near }, {});
    this.lit_rays = rays({ first: 0, last: scene.solid, without: kGuess | kSky, near: scene.lit_near }, { LIT: 1 });
  }

  make_probes({ scene, blocks }) {
    const side = scene.probe_side, n = side * side;
    const mips = (t) => ((t.magFilter = LinearFilter), (t.minFilter = LinearMipmapLinearFilter), (t.generateMipmaps = true), t);
    this.lit_probes = scene.probes.map(() => {
      const target = new WebGLRenderTarget(side, side, { type: HalfFloatType, depthBuffer: false });
      mips(target.texture);
      return target;
    });
    this.sky_uniforms = { sky: { value: null }, sky_turn: { value: 0 }, sky_levels: { value: 0 } };
    if (!scene.relit) return;
    const count = n * scene.probes.length, constants = new Uint16Array(4 * count), depths = new Uint16Array(4 * count);
    const shapes = new Uint8Array(16 * count);
    for (let i = 0; i < count; ++i) {
      constants.set(blocks.probe_constant.subarray(3 * i, 3 * i + 3), 4 * i);
      constants[4 * i + 3] = blocks.probe_way[2 * i], depths[4 * i] = blocks.probe_way[2 * i + 1];
      shapes.set(blocks.probe.subarray(15 * i, 15 * i + 15), 16 * i);
    }
    this.probe_uniforms = {
      ...this.sky_uniforms, constants: { value: texture(constants, side, HalfFloatType) }, depths: { value: texture(depths, side, HalfFloatType) },
      shapes: { value: texture(shapes, 4 * side, UnsignedByteType) },
      light: { value: null }, steps: { value: kTransferSteps }, row: { value: 0 }, side: { value: side },
    };
    this.probe_quad = new FullScreenQuad(new RawShaderMaterial({
      glslVersion: GLSL3, uniforms: this.probe_uniforms, depthTest: false, depthWrite: false, blending: NoBlending,
      vertexShader: full_screen, fragmentShader: `precision highp float;\nprecision highp sampler2D;\n${light_glsl}${probe_glsl}`,
    }));
  }

  // map: environment (sky.js); turn in degrees, counter-clockwise seen from above; direct: map for the direct light of surfels.
  set_light(map, turn, direct = map) {
    if (this.map !== map) {
      this.sky_uniforms.sky.value?.dispose();
      this.map = map, this.coefficients = harmonics(map);
      this.sky_uniforms.sky.value = sky_texture(map);
      this.sky_uniforms.sky_levels.value = Math.log2(map.width);
    }
    const radians = (turn * Math.PI) / 180;
    this.sky_uniforms.sky_turn.value = radians;
    const coefficients = turned(this.coefficients, radians);
    this.probe_uniforms.light.value = coefficients.flat();
    this.irradiance = scatter_below(this.blocks, irradiance(this.blocks, this.scene.drawn, cell_light(direct, radians, kCellSide), coefficients));
    this.surfels.set_irradiance(this.irradiance);
    this.probes_fresh = false;
  }

  // Stops that map the mean radiance of diffuse surfels near the centre to middle grey.
  exposure_of_scene() {
    const places = this.surfels.places, { middle, radius } = this.scene, weights = [0.2126, 0.7152, 0.0722];
    let sum = 0, count = 0;
    for (let i = 0; i < this.scene.solid; i += 7) {
      if (Math.hypot(...middle.map((m, c) => places[3 * i + c] - m)) > radius) continue;
      weights.forEach((w, c) => (sum += (w * this.irradiance[3 * i + c] * (this.blocks.albedo[3 * i + c] / 255) ** 2) / Math.PI));
      ++count;
    }
    return sum > 0 ? Math.round(10 * Math.log2((0.18 * count) / sum)) / 10 : 0;
  }

  light_probes() {
    if (this.probes_fresh) return;
    this.lit_probes.forEach((target, i) => {
      this.probe_uniforms.row.value = i * this.scene.probe_side;
      this.renderer.setRenderTarget(target);
      this.probe_quad.render(this.renderer);
    });
    this.probes_fresh = true;
  }

  // Bounding box of a facet in the picture: [left, top, right, bottom] in pixels, null if outside.
  facet_window(camera, facet) {
    const { corners, place } = this.shapes.outline(facet);
    let left = Infinity, top = Infinity, right = -Infinity, bottom = -Infinity;
    for (const v of corners) {
      const [x, y, z] = projected(camera, place.subarray(3 * v, 3 * v + 3));
      if (z < kMirrorNear) return [0, 0, camera.width, camera.height];
      left = Math.min(left, x), right = Math.max(right, x), top = Math.min(top, y), bottom = Math.max(bottom, y);
    }
    left = Math.max(0, Math.floor(left) - 1), top = Math.max(0, Math.floor(top) - 1);
    right = Math.min(camera.width, Math.ceil(right) + 1), bottom = Math.min(camera.height, Math.ceil(bottom) + 1);
    return right > left && bottom > top ? [left, top, right, bottom] : null;
  }

  // Renders the reflections of the largest visible facets, one layer of `pictures` each.
  draw_panes(camera, lit) {
    const { facets, entries } = this.scene.shapes, eye = centre_of(camera), facts = this.uniforms.facet_facts.value;
    const wanted = [];
    facets.forEach((f, i) => {
      if (this.shapes.gone.has(f.entry)) return;
      const sheet = entries[f.entry].role === 'sheet', ahead = f.normal.reduce((s, n, c) => s + n * eye[c], -f.offset) > 0;
      if (entries[f.entry].role === 'coat' || (sheet && !f.clear)) return;
      if (!ahead && (!sheet || !entries[f.entry].closed)) return;  // the other side is a separate facet, or is not visible
      const window = this.facet_window(camera, i);
      if (window) wanted.push({ i, window, outside: ahead ? 1 : -1, area: (window[2] - window[0]) * (window[3] - window[1]) });
    });
    wanted.sort((a, b) => b.area - a.area);
    wanted.length = Math.min(wanted.length, kMostPictures);
    if (wanted.length === 0) return;
    if (!this.pictures || this.pictures.width !== camera.width || this.pictures.height !== camera.height) {
      this.pictures?.dispose();
      this.pictures = new WebGLArrayRenderTarget(camera.width, camera.height, Math.min(kMostPictures, facets.length), {
        type: HalfFloatType, minFilter: NearestFilter, magFilter: NearestFilter, depthBuffer: false,
      });
      this.uniforms.pictures.value = this.pictures.texture;
    }
    wanted.forEach(({ i, outside, window: [left, top, right, bottom] }, layer) => {
      const f = facets[i], behind = mirrored(camera, f.normal, f.offset);
      this.surfels.paint(behind, { paint: lit ? Paint.Returned : Paint.Photographed, lit });
      this.renderer.setRenderTarget(this.pictures, layer);
      this.renderer.clear();
      this.surfels.draw(behind, {
        surface: false, mirrors: true, lit, near_z: kMirrorNear, window: [camera.width - right, top, camera.width - left, bottom],
        plane: [...f.normal.map((n) => outside * n), outside * f.offset + f.at_pane],
      });
      facts[4 * i] = layer;
    });
  }

  // Hides surfels (those with a flag) and known shapes for this reason; replaces the previous set of the reason.
  leave_out(reason, flags, entries) {
    this.left_out[reason] = { flags, entries };
    const all = Object.values(this.left_out);
    this.surfels.leave_out((i) => all.some((some) => some.flags[i]));
    this.shapes.leave_out(new Set(all.flatMap((some) => [...some.entries])));
  }
  // Hides exactly the objects with these ids (a set).
  hide_objects(ids) {
    const entries = this.scene.shapes.entries.flatMap(({ object }, i) => (ids.has(object) ? [i] : []));
    this.leave_out('hidden', this.blocks.part_object.map((id) => ids.has(id)), entries);
  }

  // True for modes that show a surface property only.
  plain(mode) {
    return ['albedo', 'normals', 'roughness', 'depth', 'confidence'].includes(mode);
  }

  // Draws into the canvas, whose size must match the camera. state: {mode, base (photo or relit), exposure, background, gain,
  // panes (false: no mirrored pictures, while the camera moves), clip: [normal, offset] (clip_plane.js), around: {middle, radius}
  // for the range of depth colours}
  draw(camera, state) {
    const { renderer, surfels, uniforms: u } = this, { mode } = state;
    const lit = mode === 'relit' || ((mode === 'open' || mode === 'glass') && state.base === 'relit');
    surfels.clip = this.shapes.uniforms.clip.value = state.clip ?? kNoClip;
    const paint = mode === 'albedo' ? Paint.Albedo : mode === 'confidence' ? Paint.Confidence : lit ? Paint.Matt : Paint.Photographed;
    if (lit) this.light_probes();
    const glass = mode !== 'open' && !this.plain(mode);
    this.shapes.draw(camera);
    for (let i = 0; i < u.facet_facts.value.length; i += 4) u.facet_facts.value[i] = -1;
    if (state.panes !== false && !this.plain(mode)) this.draw_panes(camera, lit);
    const into = (target, what) => {
      const with_materials = { ...what, lit: lit || (this.scene.relit && (mode === 'albedo' || mode === 'roughness')) };
      surfels.paint(camera, { paint, ...with_materials });
      target.setSize(camera.width, camera.height);
      renderer.setRenderTarget(target);
      renderer.clear();
      surfels.draw(camera, with_materials);
    };
    into(this.channels, {});
    if (this.has_glass && glass) into(this.glass, { first: surfels.solid, last: this.scene.drawn, clear: true });

    const stops = 2 ** (lit ? state.exposure : 0), gain = lit ? [stops, stops, stops] : (state.gain ?? [1, 1, 1]);
    set_camera(u, camera);
    u.lit.value = lit, u.panes.value = glass, u.background.value = state.background !== false;
    u.show.value = kShow[mode] ?? 0, u.gain.value = gain;
    const { middle, radius } = state.around ?? this.scene, distance = Math.hypot(...centre_of(camera).map((v, i) => v - middle[i]));
    u.depth_range.value = [Math.max(0, distance - radius), distance + radius];
    const rays = lit ? this.lit_rays : this.rays;
    u.traced.value = !this.plain(mode) && (lit ? state.panes !== false : this.scene.reflects);
    u.reflected.value = rays.target.texture;
    if (u.traced.value) {
      if (lit) surfels.paint(camera, { paint: Paint.Returned, lit });
      rays.draw(renderer, camera);
    }
    renderer.setRenderTarget(null);
    this.composite.render(renderer);
  }

  // z-depth of the surface in a pixel of the last picture; 0 if none.
  depth_at(x, y) {
    const out = new Uint16Array(4), { channels } = this;
    this.renderer.readRenderTargetPixels(channels, Math.floor(x), channels.height - 1 - Math.floor(y), 1, 1, out, undefined, 3);
    const [z, , , alpha] = Array.from(out, DataUtils.fromHalfFloat);
    return alpha > 0.5 ? z / alpha : 0;
  }
}
