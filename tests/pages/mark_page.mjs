// node mark_page.mjs PAGE.html MARKS.yaml NO_MARKS.yaml OUT_DIR: uses a page of `vitrine mark` as a person would, from file:// in headless
// Chromium, and prints JSON; pictures and what the page saved lie in OUT_DIR. The photos: a (a bright rectangle on black), b (the same,
// upright), c (dark). A place of the rectangle on the screen is found in the pixels of the canvas, not asked of the page.
//   messages     what the console said, errors of scripts, requests for anything but the page itself, data: and blob: URIs
//   classes      of the buttons that add an object;  zoom  screen pixels a photo pixel, of a
//   drawn        text of the file after four clicks on the corners of the rectangle and one on the first;  undone  redone  the same
//   box          after a box was dragged over the rectangle of b;  zoomed  after a corner of a was moved to the rectangle's middle, at 6 x
//   stayed       how far that corner went from the mouse while the wheel turned
//   deleted      marks before and after Backspace;  inserted  corners before and after the middle of a side was dragged
//   touched      corners of three taps and one on the first;  pinched  zoom before and after two fingers moved apart
//   crossed      what stands beside the object whose outline crosses, and what saving says
//   dialogs      of leaving with marks that are not saved, and with saved ones;  restored  text before and after that, and the notice
//   opened       text of the file after MARKS was opened, and the notice;  refused  what is said to NO_MARKS
//   nudged       how far an arrow key moved a corner;  shown  photos after n, n, p
//   kept         corners of an outline that was not closed: after another photo was looked at, and after another visit
import { mkdirSync, readdirSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { open_chromium, saved, watch } from './chromium.mjs';

const [file, marks, no_marks, out] = process.argv.slice(2).map((p) => resolve(p));
mkdirSync(out, { recursive: true });
const address = pathToFileURL(file).href;
const browser = await open_chromium();
const result = { messages: [], dialogs: [] };
try {
  const page = await browser.newPage();
  watch(page, address, result.messages);
  page.on('dialog', (d) => (result.dialogs.push(d.type()), d.accept()));
  const session = await browser.target().createCDPSession(), touch = await page.createCDPSession();
  await session.send('Browser.setDownloadBehavior', { behavior: 'allow', downloadPath: out });
  await page.setViewport({ width: 1100, height: 760, hasTouch: true });
  const frame = () => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  const ready = async () => (await page.waitForFunction(() => vitrine.sheet.picture), await frame());
  await page.goto(address);
  await ready();

  const text = () => page.$eval('#yaml', (e) => e.value);
  const notice = () => page.$eval('#notice', (e) => (e.hidden ? '' : e.textContent));
  const zoom = () => page.evaluate(() => vitrine.sheet.zoom);
  const corners = () => page.evaluate(() => vitrine.doc.marks.map((m) => m.corners.length));
  const show = async (i) => (await page.click(`#photos button:nth-child(${i})`), await ready());
  // The rectangle on the screen, from its mass and its centre.
  const rectangle = () =>
    page.evaluate(() => {
      const canvas = document.getElementById('sheet'), { width, height } = canvas, { left, top } = canvas.getBoundingClientRect();
      const copy = Object.assign(document.createElement('canvas'), { width, height }).getContext('2d', { willReadFrequently: true });
      copy.drawImage(canvas, 0, 0);
      const { data } = copy.getImageData(0, 0, width, height);
      let mass = 0, x = 0, y = 0, rows = new Float64Array(height);
      for (let j = 0; j < height; ++j)
        for (let i = 0; i < width; ++i) {
          const at = 4 * (j * width + i), v = data[at + 3] === 255 ? data[at] / 255 : 0;
          mass += v, x += v * (i + 0.5), y += v * (j + 0.5), (rows[j] += v);
        }
      const w = rows.reduce((a, b) => Math.max(a, b), 0), h = mass / w;
      return [left + x / mass - w / 2, top + y / mass - h / 2, left + x / mass + w / 2, top + y / mass + h / 2];
    });
  const on_screen = (p) =>
    page.evaluate((p) => {
      const { left, top } = document.getElementById('sheet').getBoundingClientRect(), [x, y] = vitrine.sheet.to_screen(p);
      return [left + x, top + y];
    }, p);
  const drag = async (from, to, steps = 5) => {
    await page.mouse.move(...from);
    await page.mouse.down();
    await page.mouse.move(...to, { steps });
    await page.mouse.up();
  };

  result.classes = await page.$$eval('#add button', (all) => all.map((b) => b.id.replace('add_', '')));
  result.zoom = await zoom();
  await page.click('#add_transparent');
  const [l, t, r, b] = await rectangle();
  for (const p of [[l, t], [r, t], [r, b], [l, b], [l, t]]) await page.mouse.click(...p);
  await page.screenshot({ path: join(out, 'page.png') });
  result.drawn = await text();
  await page.click('#undo');
  result.undone = await text();
  await page.click('#redo');
  result.redone = await text();

  await page.keyboard.press('n');
  await ready();
  await page.keyboard.press('b');
  const upright = await rectangle();
  await drag([upright[2], upright[1]], [upright[0], upright[3]]);  // from the right top corner to the left bottom one
  result.box = await text();

  // Zoomed, a corner moves.
  await show(1);
  await page.keyboard.press('c');
  await page.mouse.move(l, t);
  for (let k = 0; k < 12; ++k) await page.mouse.wheel({ deltaY: -100 });
  await frame();
  const [x, y] = await on_screen(await page.evaluate(() => vitrine.doc.marks[0].corners[0]));
  await drag([x + 3, y - 2], [x + 63, y + 28]);  // held beside its middle
  result.stayed = [x - l, y - t];
  result.zoomed = [await text(), await zoom()];
  await page.keyboard.press('ArrowRight');
  await page.keyboard.press('f');
  const before = await page.evaluate(() => [vitrine.doc.marks[0].corners[0][0], vitrine.sheet.zoom]);
  await page.keyboard.press('ArrowRight');
  result.nudged = [(await page.evaluate(() => vitrine.doc.marks[0].corners[0][0])) - before[0], before[1]];
  result.inserted = [(await corners())[0]];
  await drag([(l + r) / 2, b], [(l + r) / 2, b + 12]);
  result.inserted.push((await corners())[0]);
  await page.keyboard.press('Escape');
  await show(2);
  result.deleted = [(await corners()).length];
  await page.keyboard.press('Backspace');
  result.deleted.push((await corners()).length);
  await page.keyboard.down('Control');
  await page.keyboard.press('z');
  await page.keyboard.up('Control');
  result.deleted.push((await corners()).length);

  // Fingers.
  await show(3);
  await page.click('#add_specular');
  for (const p of [[200, 200], [700, 220], [400, 600], [200, 200]]) await page.touchscreen.tap(...(await on_screen(p)));
  result.touched = await page.evaluate(() => vitrine.doc.marks.at(-1).corners);
  result.pinched = [await zoom()];
  const fingers = (type, apart) =>
    touch.send('Input.dispatchTouchEvent', { type, touchPoints: type === 'touchEnd' ? [] : [{ x: 400 - apart, y: 400, id: 0 }, { x: 400 + apart, y: 400, id: 1 }] });
  await fingers('touchStart', 40);
  for (const apart of [60, 80, 100, 120]) await fingers('touchMove', apart);
  await fingers('touchEnd');
  result.pinched.push(await zoom(), (await corners()).length);
  await page.keyboard.press('f');

  // An outline that crosses itself.
  await show(1);
  for (const p of [[100, 100], [500, 500], [500, 100], [100, 500]]) await page.mouse.click(...(await on_screen(p)));
  await page.keyboard.press('Enter');
  await page.click('#save');
  result.crossed = [await page.$$eval('#things .wrong', (all) => all.map((e) => e.textContent)), await notice(), readdirSync(out).includes('marks.yaml')];
  await page.screenshot({ path: join(out, 'crossed.png') });
  await page.keyboard.press('Escape');

  // Another visit; an outline is not closed.
  await page.keyboard.press('o');
  await show(3);
  await page.keyboard.press('1');
  for (const p of [[300, 300], [500, 300]]) await page.mouse.click(...(await on_screen(p)));
  await page.keyboard.press('n');
  await page.keyboard.press('p');
  result.kept = [await page.evaluate(() => vitrine.pen.drawing.corners)];
  result.restored = [await text()];
  await page.reload();
  await ready();
  result.restored.push(await text(), await notice());
  result.kept.push(await page.evaluate(() => vitrine.pen.drawing.corners));
  await page.click('#notice button');
  result.restored.push(await page.evaluate(() => [vitrine.pen.drawing, vitrine.doc.marks.length]));

  // A file of marks.
  const input = await page.$('#open_file');
  await input.uploadFile(no_marks);
  await page.waitForFunction(() => document.getElementById('notice').textContent.includes('is no file of marks'));
  result.refused = await notice();
  await input.uploadFile(marks);
  await page.waitForFunction(() => document.getElementById('notice').textContent.includes('is open'));
  result.opened = [await text(), await notice()];
  result.shown = [];
  await page.click('#sheet', { button: 'right' });
  for (const key of ['n', 'n', 'p']) {
    await page.keyboard.press(key);
    result.shown.push(await page.evaluate(() => vitrine.photo.name));
  }
  await page.click('#save');
  await page.click('#notice button');  // all the same
  await saved(out, 'marks.yaml');
  result.saved = await notice();
  const leaves = result.dialogs.length;
  await page.reload();
  await ready();
  result.dialogs = [leaves, result.dialogs.length - leaves];
  result.again = await text();
} finally {
  await browser.close();
}
console.log(JSON.stringify(result));
