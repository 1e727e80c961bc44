// node splats.mjs FILE.ply CAMERA.json OUT.png: Spark (three.js) in headless Chromium shows Gaussians from a given camera. CAMERA.json:
//   width, height, fx, fy (the axis goes through the middle), world_from_cam: 16 numbers, row by row, camera x right, y down, z ahead
// Prints JSON: splats, how many there are; covered, the share of the pixels that are not black.
import { createReadStream, existsSync, readFileSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { extname, join } from 'node:path';
import { launch } from 'puppeteer-core';

const [file, camera_file, out] = process.argv.slice(2);
const chromium = ['/usr/bin/chromium', '/usr/bin/google-chrome'].find(existsSync);
if (!chromium) {
  console.error('chromium is missing: apt-get install chromium');
  process.exit(7);
}
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

const types = { '.js': 'text/javascript', '.wasm': 'application/wasm' };
const server = createServer((request, response) => {
  const path = decodeURI(request.url.split('?')[0]);
  if (path === '/') return response.writeHead(200, { 'content-type': 'text/html' }).end(page_source);
  const local = path === '/file.ply' ? file : path.startsWith('/node_modules/') && !path.includes('..') ? join('.', path) : '';
  if (!local || !existsSync(local)) return response.writeHead(404).end();
  response.writeHead(200, { 'content-type': types[extname(local)] ?? 'application/octet-stream' });
  createReadStream(local).pipe(response);
});
await new Promise((ready) => server.listen(0, '127.0.0.1', ready));
const browser = await launch({
  executablePath: chromium,
  args: ['--no-sandbox', '--disable-dev-shm-usage', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
  protocolTimeout: 600000,
});
try {
  const page = await browser.newPage();
  page.on('console', (m) => m.type() === 'error' && console.error(m.text()));
  await page.goto(`http://127.0.0.1:${server.address().port}/`);
  await page.waitForFunction('window.result', { timeout: 300000 });
  const result = await page.evaluate('window.result');
  const picture = await page.evaluate('window.picture');
  if (picture) writeFileSync(out, Buffer.from(picture.split(',')[1], 'base64'));
  console.log(JSON.stringify(result));
  process.exitCode = result.error ? 1 : 0;
} finally {
  await browser.close();
  server.close();
}
