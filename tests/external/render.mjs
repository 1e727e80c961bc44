// node render.mjs FILE.glb OUT.png [AZIMUTH ELEVATION]: three.js in headless Chromium shows the file. Renders it three times: as it is (OUT.png), with
// the transmission of its materials switched off, and with glass in one flat colour, which tells where glass is. Prints JSON:
//   glass     share of the pixels that show glass
//   inside    mean difference (0-255) of the first two pictures where glass is
//   outside   the same where there is none: it should be zero
//   bent      mean difference of the first picture and one in which solid glass is thin, where glass is; 0 where none is solid
//   spread    standard deviation of the first picture's brightness where glass is, and of the second's: what is seen through it
import { draw } from './draw.mjs';

const [file, out, azimuth = '30', elevation = '25'] = process.argv.slice(2);

const page_source = `<!doctype html><body style="margin:0"><script type="importmap">
{"imports": {"three": "/node_modules/three/build/three.module.js", "three/addons/": "/node_modules/three/examples/jsm/"}}</script>
<script type="module">
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { RoomEnvironment } from 'three/addons/environments/RoomEnvironment.js';
const width = 640, height = 480;
const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true });
renderer.setPixelRatio(1);
renderer.setSize(width, height);
document.body.appendChild(renderer.domElement);
const scene = new THREE.Scene();
scene.background = new THREE.Color(0x8090a0);
const pmrem = new THREE.PMREMGenerator(renderer);
scene.environment = pmrem.fromScene(new RoomEnvironment()).texture;
function grab(scene, camera) {
  renderer.render(scene, camera);
  const gl = renderer.getContext(), pixels = new Uint8Array(width * height * 4);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  return pixels;
}
try {
  const gltf = await new GLTFLoader().loadAsync('/file.glb');
  scene.add(gltf.scene);
  const box = new THREE.Box3().setFromObject(gltf.scene), sphere = box.getBoundingSphere(new THREE.Sphere());
  const camera = new THREE.PerspectiveCamera(35, width / height, 0.01 * sphere.radius, 20 * sphere.radius);
  const a = ${Number(azimuth)} * Math.PI / 180, e = ${Number(elevation)} * Math.PI / 180;
  camera.position.set(Math.cos(e) * Math.cos(a), Math.sin(e), -Math.cos(e) * Math.sin(a));
  camera.position.multiplyScalar(2.6 * sphere.radius).add(sphere.center);
  camera.lookAt(sphere.center);
  const glass = [];
  gltf.scene.traverse((o) => { if (o.isMesh && o.material.transmission > 0) glass.push(o); });
  const shown = grab(scene, camera);
  window.picture = renderer.domElement.toDataURL('image/png');
  const solid = glass.filter((o) => o.material.thickness > 0);
  for (const o of solid) o.material.thickness = 0;
  const thin = solid.length > 0 ? grab(scene, camera) : shown;
  for (const o of glass) o.material.transmission = 0, o.material.needsUpdate = true;
  const closed = grab(scene, camera);
  for (const o of glass) o.material = new THREE.MeshBasicMaterial({ color: 0xff00ff, side: THREE.DoubleSide, toneMapped: false });
  const flat = grab(scene, camera);
  const sum = { in: 0, out: 0, bent: 0, n: 0 }, bright = [[0, 0], [0, 0]];
  for (let i = 0; i < shown.length; i += 4) {
    const d = (Math.abs(shown[i] - closed[i]) + Math.abs(shown[i + 1] - closed[i + 1]) + Math.abs(shown[i + 2] - closed[i + 2])) / 3;
    const is_glass = flat[i] === 255 && flat[i + 1] === 0 && flat[i + 2] === 255;
    if (!is_glass) { sum.out += d; continue; }
    sum.in += d, sum.n += 1;
    for (let c = 0; c < 3; ++c) sum.bent += Math.abs(shown[i + c] - thin[i + c]) / 3;
    [shown, closed].forEach((p, k) => { const y = (p[i] + p[i + 1] + p[i + 2]) / 3; bright[k][0] += y, bright[k][1] += y * y; });
  }
  const n = Math.max(1, sum.n), deviation = ([s, q]) => Math.sqrt(Math.max(0, q / n - (s / n) ** 2));
  window.result = { glass: sum.n / (width * height), inside: sum.in / n, outside: sum.out / (width * height - sum.n), bent: sum.bent / n,
                    spread: bright.map(deviation), meshes: gltf.scene.children.length };
} catch (error) {
  window.result = { error: String(error) };
}
</script>`;

await draw(page_source, file, out);
