// node view_touch.mjs PAGE.html SKY.exr NO_SKY OUT_DIR: uses a page of `vitrine view` with fingers, in a window of the size of a phone, and
// drops files on it; events are the browser's own (DevTools). Prints JSON; pictures lie in OUT_DIR.
//   messages   what the console said, errors of scripts, requests
//   start      [eye, target] at first;  orbit  after one finger was drawn across the picture;  pinch  after two were spread from each
//              other;  moved  after two were drawn along together
//   page       [scale of the window, place it is scrolled to] after all that: fingers on the picture move the scene alone
//   tapped     the mode after a tap on "albedo"
//   overflow   by how many pixels the page is wider than the window;  small  controls in the panel lower than 24 pixels
//   dropping   [whether the picture has a frame while a file hangs over it, and when it is gone]
//   refused    what is said to a dropped file that is no HDRI, and the mode then;  dropped  [light, mode, what is said] after SKY was dropped
//   several    the light after NO_SKY and SKY were dropped together, SKY first
import { mkdirSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { open_chromium, software_webgl, viewed, visit } from './chromium.mjs';

const [file, sky, no_sky, out] = process.argv.slice(2).map((p) => resolve(p));
mkdirSync(out, { recursive: true });
const address = pathToFileURL(file).href;
const browser = await open_chromium({ args: software_webgl });
const result = { messages: [] };
try {
  const page = await visit(browser, address, result.messages, { width: 320, height: 480, isMobile: true, hasTouch: true }, out);
  const ready = () => viewed(page);
  const devtools = await page.createCDPSession();
  const rest = () => page.waitForFunction(() => !view.waiting && view.resting !== false);
  const stand = () => page.evaluate(() => [view.eye.position.toArray(), view.controls.target.toArray()]);
  const [x, y] = await page.evaluate(() => {
    const b = document.getElementById('picture').getBoundingClientRect();
    return [b.left + b.width / 2, b.top + b.height / 2];
  });
  const touch = (type, ...points) =>
    devtools.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([dx, dy], id) => ({ x: x + dx, y: y + dy, id })) });
  // Fingers go from `from` to `to` in some steps and are lifted.
  const draw = async (from, to) => {
    await touch('touchStart', ...from);
    for (let k = 1; k <= 3; ++k) await touch('touchMove', ...from.map(([a, b], i) => [a + ((to[i][0] - a) * k) / 3, b + ((to[i][1] - b) * k) / 3]));
    await touch('touchEnd');
    await rest();
    return stand();
  };
  await rest();
  await page.screenshot({ path: join(out, 'phone.png') });
  result.start = await stand();
  result.orbit = await draw([[-40, 0]], [[40, 10]]);
  result.pinch = await draw([[-30, 0], [30, 0]], [[-60, 0], [60, 0]]);
  result.moved = await draw([[-30, 0], [30, 0]], [[-30, 60], [30, 60]]);
  result.page = await page.evaluate(() => [visualViewport.scale, scrollY]);

  const button = await page.evaluateHandle(() => [...document.querySelectorAll('#panel button')].find((b) => /albedo/i.test(b.textContent)));
  await button.asElement().tap();
  await rest();
  result.tapped = await page.evaluate(() => view.state.mode);
  await page.screenshot({ path: join(out, 'phone_albedo.png') });
  result.overflow = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  result.small = await page.evaluate(() =>
    [...document.querySelectorAll('#panel button, #panel select, #panel label.file')]
      .filter((e) => e.offsetParent !== null && e.getBoundingClientRect().height < 24)
      .map((e) => e.textContent));

  // A file from the desk, in a window of that size.
  await page.setViewport({ width: 360, height: 280 });  // which loads the page again
  await ready();
  await page.evaluate(() => view.set({ mode: 'photo' }));
  await rest();
  const hang = (type, [x, y], ...files) => devtools.send('Input.dispatchDragEvent', { type, x, y, data: { items: [], files, dragOperationsMask: 1 } });
  const over = [180, 100], outside = [-20, -20];
  const frame = () => page.evaluate(() => document.body.classList.contains('dropping'));
  const drop = async (...files) => {
    for (const type of ['dragEnter', 'dragOver', 'drop']) await hang(type, over, ...files);
  };
  await hang('dragEnter', over, sky);
  await hang('dragOver', over, sky);
  result.dropping = [await frame()];
  await hang('dragOver', outside, sky);
  result.dropping.push(await frame());
  await drop(no_sky);
  await page.waitForFunction(() => !document.getElementById('notice').hidden);
  result.refused = await page.evaluate(() => [document.getElementById('notice').textContent, view.state.mode]);
  await drop(sky);
  await page.waitForFunction(() => view.state.mode === 'relit');
  await rest();
  result.dropped = await page.evaluate(() => [view.state.light, view.state.mode, document.getElementById('notice').textContent]);
  await page.screenshot({ path: join(out, 'dropped.png') });
  await page.evaluate(() => view.set({ light: 'studio', mode: 'photo' }));
  await drop(sky, no_sky);
  await page.waitForFunction(() => view.state.mode === 'relit');
  result.several = await page.evaluate(() => view.state.light);
} finally {
  await browser.close();
}
console.log(JSON.stringify(result));
