// Renders known shapes as triangles: visible shape, normal and z-depth per pixel (shape.glsl).
import {
  BufferAttribute, BufferGeometry, Camera, DoubleSide, FloatType, GLSL3, Mesh, NearestFilter, NoBlending, RawShaderMaterial, Scene, WebGLRenderTarget,
} from 'three';
import { kNoClip } from './clip_plane.js';
import { camera_uniforms, set_camera } from './cameras.js';
import camera_glsl from './camera.glsl';
import shape_glsl from './shape.glsl';
import { DataUtils } from 'three';

const kCurved = 65535;
const Side = { Facing: 0, Near: 1, Far: 2 };

export class Shapes {
  constructor(renderer, { scene, blocks }) {
    this.renderer = renderer, this.blocks = blocks;
    const { entries, facets } = (this.table = scene.shapes);
    this.uniforms = { ...camera_uniforms(), depths: { value: [0.01, 100] }, side: { value: 0 }, clip: { value: kNoClip } };
    const material = new RawShaderMaterial({
      glslVersion: GLSL3, uniforms: this.uniforms, side: DoubleSide, blending: NoBlending,
      vertexShader: `#define VERTEX\nprecision highp float;\n${camera_glsl}${shape_glsl}`,
      fragmentShader: `precision highp float;\n${camera_glsl}${shape_glsl}`,
    });
    const part = blocks.shape_part, n = part.length / 2, kind = new Float32Array(2 * n);
    for (let v = 0; v < n; ++v) {
      kind[2 * v] = entries[part[2 * v + 1]].closed ? 1 : 0;
      kind[2 * v + 1] = part[2 * v] === kCurved || facets[part[2 * v]].clear ? 1 : 0;
    }
    const attributes = {
      position: new BufferAttribute(blocks.shape_place, 3),
      normal: new BufferAttribute(Float32Array.from(blocks.shape_normal, DataUtils.fromHalfFloat), 3),
      part: new BufferAttribute(Float32Array.from(part), 2),
      kind: new BufferAttribute(kind, 2),
    };
    const stage = (wanted) => {
      const geometry = new BufferGeometry(), mesh = new Mesh(geometry, material);
      for (const [name, a] of Object.entries(attributes)) geometry.setAttribute(name, a);
      mesh.frustumCulled = false;
      return { wanted, geometry, scene: new Scene().add(mesh) };
    };
    this.sheets = stage(true), this.opaque = stage(false);
    this.leave_out(new Set());
    this.nobody = new Camera();
    const target = () => new WebGLRenderTarget(1, 1, { type: FloatType, minFilter: NearestFilter, magFilter: NearestFilter });
    this.targets = { opaque: target(), near: target(), far: target() };
  }

  // Hides entries.
  leave_out(gone) {
    const { shape_part: part, shape_corner } = this.blocks;
    this.gone = gone;
    for (const stage of [this.sheets, this.opaque]) {
      const corners = [];
      for (let i = 0; i < shape_corner.length; i += 3) {
        const face = shape_corner.subarray(i, i + 3), entry = part[2 * face[0] + 1];
        if ((this.table.entries[entry].role === 'sheet') === stage.wanted && !gone.has(entry)) corners.push(...face);
      }
      stage.geometry.setIndex(corners);
      stage.empty = corners.length === 0;
    }
  }

  // Vertices of a facet: {corners, place}.
  outline(facet) {
    const { shape_part: part, shape_place: place } = this.blocks, corners = [];
    for (let v = 0; 2 * v < part.length; ++v) if (part[2 * v] === facet) corners.push(v);
    return { corners, place };
  }

  draw(camera) {
    set_camera(this.uniforms, camera);
    for (const [name, stage, side] of [['opaque', this.opaque, Side.Facing], ['near', this.sheets, Side.Near], ['far', this.sheets, Side.Far]]) {
      const target = this.targets[name];
      target.setSize(camera.width, camera.height);
      this.uniforms.side.value = side;
      this.renderer.setRenderTarget(target);
      this.renderer.clear();
      if (!stage.empty) this.renderer.render(stage.scene, this.nobody);
    }
  }
}
