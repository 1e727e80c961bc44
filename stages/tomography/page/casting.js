// WebGL2 that draws the volume by ray casting (casting.glsl): a 3D texture of half floats, a texture of the transfer function, and
// a coarse texture of the blocks that may be seen, so that rays pass the others at once.
import source from './casting.glsl';

const kBlock = 8;  // voxels along an edge of a block, as in casting.glsl
const kTable = 2048;  // entries of the transfer function
const kVertex = '#version 300 es\nvoid main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1); }';
const kGround = [20, 21, 24];

const float = new Float32Array(1), bits = new Uint32Array(float.buffer);
// Half float of a number from 0 to 1, rounded to the nearest.
function half(value) {
  float[0] = value;
  const exponent = (bits[0] >>> 23) - 112;
  if (exponent <= 0) return Math.round(value * 2 ** 24);  // subnormal
  return (exponent << 10) + (((bits[0] & 0x7fffff) + 0x1000) >>> 13);
}

// Lowest and highest step in each block, and one voxel around it for interpolation.
function block_ranges({ size, values, strides }) {
  const count = size.map((n) => Math.ceil(n / kBlock)), low = new Uint16Array(count[0] * count[1] * count[2]).fill(65535), high = new Uint16Array(low.length);
  const spans = size.map((n, c) => Array.from({ length: n }, (_, i) => [Math.max(0, Math.floor((i - 1) / kBlock)), Math.min(count[c] - 1, Math.floor((i + 1) / kBlock))]));
  for (let z = 0, i = 0; z < size[2]; ++z)
    for (let y = 0; y < size[1]; ++y)
      for (let x = 0; x < size[0]; ++x, ++i) {
        const v = values[i], [x0, x1] = spans[0][x], [y0, y1] = spans[1][y], [z0, z1] = spans[2][z];
        for (let bz = z0; bz <= z1; ++bz)
          for (let by = y0; by <= y1; ++by)
            for (let bx = x0; bx <= x1; ++bx) {
              const b = (bz * count[1] + by) * count[0] + bx;
              if (v < low[b]) low[b] = v;
              if (v > high[b]) high[b] = v;
            }
      }
  return { count, low, high };
}

export class Casting {
  // Throws an error with one sentence if this browser cannot draw the volume.
  constructor(canvas, volume) {
    this.canvas = canvas, this.volume = volume;
    const gl = (this.gl = canvas.getContext('webgl2', { alpha: false, antialias: false, preserveDrawingBuffer: true }));
    if (!gl) throw new Error('this browser has no WebGL2');
    const most = gl.getParameter(gl.MAX_3D_TEXTURE_SIZE);
    if (Math.max(...volume.size) > most) throw new Error(`this browser draws volumes of at most ${most} voxels along an axis`);
    this.program = this.link();
    this.uniforms = new Map();
    this.upload();
    this.ranges = block_ranges(volume);
    this.transfer_texture = this.texture(2, gl.TEXTURE_2D, gl.LINEAR);
    this.blocks_texture = this.texture(1, gl.TEXTURE_3D, gl.NEAREST);
    this.vertices = gl.createVertexArray();
  }
  link() {
    const { gl } = this, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, kVertex], [gl.FRAGMENT_SHADER, source]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) throw new Error(gl.getShaderInfoLog(shader));
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) throw new Error(gl.getProgramInfoLog(program));
    return program;
  }
  texture(unit, target, filter) {
    const { gl } = this, texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(target, texture);
    for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T, gl.TEXTURE_WRAP_R]) gl.texParameteri(target, wrap, gl.CLAMP_TO_EDGE);
    for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(target, side, filter);
    return texture;
  }
  // Layer by layer, so that no second copy of the volume is made.
  upload() {
    const { gl, volume } = this, [w, h, d] = volume.size, layer = new Uint16Array(w * h);
    const halves = Uint16Array.from({ length: volume.steps + 1 }, (_, q) => half(q / volume.steps));
    this.volume_texture = this.texture(0, gl.TEXTURE_3D, gl.LINEAR);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texStorage3D(gl.TEXTURE_3D, 1, gl.R16F, w, h, d);
    for (let z = 0; z < d; ++z) {
      for (let i = 0, from = z * w * h; i < layer.length; ++i) layer[i] = halves[volume.values[from + i]];
      gl.texSubImage3D(gl.TEXTURE_3D, 0, 0, 0, z, w, h, 1, gl.RED, gl.HALF_FLOAT, layer);
    }
  }

  set_transfer(transfer) {
    const { gl, volume, ranges } = this, { colors, opacities } = transfer.table(kTable);
    const rows = new Uint16Array(8 * kTable);
    for (let i = 0; i < kTable; ++i) {
      for (let c = 0; c < 4; ++c) rows[4 * i + c] = half(colors[4 * i + c] / 255);
      rows[4 * (kTable + i)] = half(opacities[i]);
    }
    gl.activeTexture(gl.TEXTURE2);
    gl.bindTexture(gl.TEXTURE_2D, this.transfer_texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA16F, kTable, 2, 0, gl.RGBA, gl.HALF_FLOAT, rows);
    // Number of entries up to each that can be seen: a block is empty if none lies in its range.
    const until = new Uint32Array(kTable + 1);
    opacities.forEach((v, i) => (until[i + 1] = until[i] + (v > 0)));
    const entry = (step, round) => round((step / volume.steps) * (kTable - 1));
    const seen = Uint8Array.from(ranges.low, (low, b) => (until[entry(ranges.high[b], Math.ceil) + 1] > until[entry(low, Math.floor)] ? 255 : 0));
    this.blocks_seen = seen.reduce((sum, v) => sum + (v > 0), 0) / seen.length;
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_3D, this.blocks_texture);
    gl.texImage3D(gl.TEXTURE_3D, 0, gl.R8, ...ranges.count, 0, gl.RED, gl.UNSIGNED_BYTE, seen);
    this.lit = transfer.lit;
  }

  // A picture on the canvas. what: {camera: of orbit.js, cut: [normal, offset], grey: densities that are black and white on the cut, coarse:
  // longer steps, for pictures that move}.
  draw(what, width, height) {
    const { gl, canvas } = this;
    if (canvas.width !== width || canvas.height !== height) canvas.width = width, canvas.height = height;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    this.draw_rows(what, width, height, 0, height);
  }
  // The same in bands, so that none takes long: begin(), band() for all rows, show(). The canvas keeps its picture until show().
  begin(width, height) {
    const { gl } = this;
    this.frame ??= gl.createFramebuffer(), this.frame_texture ??= this.texture(3, gl.TEXTURE_2D, gl.NEAREST);
    gl.activeTexture(gl.TEXTURE3);
    gl.bindTexture(gl.TEXTURE_2D, this.frame_texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, width, height, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.frame_texture, 0);
    this.frame_size = [width, height];
  }
  band(what, row, rows) {
    this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, this.frame);
    this.draw_rows(what, ...this.frame_size, row, rows);
  }
  show() {
    const { gl, canvas } = this, [width, height] = this.frame_size;
    canvas.width = width, canvas.height = height;
    gl.disable(gl.SCISSOR_TEST);
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, this.frame);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
    gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }
  // Returns when they are drawn.
  draw_rows({ camera, cut, grey, coarse }, width, height, row, rows) {
    const { gl, volume } = this;
    gl.viewport(0, 0, width, height);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(0, row, width, rows);
    gl.useProgram(this.program);
    gl.bindVertexArray(this.vertices);
    const at = (name) => {
      if (!this.uniforms.has(name)) this.uniforms.set(name, gl.getUniformLocation(this.program, name));
      return this.uniforms.get(name);
    };
    const textures = { volume: [0, gl.TEXTURE_3D, this.volume_texture], blocks: [1, gl.TEXTURE_3D, this.blocks_texture], transfer: [2, gl.TEXTURE_2D, this.transfer_texture] };
    for (const [name, [unit, target, texture]] of Object.entries(textures)) {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(target, texture);
      gl.uniform1i(at(name), unit);
    }
    const threes = { low: volume.origin, high: volume.last, end: volume.end, ...camera, ground: kGround.map((v) => v / 255) };
    for (const name of ['low', 'high', 'end', 'eye', 'ahead', 'right', 'up', 'ground']) gl.uniform3fv(at(name), threes[name]);
    gl.uniform1f(at('radius'), volume.radius ?? -1);
    gl.uniform1f(at('cell'), volume.cell);
    gl.uniform1f(at('jump'), volume.cell * (coarse ? 1.2 : 0.5));
    gl.uniform1f(at('layer'), volume.diagonal / 100);
    gl.uniform4fv(at('cut'), cut);
    gl.uniform1i(at('lit'), this.lit ? 1 : 0);
    gl.uniform2fv(at('grey'), grey.map((v) => (v - volume.low) / (volume.high - volume.low || 1)));
    gl.uniform2f(at('size'), width, height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.readPixels(0, row, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));  // waits for it
  }
}
