// node view_edits.mjs PAGE.html POINT BOX MARKS OUT_DIR: makes edits in a page of `vitrine view` by clicks and keys (headless Chromium,
// file://) and prints JSON. POINT: on the component that is clicked, seen from the first view; BOX: six numbers; MARKS: [[photo, centre x,
// y, half side], ...] in pixels of photos, the first drawn as a rectangle, the second as a polygon. edits.yaml lies in OUT_DIR.
//   messages   what the console said, errors of scripts, requests for anything but the page itself, data: and blob: URIs
//   edits      the list of the page;  counts  surfels that each finds, before the last one deletes;  refused  what is said to an edit that finds nothing
//   held       whether a tool is there after Escape;  nothing    surfels that an edit finds whose selection is not chosen yet
//   pixels     colours of the middle of MARKS in the picture of the first photo: as it was, deleted, undone
//   tinted     mean brightness of the page's picture before and after a tint by a tenth
//   opened     counts of another visit that opened the saved file;  broken  what is said to a file that is none
import { mkdirSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { open_chromium, saved, software_webgl, visit, watch } from './chromium.mjs';

const [point, box, marks] = process.argv.slice(3, 6).map((text) => JSON.parse(text)), out = resolve(process.argv[6]);
mkdirSync(out, { recursive: true });
const address = pathToFileURL(resolve(process.argv[2])).href;
const browser = await open_chromium({ args: software_webgl });
const result = { messages: [] };
try {
  const page = await visit(browser, address, result.messages, { width: 720, height: 480 }, out);
  const rest = () => page.waitForFunction(() => !view.waiting && view.resting !== false);
  await rest();
  const add = async (kind, name) => {
    await page.click('#add_edit');
    await page.select('#edit_by', kind);
    await page.click('#edit_name', { clickCount: 3 });
    await page.keyboard.type(name);
    await page.keyboard.press('Tab');
  };
  const notice = () => page.$eval('#notice', (e) => e.textContent);
  const brightness = () =>
    page.evaluate(() => {
      view.draw_now(view.scene.cameras[0], { mode: 'photo' });
      const { width, height } = view.scene.cameras[0], gl = view.renderer.getContext(), all = new Uint8Array(4 * width * height);
      gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, all);
      return all.reduce((a, b) => a + b, 0) / all.length;
    });

  // A class, rougher.
  await add('class', 'rougher: "all" #1');
  await page.select('#edit_class', 'specular');
  await page.click('#edit_roughness_on');

  // A component, by a click on it.
  await add('component', 'no');
  const [x, y] = await page.evaluate((p) => {
    const k = view.drawn, b = view.canvas.getBoundingClientRect();
    const q = [0, 1, 2].map((i) => k.rotation[3 * i] * p[0] + k.rotation[3 * i + 1] * p[1] + k.rotation[3 * i + 2] * p[2] + k.translation[i]);
    return [b.left + (((k.fx * q[0]) / q[2] + k.cx) * b.width) / k.width, b.top + (((k.fy * q[1]) / q[2] + k.cy) * b.height) / k.height];
  }, point);
  await page.mouse.click(x, y);
  await page.click('#edit_k_s_on');

  // A box, by its fields, tinted.
  await add('box', 'dark');
  for (let i = 0; i < 6; ++i) {
    await page.click(`#box_${i}`, { clickCount: 3 });
    await page.keyboard.type(String(box[i]));
    await page.keyboard.press('Tab');
  }
  const before = await brightness();
  await page.click('#edit_tint_on');
  await page.$eval('#edit_tint', (e) => ((e.value = '#595959'), e.dispatchEvent(new Event('input', { bubbles: true }))));
  result.tinted = [before, await brightness()];
  await rest();
  await page.screenshot({ path: join(out, 'box.png') });

  // Marks in two photos, deleted.
  const pixel = (index) =>
    page.evaluate(([photo, px, py]) => {
      const k = view.scene.cameras[photo], gl = view.renderer.getContext(), one = new Uint8Array(4);
      view.draw_now(k, { mode: 'photo' });
      gl.readPixels(Math.floor((px * k.width) / k.photo[0]), k.height - 1 - Math.floor((py * k.height) / k.photo[1]), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, one);
      return [...one.slice(0, 3)];
    }, marks[index]);
  await add('marks', 'gone');
  await page.click('#mark_box');
  result.no_photo = await notice();
  for (let k = 0; k < 2; ++k) {
    const [photo, px, py, half] = marks[k];
    await page.click(`#photos button:nth-child(${photo + 1})`);
    await rest();
    const at = await page.evaluate((photo) => {
      const b = view.canvas.getBoundingClientRect(), [w, h] = view.scene.cameras[photo].photo;
      return { left: b.left, top: b.top, sx: b.width / w, sy: b.height / h };
    }, photo);
    const screen = (dx, dy) => [at.left + (px + dx * half) * at.sx, at.top + (py + dy * half) * at.sy];
    if (k === 0) {
      await page.click('#mark_box');
      await page.mouse.move(...screen(-1, -1));
      await page.mouse.down();
      await page.mouse.move(...screen(1, 1), { steps: 4 });
      await page.mouse.up();
      await page.click('#mark_polygon');  // drawn in the photo where one stands then
    } else {
      for (const [dx, dy] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) await page.mouse.click(...screen(dx, dy));
      await page.keyboard.press('Enter');
    }
    await rest();
    await page.screenshot({ path: join(out, `marks_${k}.png`) });
  }
  await page.keyboard.press('Escape');
  result.held = await page.evaluate(() => view.hand.tool !== null);
  result.pixels = [await pixel(0)];
  await page.click('#edit_delete');
  result.counts = await page.evaluate(() => view.edits.counts);
  result.pixels.push(await pixel(0));
  await page.click('#save_edits');
  await saved(out, 'edits.yaml');
  result.edits = await page.evaluate(() => view.edits.list);

  await page.click('#add_edit');
  await page.click('#edit_delete');
  result.nothing = await page.evaluate(() => view.edits.counts.at(-1));
  await page.click('#remove_edit');

  // An edit that finds nothing is not saved; removing one undoes it.
  await add('box', 'empty');
  for (let i = 0; i < 6; ++i) {
    await page.click(`#box_${i}`, { clickCount: 3 });
    await page.keyboard.type(String(i < 3 ? 90 : 91));
    await page.keyboard.press('Tab');
  }
  await page.click('#edit_delete');
  await page.click('#save_edits');
  result.refused = await notice();
  await page.click('#remove_edit');
  await page.click('#edits .row:nth-child(4) button');
  await page.click('#remove_edit');
  result.pixels.push(await pixel(0));

  const again = await browser.newPage();
  watch(again, address, result.messages);
  await again.goto(address);
  await again.evaluate(() => window.vitrine.then((v) => (window.view = v)).then(() => 1));
  await (await again.$('#open_edits')).uploadFile(join(out, 'edits.yaml'));
  await again.waitForFunction(() => view.edits.counts.length > 0);
  result.opened = await again.evaluate(() => view.edits.counts);
  writeFileSync(join(out, 'broken.yaml'), 'edits:\n  - select: {classs: specular}\n    delete: true\n');
  await (await again.$('#open_edits')).uploadFile(join(out, 'broken.yaml'));
  await again.waitForFunction(() => !document.getElementById('notice').hidden);
  result.broken = await again.$eval('#notice', (e) => e.textContent);
} finally {
  await browser.close();
}
console.log(JSON.stringify(result));
