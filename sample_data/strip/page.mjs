// node page.mjs VIEW.html HDRI OUT_PREFIX (by page.sh): the page of `vitrine view` in headless Chromium, as photographed (OUT_PREFIX_photo.jpg)
// and under the HDRI (OUT_PREFIX_relit.jpg), panel and all.
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { open_chromium, software_webgl } from './chromium.mjs';

const [file, hdri, out] = process.argv.slice(2).map((p) => resolve(p));
const browser = await open_chromium({ args: software_webgl });
try {
  const page = await browser.newPage();
  await page.setViewport({ width: 960, height: 560 });
  await page.goto(pathToFileURL(file).href);
  await page.evaluate(() => window.vitrine.then((v) => (window.view = v)).then(() => 1));
  const taken = async (name) => {
    await page.waitForFunction(() => !view.waiting && view.resting !== false);
    await page.screenshot({ path: `${out}_${name}.jpg`, type: 'jpeg', quality: 78 });
  };
  await taken('photo');
  await (await page.$('#hdri')).uploadFile(hdri);
  await page.waitForFunction(() => view.state.mode === 'relit');
  await taken('relit');
} finally {
  await browser.close();
}
