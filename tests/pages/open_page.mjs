// node open_page.mjs FILE.html OUT.png WIDTH light|dark: opens a page from file:// in headless Chromium and prints JSON:
//   messages   what the console said, errors of scripts, requests for anything but the file itself and data: URIs
//   scroll     width of the document; more than WIDTH means that one has to scroll sideways
//   readable   share of the text that stands inside the width in letters of at least 12 pixels
//   pictures   [all, those that did not decode]
//   blank      pictures that are not there yet when the page has been loaded, without scrolling
//   printed    [pages, pictures in them] of the page as PDF, which OUT.pdf holds
//   opening    where the link of the first picture leads; null without one
//   split      where the border of the first slider is after its range input was set to 80; null without a slider
//   colour     computed background of the page
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { open_chromium } from './chromium.mjs';

const [file, out, width, scheme] = process.argv.slice(2);
const address = pathToFileURL(resolve(file)).href;
const browser = await open_chromium();
try {
  const page = await browser.newPage();
  const messages = [];
  page.on('console', (m) => messages.push(`${m.type()}: ${m.text()}`));
  page.on('pageerror', (e) => messages.push(`error: ${e}`));
  page.on('dialog', (d) => (messages.push(`dialog: ${d.message()}`), d.dismiss()));
  page.on('request', (r) => r.url() === address || r.url().startsWith('data:') || messages.push(`request: ${r.url()}`));
  await page.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: scheme }]);
  await page.setViewport({ width: Number(width), height: 844, isMobile: width < 600, hasTouch: width < 600 });
  await page.goto(address, { waitUntil: 'load' });
  const pdf = Buffer.from(await page.pdf({ path: out.replace(/png$/, 'pdf'), format: 'A4', printBackground: true })).toString('latin1');
  const printed = [pdf.match(/\/Type\s*\/Page\b/g)?.length ?? 0, pdf.match(/\/Subtype\s*\/Image\b/g)?.length ?? 0];
  const result = await page.evaluate(async () => {
    const pictures = [...document.images];
    const blank = pictures.filter((i) => i.offsetParent !== null && !(i.complete && i.naturalWidth > 0)).length;
    for (const d of document.querySelectorAll('details')) d.open = true;
    const decoded = await Promise.all(pictures.map((i) => (i.offsetParent === null ? true : i.decode().then(() => true, () => false))));
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    let all = 0, inside = 0;
    for (let node; (node = walker.nextNode());) {
      const text = node.textContent.trim(), parent = node.parentElement;
      if (!text || parent.closest('script, svg') || !parent.getClientRects().length) continue;
      const range = document.createRange();
      range.selectNodeContents(node);
      const fits = [...range.getClientRects()].every((r) => r.left >= 0 && r.right <= innerWidth + 1);
      all += text.length;
      if (fits && parseFloat(getComputedStyle(parent).fontSize) >= 12) inside += text.length;
    }
    const slider = document.querySelector('.pair input');
    if (slider) slider.value = 80, slider.dispatchEvent(new Event('input'));
    return {
      scroll: document.documentElement.scrollWidth, readable: inside / Math.max(1, all),
      pictures: [pictures.length, decoded.filter((d) => !d).length],
      blank, opening: document.querySelector('#opening a')?.getAttribute('href') ?? null,
      split: slider ? slider.parentElement.style.getPropertyValue('--split') : null,
      colour: getComputedStyle(document.body).backgroundColor,
    };
  });
  await page.screenshot({ path: out, fullPage: true });
  console.log(JSON.stringify({ ...result, printed, messages }));
} finally {
  await browser.close();
}
