// node mark_run.mjs PAGE.html OUT_DIR: a page of `vitrine mark OUT`, of the sample, as a person sees it. Prints JSON:
//   messages  what the console said, and errors of scripts
//   states    of the objects at the beginning: those of the marks that the run was given;  sources  what is said of its masks
//   masks     how far the picture of a photo without marks changes, mean of 255, when the masks are hidden, and shown again
//   first     what is said of an object that is boxed in img_0020;  second  in img_0032, too, taken from the same side
//   looser    its level with a page whose data let photos look from any side
import { mkdirSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { open_chromium } from './chromium.mjs';

const [file, out] = process.argv.slice(2).map((p) => resolve(p));
mkdirSync(out, { recursive: true });
const browser = await open_chromium();
const result = { messages: [] };
try {
  const page = await browser.newPage();
  page.on('console', (m) => result.messages.push(`${m.type()}: ${m.text()}`));
  page.on('pageerror', (e) => result.messages.push(`error: ${e}`));
  await page.setViewport({ width: 1360, height: 860 });
  await page.goto(pathToFileURL(file).href);
  const show = async (name) => {
    await page.click(`#photos button[title="${name}"]`);
    await page.waitForFunction((name) => vitrine.photo.name === name && vitrine.sheet.picture, {}, name);
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  };
  const pixels = () =>
    page.evaluate(() => {
      const canvas = document.getElementById('sheet'), { width, height } = canvas;
      vitrine.sheet.draw();
      const copy = Object.assign(document.createElement('canvas'), { width, height }).getContext('2d', { willReadFrequently: true });
      copy.drawImage(canvas, 0, 0);
      const now = copy.getImageData(0, 0, width, height).data, before = window.before ?? now;
      window.before = now;
      return now.reduce((sum, v, i) => sum + Math.abs(v - before[i]), 0) / now.length;
    });
  result.states = await page.$$eval('#things .thing', (all) => all.map((e) => e.className.split(' ')[1]));
  result.sources = await page.$eval('#panel', (e) => e.textContent.match(/What the run took in every photo: [^.]*\./)?.[0]);
  await show('img_0008.jpg');
  await page.screenshot({ path: join(out, 'masks.png') });
  await pixels();
  result.masks = [];
  for (let k = 0; k < 2; ++k) {
    await page.keyboard.press('m');
    result.masks.push(await pixels());
  }
  await page.click('#add_transparent');
  await page.click('#tool_box');
  const box = async (name, [l, t, r, b]) => {
    await show(name);
    const at = (p) =>
      page.evaluate((p) => {
        const { left, top } = document.getElementById('sheet').getBoundingClientRect(), [x, y] = vitrine.sheet.to_screen(p);
        return [left + x, top + y];
      }, p);
    await page.mouse.move(...(await at([l, t])));
    await page.mouse.down();
    await page.mouse.move(...(await at([r, b])), { steps: 4 });
    await page.mouse.up();
    return page.$eval('#things .thing.chosen p', (e) => e.textContent);
  };
  result.first = await box('img_0020.jpg', [84, 38, 330, 360]);
  result.second = await box('img_0032.jpg', [60, 20, 330, 360]);
  await page.screenshot({ path: join(out, 'same_side.png') });
  result.looser = await page.evaluate(() => {
    vitrine.scene.most_one_sided = 1;
    return vitrine.state_of(vitrine.doc.things.at(-1)).level;
  });
} finally {
  await browser.close();
}
console.log(JSON.stringify(result));
