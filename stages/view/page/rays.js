// Traces one ray per pixel through surfels (mirror_rays.glsl) into a separate render target: reflections of polished surfaces.
// Under the light of the photos it uses the reflection layer; under another light the opaque surfels with their outgoing
// radiance.
import { FloatType, HalfFloatType, NearestFilter, WebGLRenderTarget } from 'three';
import { kWidth, texture, whole_numbers } from './surfels.js';
import { surfel_tree } from './tree.js';

export class Rays {
  // first, last: surfels that rays hit; without: excludes surfels with one of these flags; near: start of the rays;
  // make_quad(additional uniforms): the full-screen pass. The tree is built for the first ray.
  constructor(surfels, { first, last, without, near }, make_quad) {
    this.surfels = surfels, this.of = { first, last, without }, this.near = near, this.make_quad = make_quad;
    this.target = new WebGLRenderTarget(1, 1, { type: HalfFloatType, minFilter: NearestFilter, magFilter: NearestFilter, depthBuffer: false });
  }

  uniforms() {
    const { nodes, items } = surfel_tree(this.surfels.by, this.of), t = this.surfels.textures;
    const rows = Math.max(1, Math.ceil(nodes.length / 4 / kWidth)), data = new Float32Array(4 * kWidth * rows), which = whole_numbers(items.length);
    data.set(nodes), which.image.data.set(items), (which.needsUpdate = true);
    return {
      nodes: { value: texture(data, kWidth, FloatType) }, node_count: { value: nodes.length / 8 }, items: { value: which },
      ...Object.fromEntries(['places', 'turns', 'spans', 'constants', 'sh', 'scales'].map((name) => [name, { value: t[name] }])),
      colors: { value: this.surfels.color_target.textures[0] }, sh_count: { value: this.surfels.sh_count }, reflection_near: { value: this.near },
    };
  }

  draw(renderer, { width, height }) {
    this.quad ??= this.make_quad(this.uniforms());
    this.target.setSize(width, height);
    renderer.setRenderTarget(this.target);
    this.quad.render(renderer);
  }
}
