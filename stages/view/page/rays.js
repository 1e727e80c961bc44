// Rays through surfels (mirror_rays.glsl), one a pixel, into a target of their own: what polished things mirror. As photographed they
// run through the reflection layer; under another light through the opaque surfels with what these send on.
import { FloatType, HalfFloatType, NearestFilter, WebGLRenderTarget } from 'three';
import { kWidth, texture, whole_numbers } from './surfels.js';
import { surfel_tree } from './tree.js';

export class Rays {
  // first, last: surfels that rays meet; without: those whose flags have one of its bits; near: where rays begin; make_quad(more
  // uniforms): the pass over the screen. The tree is built when the first ray is sent.
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
