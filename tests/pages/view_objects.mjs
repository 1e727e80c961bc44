// node view_objects.mjs PAGE.html PHOTO PLACES OUT_DIR: hides objects in a page of `vitrine view` and edits one, with the keys of the keyboard
// (headless Chromium, file://), and prints JSON. PLACES: [[x, y], ...] pixels of that photo; in the first is the first object.
// edits.yaml lies in OUT_DIR.
//   messages  what the console said, errors of scripts, requests for anything but the page itself, data: and blob: URIs
//   list      [label of the checkbox: name, role and trust, name of the button] of each row
//   whole, hidden (the first object), linked (the same, by the address), both, shown (all again), deleted (by an edit),
//   deleted_and_hidden, deleted_and_shown   {pixels: colours at PLACES, shapes: entries that are not drawn}
//   focused   the element that has the keyboard when an edit has begun
//   counts    surfels of the edits: of the first object, of the rest of a box around all;  opened  those after the saved file was opened
//   unknown   what is said to a file with an object that is not there
//   mesh      painted pixels of the mesh without WebGL2: whole, without the first object, whole again
import { mkdirSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { open_chromium, painted, saved, software_webgl, viewed, visit, watch, without_webgl } from './chromium.mjs';

const [photo, places] = process.argv.slice(3, 5).map((text) => JSON.parse(text)), out = resolve(process.argv[5]);
mkdirSync(out, { recursive: true });
const address = pathToFileURL(resolve(process.argv[2])).href;
const browser = await open_chromium({ args: software_webgl });
const result = { messages: [] };
const press = async (page, selector, key) => {
  await page.focus(selector);
  await page.keyboard.press(key);
};
const row = (i) => `#objects > .row:nth-child(${i + 1})`, tick = (i) => `${row(i)} input`;
try {
  const page = await visit(browser, address, result.messages, { width: 720, height: 480 }, out);
  const rest = () => page.waitForFunction(() => !view.waiting && view.resting !== false);
  const seen = (page) =>
    page.evaluate(([photo, places]) => {
      const k = view.scene.cameras[photo], gl = view.renderer.getContext(), one = new Uint8Array(4);
      view.draw_now(k, { mode: 'photo' });
      const pixels = places.map(([x, y]) => {
        gl.readPixels(Math.floor((x * k.width) / k.photo[0]), k.height - 1 - Math.floor((y * k.height) / k.photo[1]), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, one);
        return [...one.slice(0, 3)];
      });
      return { pixels, shapes: [...view.picture.shapes.gone] };
    }, [photo, places]);
  await rest();
  result.list = await page.$$eval('#objects > .row', (rows) => rows.map((r) => [...r.querySelector('input').labels[0].innerText.split(/\s*\n\s*/), r.querySelector('button').ariaLabel]));

  result.whole = await seen(page);
  await press(page, tick(0), 'Space');
  await rest();
  await page.screenshot({ path: join(out, 'hidden.png') });
  result.hidden = await seen(page);
  const linked = await browser.newPage();
  watch(linked, address, result.messages);
  await linked.goto(await page.evaluate(() => location.href));
  await viewed(linked);
  result.linked = await seen(linked);
  await linked.close();
  await press(page, tick(1), 'Space');
  result.both = await seen(page);
  for (const i of [0, 1]) await press(page, tick(i), 'Space');
  result.shown = await seen(page);

  // An edit of the object, deleted, and one of the rest, rougher.
  await press(page, `${row(0)} button`, 'Enter');
  result.focused = await page.evaluate(() => document.activeElement.id);
  await press(page, '#edit_delete', 'Space');
  result.deleted = await seen(page);
  await press(page, tick(0), 'Space');
  result.deleted_and_hidden = await seen(page);
  await press(page, tick(0), 'Space');
  result.deleted_and_shown = await seen(page);
  await page.evaluate((name) => {
    view.edits.add('rest', { box: [-1, -1, -1, 1, 1, 1], except: { object: name } });
    view.edits.set('roughness', 0.5);
  }, result.list[0][0]);
  result.counts = await page.evaluate(() => view.edits.counts);
  await press(page, '#save_edits', 'Enter');
  await saved(out, 'edits.yaml');

  await page.evaluate(() => ((view.edits.list = []), view.edits.choose(-1), view.edits.changed()));
  await (await page.$('#open_edits')).uploadFile(join(out, 'edits.yaml'));
  await page.waitForFunction(() => view.edits.counts.length > 0);
  result.opened = await page.evaluate(() => view.edits.counts);
  writeFileSync(join(out, 'unknown.yaml'), 'edits:\n  - select: {object: vase}\n    delete: true\n');
  await (await page.$('#open_edits')).uploadFile(join(out, 'unknown.yaml'));
  await page.waitForFunction(() => !document.getElementById('notice').hidden);
  result.unknown = await page.$eval('#notice', (e) => e.textContent);
} finally {
  await browser.close();
}

await without_webgl(address, result.messages, { width: 720, height: 480 }, async (page) => {
  result.mesh = [await painted(page)];
  for (let k = 0; k < 2; ++k) {
    await press(page, tick(0), 'Space');
    result.mesh.push(await painted(page));
  }
});
console.log(JSON.stringify(result));
