// node mark_sample.mjs PAGE.html OUTLINES.json OUT_DIR: draws outlines in a page of `vitrine mark` with the mouse and saves them to OUT_DIR.
// OUTLINES.json: [{ class, photos: { name: [[x, y], ...] } }], pixels of the photos. Prints JSON:
//   messages  what the console said, and errors of scripts;  clicks  of the mouse, those on buttons and photos too;  states  of the objects
import { mkdirSync, readFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { open_chromium, saved } from './chromium.mjs';

const [file, outlines, out] = process.argv.slice(2).map((p) => resolve(p));
mkdirSync(out, { recursive: true });
const browser = await open_chromium();
const result = { messages: [], clicks: 0 };
try {
  const page = await browser.newPage();
  page.on('console', (m) => result.messages.push(`${m.type()}: ${m.text()}`));
  page.on('pageerror', (e) => result.messages.push(`error: ${e}`));
  page.on('dialog', (d) => d.accept());
  const session = await browser.target().createCDPSession();
  await session.send('Browser.setDownloadBehavior', { behavior: 'allow', downloadPath: out });
  await page.setViewport({ width: 1400, height: 900 });
  await page.goto(pathToFileURL(file).href);
  const press = async (selector) => (++result.clicks, await page.click(selector));
  for (const { class: kind, photos } of JSON.parse(readFileSync(outlines))) {
    await press(`#add_${kind}`);
    for (const [name, corners] of Object.entries(photos)) {
      await press(`#photos button[title="${name}"]`);
      await page.waitForFunction((name) => vitrine.photo.name === name && vitrine.sheet.picture, {}, name);
      for (const p of [...corners, corners[0]]) {
        const at = await page.evaluate((p) => {
          const { left, top } = document.getElementById('sheet').getBoundingClientRect(), [x, y] = vitrine.sheet.to_screen(p);
          return [left + x, top + y];
        }, p);
        ++result.clicks;
        await page.mouse.click(...at);
      }
      await page.screenshot({ path: join(out, `${kind}_${name}.png`) });
    }
  }
  result.states = await page.$$eval('#things .thing', (all) => all.map((e) => e.className.split(' ')[1]));
  await press('#save');
  await saved(out, 'marks.yaml');
} finally {
  await browser.close();
}
console.log(JSON.stringify(result));
