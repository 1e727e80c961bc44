// node splats.mjs FILE.ply CAMERA.json OUT.png: Spark (three.js) in headless Chromium shows Gaussians from a given camera. CAMERA.json:
//   width, height, fx, fy (the axis goes through the middle), world_from_cam: 16 numbers, row by row, camera x right, y down, z ahead
// Prints JSON: splats, how many there are; covered, the share of the pixels that are not black.
import { readFileSync } from 'node:fs';
import { draw } from './draw.mjs';

const [file, camera_file, out] = process.argv.slice(2);
const camera = JSON.parse(readFileSync(camera_file, 'utf8'));

const page_source = `<!doctype html><body style="margin:0"><script type="importmap">
{"imports": {"three": "/node_modules/three/build/three.module.js", "three/addons/": "/node_modules/three/examples/jsm/",
             "@sparkjsdev/spark": "/node_modules/@sparkjsdev/spark/dist/spark.module.js"}}</script>
<script type="module">
import * as THREE from 'three';
import { SparkRenderer, SplatMesh } from '@sparkjsdev/spark';
const c = ${JSON.stringify(camera)};
try {
  const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true, antialias: false });
  renderer.setPixelRatio(1);
  renderer.setSize(c.width, c.height);
  renderer.setClearColor(0x000000, 1);
  document.body.appendChild(renderer.domElement);
  const scene = new THREE.Scene();
  scene.add(new SparkRenderer({ renderer }));
  const splats = new SplatMesh({ url: '/file.ply' });
  await splats.initialized;
  scene.add(splats);
  const eye = new THREE.PerspectiveCamera(2 * Math.atan(c.height / 2 / c.fy) * 180 / Math.PI, c.width * c.fy / (c.height * c.fx), 0.01, 100);
  const m = c.world_from_cam;  // three's camera looks along -z, y up
  eye.matrixAutoUpdate = false;
  eye.matrix.set(m[0], -m[1], -m[2], m[3], m[4], -m[5], -m[6], m[7], m[8], -m[9], -m[10], m[11], 0, 0, 0, 1);
  eye.matrix.decompose(eye.position, eye.quaternion, eye.scale);
  eye.updateMatrixWorld(true);
  // Splats are sorted in a worker: the first frames are empty or in another order.
  for (let frame = 0; frame < 12; ++frame) {
    renderer.render(scene, eye);
    await new Promise((ready) => setTimeout(ready, 250));
  }
  renderer.render(scene, eye);
  const gl = renderer.getContext(), pixels = new Uint8Array(c.width * c.height * 4);
  gl.readPixels(0, 0, c.width, c.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  let covered = 0;
  for (let i = 0; i < pixels.length; i += 4) covered += pixels[i] + pixels[i + 1] + pixels[i + 2] > 12;
  window.picture = renderer.domElement.toDataURL('image/png');
  window.result = { splats: splats.packedSplats?.numSplats ?? splats.numSplats, covered: covered / (c.width * c.height) };
} catch (error) {
  window.result = { error: String(error) + (error.stack ?? '') };
}
</script>`;

await draw(page_source, file, out);
