// node view_lamps.mjs PAGE.html CAMERA POINTS OUT_DIR: lights a page of `vitrine view` with a lamp as a person would (headless Chromium,
// file://) and prints JSON. CAMERA: index of a photo; POINTS: [[x, y, z], ...] of the scene that it sees. What was saved lies in OUT_DIR.
//   messages   what the console said, errors of scripts, requests for anything but the page itself, data: and blob: URIs
//   lamp       the lamp as it was added;  behind, aside  brightness (0 to 255) of the points with the lamp there;  dragged  the lamp after a
//              drag over the picture;  eye  whether the camera stayed meanwhile;  off, removed  brightness without the lamp
//   again      [mean irradiance of the surfels, that under the saved light.hdr];  address, reopened  lamps in the fragment
import { mkdirSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { open_chromium, saved, software_webgl, visit, watch } from './chromium.mjs';

const file = resolve(process.argv[2]), camera = Number(process.argv[3]), points = JSON.parse(process.argv[4]), out = resolve(process.argv[5]);
mkdirSync(out, { recursive: true });
const address = pathToFileURL(file).href;
const browser = await open_chromium({ args: software_webgl });
const result = { messages: [] };
try {
  const page = await visit(browser, address, result.messages, { width: 640, height: 420 }, out);
  const press = async (id, ...keys) => {
    await page.focus(`#${id}`);
    for (const key of keys) await page.keyboard.press(key);
  };
  const lamp = () => page.evaluate(() => view.state.lamps[0]);
  // Exposure 0, as `vitrine relight` develops it.
  const brightness = () =>
    page.evaluate((index, points) => {
      const k = view.scene.cameras[index];
      view.draw_now(k, { mode: 'relit', exposure: 0, gain: [1, 1, 1] });
      const gl = view.renderer.getContext();
      return points.map((p) => {
        const q = [0, 1, 2].map((i) => k.rotation[3 * i] * p[0] + k.rotation[3 * i + 1] * p[1] + k.rotation[3 * i + 2] * p[2] + k.translation[i]), one = new Uint8Array(4);
        gl.readPixels(Math.floor((k.fx * q[0]) / q[2] + k.cx), k.height - 1 - Math.floor((k.fy * q[1]) / q[2] + k.cy), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, one);
        return one[1];
      });
    }, camera, points);

  await page.click('#add_lamp');
  result.lamp = await lamp();
  await press('sky', 'Home');
  await press('lamp_elevation', 'Home', ...Array(5).fill('PageUp'));  // from below by tenths of the range
  await press('lamp_azimuth', 'Home');
  await press('lamp_power', 'Home', 'PageUp');
  result.placed = await lamp();
  result.behind = await brightness();
  await press('lamp_azimuth', 'PageUp');
  result.aside = await brightness();
  const url = await page.evaluate((index) => {
    view.draw_now(view.scene.cameras[index], { mode: 'relit', exposure: 0, gain: [1, 1, 1] });
    return view.canvas.toDataURL('image/png');
  }, camera);
  writeFileSync(join(out, 'lamp.png'), Buffer.from(url.split(',')[1], 'base64'));
  for (const id of ['save_light', 'save_lamps']) await page.click(`#${id}`);
  await saved(out, 'light.hdr', 'lamps.yaml');
  result.address = await page.evaluate(() => location.hash);

  const eye = () => page.evaluate(() => view.eye.position.toArray()), before = await eye();
  const box = await (await page.$('#picture')).boundingBox(), x = box.x + box.width / 2, y = box.y + box.height / 2;
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 50, y - 25, { steps: 5 });
  await page.mouse.up();
  result.dragged = await lamp();
  result.eye = JSON.stringify(await eye()) === JSON.stringify(before);
  await page.screenshot({ path: join(out, 'page.png') });
  await page.click('#lamp_on');
  result.off = await brightness();
  await page.click('#remove_lamp');
  result.removed = await page.evaluate(() => view.state.lamps.length);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 50, y, { steps: 5 });
  await page.mouse.up();
  result.turned = JSON.stringify(await eye()) !== JSON.stringify(before);

  const again = await browser.newPage();
  watch(again, address, result.messages);
  await again.goto(address + result.address);
  result.reopened = await again.evaluate(() => window.vitrine.then((v) => ((window.view = v), [v.state.lamps[0], v.state.sky])));
  const irradiance = () => again.evaluate(() => [...view.picture.irradiance]);
  const lamps = await irradiance();
  await (await again.$('#hdri')).uploadFile(join(out, 'light.hdr'));
  await again.waitForFunction(() => view.state.light === 'light.hdr');
  await again.evaluate(() => view.set({ lamps: [], sky: 1 }));
  const under_file = await irradiance(), mean = (v) => v.reduce((a, b) => a + b, 0) / v.length;
  result.again = [mean(lamps), mean(under_file)];
} finally {
  await browser.close();
}
console.log(JSON.stringify(result));
