// node view_page.mjs PAGE.html SKY.exr NO_SKY OUT_DIR: uses a page of `vitrine view` as a person would, from file:// in headless
// Chromium with SwiftShader, and prints JSON; pictures and what the page saved lie in OUT_DIR.
//   messages     what the console said, errors of scripts, requests for anything but the page itself, data: and blob: URIs
//   first_ms     until the first picture
//   keys         [eye, eye after the left arrow, after plus, after r]
//   dragged      eye after a drag with the mouse;  wheel  after a turn of the wheel
//   photo        [place of the slider's border before and after it was dragged, whether the photo is shown]
//   refused      what is said to a file that is no HDRI;  light  the one in use after SKY was chosen
//   glass        how far pixels differ with and without the glass, mean of 255;  furnace  [mean, deviation] of a ball under white light
//   turned       greatest difference between the light turned by 90 degrees and its map shifted by a quarter
//   scale_points the option of vitrine export after a true length was typed
//   distance     what a distance of two clicks is told as;  address  the fragment;  reopened  its eye after another visit
import { mkdirSync, readdirSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { open_chromium, saved, software_webgl, visit, watch, without_webgl } from './chromium.mjs';

const [file, sky, no_sky, out] = process.argv.slice(2).map((p) => resolve(p));
mkdirSync(out, { recursive: true });
const address = pathToFileURL(file).href;
const browser = await open_chromium({ args: software_webgl });
const result = { messages: [] };
try {
  const began = Date.now();
  const page = await visit(browser, address, result.messages, { width: 360, height: 280 }, out);
  result.first_ms = Date.now() - began;
  const rest = () => page.waitForFunction(() => !view.waiting && view.resting !== false);
  const eye = () => page.evaluate(() => view.eye.position.toArray());
  const middle = await page.evaluate(() => {
    const b = document.getElementById('picture').getBoundingClientRect();
    return [b.left + b.width / 2, b.top + b.height / 2];
  });
  await rest();
  await page.screenshot({ path: join(out, 'page.png') });

  // Pictures of the photo that was held out, as the programs make them.
  const picture = async (name, how) => {
    const url = await page.evaluate((how) => {
      const camera = view.scene.cameras.find((c) => c.heldout);
      view.draw_now(camera, { gain: camera.gain, base: 'photo', ...how });
      return view.canvas.toDataURL('image/png');
    }, how);
    writeFileSync(join(out, name), Buffer.from(url.split(',')[1], 'base64'));
  };
  await picture('photo.png', { mode: 'photo' });
  for (const mode of ['albedo', 'normals', 'roughness', 'depth', 'glass']) await picture(`${mode}.png`, { mode });

  // Keys, mouse, wheel.
  await page.focus('#picture');
  result.keys = [await eye()];
  for (const key of ['ArrowLeft', '+', 'r']) {
    await page.keyboard.press(key);
    result.keys.push(await eye());
  }
  await page.mouse.move(...middle);
  await page.mouse.down();
  await page.mouse.move(middle[0] + 40, middle[1] + 10, { steps: 3 });
  await page.mouse.up();
  result.dragged = await eye();
  await page.mouse.wheel({ deltaY: -240 });
  await rest();
  result.wheel = await eye();

  // Light from files.
  const input = await page.$('#hdri');
  await input.uploadFile(no_sky);
  await page.waitForFunction(() => !document.getElementById('notice').hidden);
  result.refused = await page.$eval('#notice', (e) => e.textContent);
  await input.uploadFile(sky);
  await page.waitForFunction(() => view.state.mode === 'relit');
  result.light = await page.evaluate(() => view.state.light);
  await picture('relit.png', { mode: 'relit', exposure: 0 });
  result.turned = await page.evaluate(() => {
    const camera = view.scene.cameras[0], map = view.skies[view.state.light], { width, height, data } = map;
    const pixels = () => {
      view.draw_now(camera, { mode: 'relit', exposure: 0 });
      const gl = view.renderer.getContext(), out = new Uint8Array(4 * camera.width * camera.height);
      gl.readPixels(0, 0, camera.width, camera.height, gl.RGBA, gl.UNSIGNED_BYTE, out);
      return out;
    };
    view.set({ turn: 90 }, false);
    const turned = pixels(), shifted = new Float32Array(data.length);
    for (let y = 0; y < height; ++y)
      for (let x = 0; x < width; ++x)
        for (let c = 0; c < 3; ++c) shifted[3 * (y * width + ((x + (3 * width) / 4) % width)) + c] = data[3 * (y * width + x) + c];
    view.skies.shifted = { ...map, data: shifted };
    view.set({ light: 'shifted', turn: 0 }, false);
    const other = pixels();
    return turned.reduce((most, v, i) => Math.max(most, Math.abs(v - other[i])), 0);
  });
  result.furnace = await page.evaluate(() => {
    view.skies.white = { name: 'white', width: 16, height: 8, data: new Float32Array(3 * 16 * 8).fill(1) };
    view.set({ light: 'white', turn: 0 }, false);
    const values = [...view.picture.irradiance.slice(0, 3 * view.scene.solid)].map((v) => v / Math.PI), mean = values.reduce((a, b) => a + b, 0) / values.length;
    return [mean, Math.sqrt(values.reduce((a, b) => a + (b - mean) ** 2, 0) / values.length)];
  });
  result.glass = await page.evaluate(() => {
    const camera = view.scene.cameras[0];
    const pixels = (mode) => {
      view.draw_now(camera, { mode, base: 'photo' });
      const gl = view.renderer.getContext(), out = new Uint8Array(4 * camera.width * camera.height);
      gl.readPixels(0, 0, camera.width, camera.height, gl.RGBA, gl.UNSIGNED_BYTE, out);
      return out;
    };
    const a = pixels('photo'), b = pixels('open');
    return a.reduce((sum, v, i) => sum + Math.abs(v - b[i]), 0) / a.length;
  });

  // A distance, a view, a path, a picture.
  await page.evaluate(() => view.set({ mode: 'photo' }));
  await page.click('#reset');
  await rest();
  await page.click('#measure');
  await page.mouse.click(...middle);
  await page.mouse.click(middle[0] + 20, middle[1]);
  result.distance = await page.$eval('#distance', (e) => e.value);
  await page.type('#true_length', '24 cm');
  result.scale_points = await page.$eval('#scale_points', (e) => e.value);
  for (const id of ['save_view', 'add_path', 'add_path', 'save_path', 'screenshot']) await page.click(`#${id}`);
  await saved(out, 'view.json', 'path.json', 'view.png');
  result.saved = readdirSync(out);

  // A photo and its slider.
  await page.click('#photos button:nth-child(2)');
  await rest();
  const split = () => page.$eval('#photo', (e) => e.style.getPropertyValue('--split'));
  result.photo = [await split()];
  const box = await (await page.$('#split')).boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.8 * box.width, box.y + box.height / 2, { steps: 4 });
  await page.mouse.up();
  result.photo.push(await split(), await page.$eval('#photo', (e) => !e.hidden && e.naturalWidth > 0));
  await page.screenshot({ path: join(out, 'compared.png') });
  await page.click('#reset');
  await rest();
  result.address = await page.evaluate(() => location.hash);
  const again = await browser.newPage();
  watch(again, address, result.messages);
  await again.goto(address + result.address.replace(/eye=[^&]*/, 'eye=0.5,0.6,0.7'));
  result.reopened = await again.evaluate(() => window.vitrine.then((v) => v.eye.position.toArray()));
} finally {
  await browser.close();
}

// Without WebGL: the mesh alone, and a sentence.
await without_webgl(address, result.messages, { width: 360, height: 280 }, async (page) => {
  result.plain = await page.evaluate(() => window.vitrine.then((v) => [v.mesh_alone, document.getElementById('notice').textContent]));
  await page.screenshot({ path: join(out, 'plain.png') });
});
console.log(JSON.stringify(result));
