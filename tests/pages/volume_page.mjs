// node volume_page.mjs PAGE.html PLACES OUT_DIR: uses a page of `vitrine ct` as a person does (headless Chromium, file://) and prints JSON.
// PLACES: [[x, y, z], ...], the last one outside of the scan. transfer_function.json lies in OUT_DIR.
//   messages   what the console said, errors of scripts, requests for anything but the page itself, data: and blob: URIs
//   densities  of the page at PLACES;  greys  [x, y, z slice] brightness of the pixels there, 0 to 1;  window  densities that are black, white
//   clicked    place of the crosshair after a click on PLACES[1] in the slice across z;  wheeled, keyed  after wheel and key
//   dragged    the window after shift and drag;  readout  of PLACES[0] and of the last one
//   measured   the distance of PLACES[0] and [1] in the slice across z
//   hit        where a click on the picture of the volume put the crosshair, at the pixel of PLACES[1]
//   pictures   differences of the picture of the volume to the first one, by what was changed;  points  their number after add and remove
//   saved      points of the saved file;  opened, dropped  points after it was opened, dropped;  refused  {file: sentence}
//   kept       whether a refused file changed nothing;  narrow  width of the page in a window of 390 pixels
//   without    {sentence, grey} in a browser without WebGL
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { open_chromium, saved, software_webgl, visit, without_webgl } from './chromium.mjs';

const places = JSON.parse(process.argv[3]), out = resolve(process.argv[4]);
mkdirSync(out, { recursive: true });
const address = pathToFileURL(resolve(process.argv[2])).href;
const browser = await open_chromium({ args: software_webgl });
const result = { messages: [], refused: {}, pictures: {} };

// Brightness of the slices through a place, there, with the crosshair elsewhere in their plane.
const grey_at = ([p]) => {
  const { slices, state } = window.opened;
  return slices.map((s) => {
    const aside = [...p];
    aside[s.right] += 9 * s.volume.cell, aside[s.up] += 9 * s.volume.cell;
    state.go(aside);
    s.draw();
    const [x, y] = s.to_screen(p), scale = s.canvas.width / s.canvas.clientWidth;
    const copy = new OffscreenCanvas(s.canvas.width, s.canvas.height).getContext('2d');
    copy.drawImage(s.canvas, 0, 0);
    return copy.getImageData(Math.round(x * scale), Math.round(y * scale), 1, 1).data[1] / 255;
  });
};

try {
  const page = await visit(browser, address, result.messages, { width: 740, height: 460 }, out);
  await page.evaluate(() => (window.opened = view));
  const rest = () => page.waitForFunction(() => opened.view.resting && !opened.view.waiting);
  const state = () => page.evaluate(() => ({ place: opened.state.place, window: [opened.state.black, opened.state.white] }));
  const points = () => page.evaluate(() => opened.transfer.points.map((p) => ({ ...p })));
  await rest();
  await page.screenshot({ path: join(out, 'start.png') });
  result.densities = await page.evaluate((all) => all.map((p) => opened.volume.density(p)), places);
  await page.click('#all_densities');
  result.greys = [];
  for (const p of places) result.greys.push(await page.evaluate(grey_at, [p]));
  result.window = (await state()).window;

  // The slice across z: a click, the wheel, keys, grey values.
  await page.evaluate((z) => opened.state.go([0, 0, z]), places[1][2]);
  const on_slice = (p) =>
    page.evaluate((p) => {
      const s = opened.slices[2], box = s.canvas.getBoundingClientRect(), [x, y] = s.to_screen(p);
      return [box.left + x, box.top + y];
    }, p);
  const at = await on_slice(places[1]);
  await page.mouse.click(...at);
  result.clicked = (await state()).place;
  await page.mouse.wheel({ deltaY: -120 });
  await page.waitForFunction((z) => opened.state.place[2] > z, {}, result.clicked[2]);
  result.wheeled = (await state()).place;
  await page.keyboard.press('ArrowLeft');
  result.keyed = (await state()).place;
  await page.keyboard.down('Shift');
  await page.mouse.down();
  await page.mouse.move(at[0] + 30, at[1] + 20, { steps: 3 });
  await page.mouse.up();
  await page.keyboard.up('Shift');
  result.dragged = (await state()).window;
  await page.click('#all_densities');
  result.reset = (await state()).window;
  result.readout = [];
  await page.evaluate((z) => opened.state.go([0, 0, z]), places[0][2]);
  for (const p of [places[0], places.at(-1)]) {
    await page.mouse.move(...(await on_slice(p)));
    result.readout.push(await page.$eval('#readout', (e) => e.value));
  }

  await page.click('#measure');
  const [ends, more] = [await on_slice(places[0]), await on_slice(places[1].map((v, c) => (c === 2 ? places[0][2] : v)))];
  await page.mouse.move(...ends);
  await page.mouse.down();
  await page.mouse.move(...more, { steps: 3 });
  await page.mouse.up();
  result.measured = await page.$eval('#measured', (e) => e.value);
  await page.screenshot({ path: join(out, 'measured.png') });
  await page.click('#measure');

  // The picture of the volume.
  const picture = (in_bands = false) =>
    page.evaluate(async (in_bands) => {
      if (in_bands) {
        opened.view.paint(0.4, true);
        opened.view.scale = 0.4;
        await opened.view.rest();
      } else {
        opened.view.paint(1, false);
      }
      const { gl } = opened.view.casting, { width, height } = gl.canvas, all = new Uint8Array(4 * width * height);
      gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, all);
      return [...all.filter((_, i) => i % 4 === 1)];
    }, in_bands);
  const first = await picture();
  const compare = async (name, in_bands) => {
    const now = await picture(in_bands);
    result.pictures[name] = now.reduce((sum, v, i) => sum + Math.abs(v - first[i]), 0) / now.length;
  };
  result.pictures.bright = first.filter((v) => v > 60).length / first.length;
  await compare('same');
  await compare('bands', true);
  const hit_at = await page.evaluate((p) => {
    const { view, transfer, volume } = opened;
    transfer.surface(0.8 * volume.high);
    const box = view.canvas.getBoundingClientRect(), k = view.camera(), q = p.map((v, c) => v - k.eye[c]), dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const depth = dot(q, k.ahead), along = (axis) => dot(q, axis) / dot(axis, axis) / depth;
    return [box.left + ((along(k.right) + 1) / 2) * box.width, box.top + ((1 - along(k.up)) / 2) * box.height];
  }, places[1]);
  result.pictures.inside = await page.evaluate(([x, y]) => {
    const { view } = opened, { gl } = view.casting, box = view.canvas.getBoundingClientRect(), one = new Uint8Array(4);
    view.paint(1, false);
    gl.readPixels(Math.round(((x - box.left) / box.width) * gl.canvas.width), Math.round((1 - (y - box.top) / box.height) * gl.canvas.height), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, one);
    return one[1];
  }, hit_at);
  await page.mouse.click(...hit_at);
  result.hit = (await state()).place;
  await compare('dense');
  for (const name of ['x-ray', 'soft', 'surface']) {
    await page.click(`#start_${name}`);
    await compare(name);
    if (name === 'soft') await page.screenshot({ path: join(out, 'soft.png') });
  }
  await page.click('#cut_x');
  await compare('cut');
  await page.screenshot({ path: join(out, 'cut.png') });
  await page.click('#cut_off');
  await compare('uncut');
  await page.focus('#picture');
  await page.keyboard.press('ArrowLeft');
  await compare('turned');
  await page.keyboard.press('r');

  // The curve: a point dragged, added, removed by a key and by the button; colour.
  const circle = (i) =>
    page.evaluate((i) => {
      const box = document.querySelectorAll('#transfer circle')[i].getBoundingClientRect();
      return [box.left + box.width / 2, box.top + box.height / 2];
    }, i);
  await page.$eval('#transfer', (e) => e.scrollIntoView({ block: 'center' }));
  result.points = [(await points()).length];
  const before = await points(), grabbed = await circle(2);
  await page.mouse.move(...grabbed);
  await page.mouse.down();
  await page.mouse.move(grabbed[0] + 12, grabbed[1] + 60, { steps: 4 });
  await page.mouse.up();
  result.moved = [before[2], (await points())[2]];
  await compare('moved');
  const [[x0, y0], [x1]] = [await circle(2), await circle(3)];
  await page.mouse.click((x0 + x1) / 2, y0 - 20, { clickCount: 2 });
  result.points.push((await points()).length);
  await page.$eval('#point_color', (e) => ((e.value = '#3070c0'), e.dispatchEvent(new Event('input', { bubbles: true }))));
  const edited = await points();
  await compare('edited');
  await page.click('#save_transfer');
  await saved(out, 'transfer_function.json');
  const file = join(out, 'transfer_function.json');
  result.saved = JSON.parse(readFileSync(file, 'utf8'));
  await page.$eval('#transfer circle:nth-child(2)', (e) => e.focus());
  await page.keyboard.press('Delete');
  result.points.push((await points()).length);
  await page.click('#remove_point');
  result.points.push((await points()).length);
  await page.click('#start_x-ray');
  const open = async (path) => {
    await (await page.$('#open_transfer')).uploadFile(path);
    await page.waitForFunction(() => document.querySelector('#open_transfer').value === '');
  };
  await open(file);
  await page.waitForFunction((n) => opened.transfer.points.length === n, {}, edited.length);
  result.edited = edited, result.opened = await points();
  await page.click('#start_soft');
  const drop = (name, text) =>
    page.evaluate(([name, text]) => {
      const data = new DataTransfer();
      data.items.add(new File([text], name));
      document.getElementById('stage').dispatchEvent(new DragEvent('drop', { bubbles: true, cancelable: true, dataTransfer: data }));
    }, [name, text]);
  await drop('saved.json', readFileSync(file, 'utf8'));
  await page.waitForFunction((n) => opened.transfer.points.length === n, {}, edited.length);
  result.dropped = await points();

  // Files that are none.
  const good = result.saved, changed = (some) => JSON.stringify({ ...good, ...some }), without_first = (some) => changed({ points: [{ ...good.points[0], ...some }, ...good.points.slice(1)] });
  const files = {
    'cut.json': changed({}).slice(0, 80), 'scene.json': '{"format": 2}', 'list.json': '[1, 2]', 'null.json': 'null', 'unit.json': changed({ density_unit: '1/inch' }),
    'one.json': changed({ points: good.points.slice(0, 1) }), 'word.json': without_first({ density: 'much' }), 'many.json': without_first({ opacity: 2 }),
    'colour.json': without_first({ color: 'red' }), 'large.json': ' '.repeat(1100000),
  };
  result.kept = true;
  for (const [name, text] of Object.entries(files)) {
    await drop(name, text);
    await page.waitForFunction((name) => document.getElementById('notice').textContent.includes(name), {}, name);
    result.refused[name] = await page.$eval('#notice', (e) => e.textContent);
    result.kept &&= JSON.stringify(await points()) === JSON.stringify(result.dropped);
  }
  writeFileSync(join(out, 'um.json'), JSON.stringify({ ...good, density_unit: '1/um', points: good.points.map((p) => ({ ...p, density: p.density / 1000 })) }));
  await open(join(out, 'um.json'));
  await page.waitForFunction(() => document.getElementById('notice').hidden);
  result.other_unit = await points();

  await page.close();

  // A phone.
  const phone = await visit(browser, address, result.messages, { width: 390, height: 844, isMobile: true, hasTouch: true }, out);
  await phone.screenshot({ path: join(out, 'phone.png') });
  result.narrow = await phone.evaluate(() => document.documentElement.scrollWidth);
  await phone.tap('#pane_volume .large');
  result.alone = await phone.$$eval('.pane', (all) => all.filter((p) => p.getClientRects().length).map((p) => p.id));
  await phone.screenshot({ path: join(out, 'phone_volume.png') });
} finally {
  await browser.close();
}
await without_webgl(address, result.messages, { width: 900, height: 640 }, async (page) => {
  await page.evaluate(() => window.vitrine.then((v) => (window.opened = v)).then(() => 1));
  await page.click('#all_densities');
  result.without = { sentence: await page.$eval('#pane_volume .missing', (e) => e.textContent), grey: await page.evaluate(grey_at, [places[0]]) };
});
console.log(`\n${JSON.stringify(result)}`);
