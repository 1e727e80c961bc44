// node page.mjs VIEW.html HDRI OUT_PREFIX (by page.sh): the page of `vitrine view` in headless Chromium, as photographed (OUT_PREFIX_photo.jpg)
// and under the HDRI (OUT_PREFIX_relit.jpg), panel and all.
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { open_chromium } from './chromium.mjs';

const [file, hdri, out] = process.argv.slice(2).map((p) => resolve(p));
const browser = await open_chromium({ args: ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'], protocolTimeout: 600000 });
try {
  const page = await browser.newPage();
  await page.setViewport({ width: 960, height: 560 });
  await page.goto(pathToFileURL(file).href);
  await page.evaluate(() => window.vitrine.then((v) => (window.view = v)).then(() => 1));
  const taken = async (name) => {
    await page.waitForFunction(() => !view.waiting && view.resting !== false, { timeout: 300000 });
    await page.screenshot({ path: `${out}_${name}.jpg`, type: 'jpeg', quality: 78 });
  };
  await taken('photo');
  await (await page.$('#hdri')).uploadFile(hdri);
  await page.waitForFunction(() => view.state.mode === 'relit', { timeout: 300000 });
  await taken('relit');
} finally {
  await browser.close();
}
