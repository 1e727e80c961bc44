// node view_tools.mjs PAGE.html SKY NO_SKY OUT_DIR: clips, annotates, asks for the confidence and opens a second run on a page of
// `vitrine view`, with real input events in headless Chromium, and prints JSON; pictures and what the page saved lie in OUT_DIR.
//   messages    what the console said, errors of scripts, requests
//   clip        x of the surface in the middle of the picture: before; across x; flipped; beyond: pixels with a surface when the
//               slider is at its end;  off: greatest difference of a pixel to before;  mesh: painted pixels of the mesh alone, cut and whole
//   confidence  seen: the block;  legend: [hidden in the mode, hidden in others];  off_scale: how far the pixel in the middle is from
//               the colours of the scale, of 255
//   note        place; off_px: of its mark to the click; markup: elements that its text made; deleted: how many are left;
//               opened: [text, place] of the saved file; refused: what is said to a file that is none;
//               from_behind: [text, class] of another visit to the address, from the other side
//   two         refused: what is said to a page that is none; differ: greatest difference of a pixel to the same page; bright: values
//               above 30 on the right; camera: of the
//               right camera to that of the photo in a page whose frame was turned, enlarged and moved; told; ended: canvases then
import { mkdirSync, readFileSync, existsSync, rmSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { open_chromium, painted, software_webgl, watch } from './chromium.mjs';

const [file, , , out] = process.argv.slice(2).map((p) => resolve(p));
mkdirSync(out, { recursive: true });
const address = pathToFileURL(file).href, in_out = (name) => join(out, name);
const browser = await open_chromium({ args: software_webgl });
const result = { messages: [], clip: {}, confidence: {}, note: {}, two: {} };
const opened = async (page, hash = '') => {
  watch(page, address, result.messages);
  await page.setViewport({ width: 720, height: 240 });
  await page.goto(address + hash);
  await page.evaluate(() => window.vitrine.then((v) => (window.view = v)).then(() => 1));
};
try {
  const page = await browser.newPage();
  const session = await browser.target().createCDPSession();
  await session.send('Browser.setDownloadBehavior', { behavior: 'allow', downloadPath: out });
  await opened(page);
  const rest = () => page.waitForFunction(() => !view.waiting && view.resting !== false);
  await rest();
  await page.evaluate(() => {
    window.pixels = (renderer) => {
      const gl = renderer.getContext(), { width, height } = gl.canvas, all = new Uint8Array(4 * width * height);
      gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, all);
      return all;
    };
    window.differ = (a, b) => a.reduce((most, v, i) => Math.max(most, Math.abs(v - b[i])), a.length === b.length ? 0 : 255);
    // [x] of the surface in the middle of the picture; null without one.
    window.middle_x = () => {
      const { width, height } = view.drawn, z = view.picture.depth_at(width / 2, height / 2);
      const { rotation: r, translation: t, fx, fy, cx, cy } = view.drawn;
      if (!(z > 0)) return null;
      const p = [((width / 2 - cx) / fx) * z, ((height / 2 - cy) / fy) * z, z].map((v, i) => v - t[i]);
      return r[0] * p[0] + r[3] * p[1] + r[6] * p[2];
    };
  });
  const middle_x = () => page.evaluate(() => middle_x());
  const middle = await page.evaluate(() => {
    const b = document.getElementById('picture').getBoundingClientRect();
    return [b.left + b.width / 2, b.top + b.height / 2];
  });

  // The clip plane.
  result.clip.before = await middle_x();
  await page.evaluate(() => (window.whole = pixels(view.renderer)));
  await page.click('#clip_x');
  await rest();
  result.clip.across = await middle_x();
  await page.screenshot({ path: in_out('clip.png') });
  await page.focus('#clip_place');
  await page.keyboard.press('Home');
  await rest();
  result.clip.beyond = await page.evaluate(() => {
    let count = 0;
    for (let x = 0; x < view.drawn.width; x += 4) count += view.picture.depth_at(x, view.drawn.height / 2) > 0;
    return count;
  });
  await page.click('#clip_flip');
  await rest();
  result.clip.flipped = await middle_x();
  await page.click('#clip_off');
  await rest();
  result.clip.off = await page.evaluate(() => differ(whole, pixels(view.renderer)));

  // Confidence.
  await page.click('#mode_confidence');
  await rest();
  const hidden = () => page.$eval('#legend', (e) => getComputedStyle(e).display === 'none');
  result.confidence = { seen: await page.evaluate(() => [...view.page.blocks.seen]), legend: [await hidden()] };
  result.confidence.off_scale = await page.evaluate(() => {
    const { width, height } = view.canvas, all = pixels(view.renderer), at = 4 * (Math.floor(height / 2) * width + Math.floor(width / 2));
    const colors = view.picture.uniforms.scale.value.map((v) => 255 * v);
    let least = Infinity;
    for (let k = 0; k < 4; ++k)
      for (let x = 0; x <= 1; x += 0.01) {
        const off = [0, 1, 2].map((c) => Math.abs(all[at + c] - colors[3 * k + c] - x * (colors[3 * k + 3 + c] - colors[3 * k + c])));
        least = Math.min(least, Math.max(...off));
      }
    return least;
  });
  await page.screenshot({ path: in_out('confidence.png') });
  await page.click('#mode_photo');
  await rest();
  result.confidence.legend.push(await hidden());

  // An annotation.
  const click = [middle[0] + 12, middle[1] - 8];
  await page.click('#annotate');
  await page.mouse.click(...click);
  await page.keyboard.type('<b>one</b>');
  await page.click('#annotate');
  const note = () => page.evaluate(() => view.notes.list.map(({ text, place }) => [text, place])[0]);
  result.note.place = (await note())[1];
  const circle = await page.$eval('#marks .note circle', (e) => [e.getBoundingClientRect().left + e.getBoundingClientRect().width / 2, e.getBoundingClientRect().top + e.getBoundingClientRect().height / 2]);
  result.note.off_px = Math.hypot(circle[0] - click[0], circle[1] - click[1]);
  result.note.markup = await page.evaluate(() => document.querySelectorAll('#marks b, #notes b').length);
  const hash = await page.evaluate(() => location.hash);
  rmSync(in_out('annotations.json'), { force: true });
  await page.click('#save_notes');
  for (let k = 0; k < 100 && !existsSync(in_out('annotations.json')); ++k) await new Promise((r) => setTimeout(r, 100));
  await page.screenshot({ path: in_out('note.png') });
  await page.click('#notes button');
  result.note.deleted = await page.evaluate(() => view.notes.list.length);
  const notes = await page.$('#open_notes');
  await notes.uploadFile(in_out('annotations.json'));
  await page.waitForFunction(() => view.notes.list.length === 1);
  result.note.opened = await note();
  const said = async () => {
    await page.waitForFunction(() => !document.getElementById('notice').hidden);
    return page.$eval('#notice', (e) => e.textContent);
  };
  writeFileSync(in_out('wrong.json'), 'no list');
  await notes.uploadFile(in_out('wrong.json'));
  result.note.refused = await said();

  // Another run.
  writeFileSync(in_out('other.html'), '<!doctype html><title>other</title><script>throw new Error("executed")</script>');
  const other = await page.$('#open_other');
  await page.evaluate(() => view.tell(''));
  await other.uploadFile(in_out('other.html'));
  result.two.refused = await said();
  const shown = async () => {
    await page.waitForFunction(() => view.runs.other?.drawn);
    await rest();
  };
  await other.uploadFile(file);
  await shown();
  result.two.differ = await page.evaluate(() => differ(pixels(view.renderer), pixels(view.runs.other.renderer)));
  result.two.bright = await page.evaluate(() => pixels(view.runs.other.renderer).filter((v, i) => i % 4 < 3 && v > 30).length);
  await page.screenshot({ path: in_out('two.png') });
  // The same scene in a frame that is turned by 40 degrees about z, 1.7 times as large and moved: p' = 1.7 R p + t.
  const text = readFileSync(file, 'utf8'), begin = text.indexOf('>', text.indexOf('id="scene"')) + 1, end = text.indexOf('</script>', begin);
  const scene = JSON.parse(text.slice(begin, end)), c = Math.cos((40 * Math.PI) / 180), s = Math.sin((40 * Math.PI) / 180), t = [0.3, -2, 0.5];
  for (const camera of scene.cameras) {
    const r = camera.rotation;  // times the inverse of R
    camera.rotation = [0, 3, 6].flatMap((k) => [r[k] * c - r[k + 1] * s, r[k] * s + r[k + 1] * c, r[k + 2]]);
    camera.translation = camera.translation.map((v, k) => 1.7 * v - [0, 1, 2].reduce((sum, i) => sum + camera.rotation[3 * k + i] * t[i], 0));
  }
  writeFileSync(in_out('moved.html'), text.slice(0, begin) + JSON.stringify(scene) + text.slice(end));
  await page.click('#photos button:nth-child(3)');
  await rest();
  const devtools = await page.createCDPSession(), data = { items: [], files: [in_out('moved.html')], dragOperationsMask: 1 };
  await page.evaluate(() => (window.first = view.runs.other));
  for (const type of ['dragEnter', 'dragOver', 'drop']) await devtools.send('Input.dispatchDragEvent', { type, x: 100, y: 100, data });
  await page.waitForFunction(() => view.runs.other && view.runs.other !== first);
  await shown();
  const drawn = await page.evaluate(() => view.runs.other.drawn), wanted = scene.cameras[2];
  result.two.camera = Math.max(...['rotation', 'translation'].flatMap((name) => wanted[name].map((v, i) => Math.abs(v - drawn[name][i]))));
  result.two.told = await page.$eval('#other_told', (e) => e.textContent);
  await page.click('#end_other');
  await rest();
  result.two.ended = await page.evaluate(() => document.querySelectorAll('canvas').length);

  const again = await browser.newPage();
  await opened(again, hash.replace(/eye=[^&]*/, 'eye=-1,0,0.2').replace(/target=[^&]*/, 'target=0,0,0'));
  result.note.from_behind = await again.evaluate(() => [view.notes.list[0].text, document.querySelector('#marks .note').getAttribute('class')]);
} finally {
  await browser.close();
}

// The mesh alone.
const plain = await open_chromium({ args: ['--disable-3d-apis', '--disable-gpu'] });
try {
  const page = await plain.newPage();
  await opened(page, '#clip=y,0');
  result.clip.mesh = [await painted(page)];
  await page.click('#clip_off');
  result.clip.mesh.push(await painted(page));
} finally {
  await plain.close();
}
console.log(JSON.stringify(result));
