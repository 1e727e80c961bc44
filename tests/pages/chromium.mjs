// Headless Chromium for the other scripts. By itself (`node chromium.mjs`) it says by its exit code whether Chromium is here: 0 or 7.
import { existsSync, readdirSync } from 'node:fs';
import { launch } from 'puppeteer-core';

const chromium = ['/usr/bin/chromium', '/usr/bin/google-chrome'].find(existsSync);
if (!chromium) {
  console.error('Chromium is missing (Debian: apt-get install chromium)');
  process.exit(7);
}

export const software_webgl = ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];
const kPatience = 600000;  // milliseconds: other tests use the same processor

export async function open_chromium({ args = [] } = {}) {
  const browser = await launch({
    executablePath: chromium, timeout: kPatience, protocolTimeout: kPatience, args: ['--no-sandbox', '--disable-dev-shm-usage', ...args],
  });
  const new_page = browser.newPage.bind(browser);
  browser.newPage = async () => {
    const page = await new_page();
    page.setDefaultTimeout(kPatience);
    return page;
  };
  return browser;
}

// Adds to `messages` what the page at `address` should not do: what its console says, errors of scripts, requests for anything but the page
// itself, data: and blob: URIs.
export function watch(page, address, messages) {
  page.on('console', (m) => messages.push(`${m.type()}: ${m.text()}`));
  page.on('pageerror', (e) => messages.push(`error: ${e}`));
  page.on('request', (r) => r.url().split('#')[0] === address || /^(data|blob):/.test(r.url()) || messages.push(`request: ${r.url()}`));
}

// A page of `vitrine view`, shown in a window of that size, whose View is window.view there; what it saves lands in `out`.
export async function visit(browser, address, messages, viewport, out) {
  const page = await browser.newPage();
  watch(page, address, messages);
  await page.setViewport(viewport);
  const session = await browser.target().createCDPSession();
  await session.send('Browser.setDownloadBehavior', { behavior: 'allow', downloadPath: out });
  await page.goto(address);
  await viewed(page);
  return page;
}
// Until the first picture is there, after each time that the page was loaded.
export const viewed = (page) => page.evaluate(() => window.vitrine.then((v) => (window.view = v)).then(() => 1));

// use(page): a page of `vitrine view` in a browser without WebGL, which shows the mesh alone.
export async function without_webgl(address, messages, viewport, use) {
  const browser = await open_chromium({ args: ['--disable-3d-apis', '--disable-gpu'] });
  try {
    const page = await browser.newPage();
    watch(page, address, messages);
    await page.setViewport(viewport);
    await page.goto(address);
    await page.evaluate(() => window.vitrine.then(() => 1));
    await use(page);
  } finally {
    await browser.close();
  }
}

// How many pixels of its picture are not the grey of nothing.
export const painted = (page) =>
  page.$eval('#picture', (canvas) => {
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d');
    copy.drawImage(canvas, 0, 0);
    const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) count += data[i] !== 0x77 || data[i + 1] !== 0x77;
    return count;
  });

// Waits until a page has saved files of these names to a folder.
export async function saved(folder, ...names) {
  for (const end = Date.now() + kPatience; !names.every((name) => readdirSync(folder).includes(name)); ) {
    if (Date.now() > end) throw new Error(`${names} did not come to ${folder}, which has ${readdirSync(folder)}`);
    await new Promise((done) => setTimeout(done, 100));
  }
}
