// Reads the data in the page: scene (JSON), photos (data: URIs), blocks (arrays; stages/view/page_blocks.h).
import { inflated } from '../../page/inflated.js';

const kFormat = 2;  // version of the blocks, as in view.cpp
const kinds = { f32: Float32Array, f16: Uint16Array, u8: Uint8Array, u16: Uint16Array, u32: Uint32Array };

// Bytes are stored plane by plane.
function typed(buffer, { type, width, offset, count }) {
  const Kind = kinds[type], size = Kind.BYTES_PER_ELEMENT, stride = size * width;
  const out = new Uint8Array(count * size), items = stride ? out.length / stride : 0;
  for (let plane = 0; plane < stride; ++plane)
    for (let i = 0, from = offset + plane * items; i < items; ++i) out[i * stride + plane] = buffer[from + i];
  return new Kind(out.buffer);
}

// Returns { scene, photos, blocks: name -> typed array }. Throws if the page has no scene, one of another version, or a damaged
// one.
export async function read_page(from = document) {
  const text = (id) => from.querySelector(`script[type="application/json"]#${id}, script#${id}`)?.textContent;
  if (!text('scene') || !text('blocks')) throw new Error('it holds no scene: `vitrine view` puts one in, into view.html');
  let scene, photos, blocks;
  try {
    scene = JSON.parse(text('scene'));
    if (scene.format === kFormat) {
      const buffer = await inflated(text('blocks'));
      blocks = Object.fromEntries(scene.blocks.map((b) => [b.name, typed(buffer, b)]));
      photos = JSON.parse(text('photos'));
    }
  } catch (e) {
    throw new Error('its data are damaged', { cause: e });
  }
  if (scene.format !== kFormat) throw new Error(`its scene is of format ${scene.format}, and this page reads format ${kFormat}: make it with the same vitrine`);
  return { scene, photos, blocks };
}

// Decodes positions: differences of contracted coordinates (stages/view/page_surfels.cpp) -> [3 n] in the scene's frame.
export function surfel_places(words) {
  const out = new Float32Array(words.length), before = [0, 0, 0];
  for (let i = 0; i < words.length; ++i) {
    const at = (before[i % 3] = (before[i % 3] + words[i]) & 65535), y = (at - 32767.5) / 32767.5;
    out[i] = y / Math.max(1 - Math.abs(y), 1e-6);
  }
  return out;
}

// Decodes quaternions: x, y, z in 16 bits, w >= 0 -> [4 n] w x y z.
export function surfel_turns(words) {
  const out = new Float32Array((words.length / 3) * 4);
  for (let i = 0; 3 * i < words.length; ++i) {
    const [x, y, z] = [0, 1, 2].map((c) => (words[3 * i + c] - 32768) / 32760);
    out.set([Math.sqrt(Math.max(0, 1 - x * x - y * y - z * z)), x, y, z], 4 * i);
  }
  return out;
}

// Decodes constant colours: square roots of green, red minus green, blue minus green (page_surfels.cpp) -> [3 n] linear.
export function surfel_constants(words) {
  const out = new Float32Array(words.length), signed = (v) => (v << 16) >> 16, color = (root) => (root * Math.abs(root)) / 1023 ** 2;
  for (let i = 0; i < words.length; i += 3) {
    const green = signed(words[i]);
    out[i] = color(signed(words[i + 1] + green)), out[i + 1] = color(green), out[i + 2] = color(signed(words[i + 2] + green));
  }
  return out;
}
