// A page in headless Chromium that draws a file with WebGL.
import { createReadStream, existsSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { extname, join } from 'node:path';
import { open_chromium, software_webgl } from './chromium.mjs';

const types = { '.js': 'text/javascript', '.wasm': 'application/wasm', '.glb': 'model/gltf-binary' };

// Opens the page `source`, which finds `file` at /file and packages below /node_modules/, and ends by setting window.result and, if
// it has drawn anything, window.picture (a data: URI, written to `out`). Prints the result; exit code 1 when it says `error`.
export async function draw(source, file, out) {
  const server = createServer((request, response) => {
    const path = decodeURI(request.url.split('?')[0]);
    if (path === '/') return response.writeHead(200, { 'content-type': 'text/html' }).end(source);
    const packaged = path.startsWith('/node_modules/') && !path.includes('..');
    const local = path === '/file' + extname(file) ? file : packaged ? join('.', path) : '';
    if (!local || !existsSync(local)) return response.writeHead(404).end();
    response.writeHead(200, { 'content-type': types[extname(local)] ?? 'application/octet-stream' });
    createReadStream(local).pipe(response);
  });
  await new Promise((ready) => server.listen(0, '127.0.0.1', ready));
  const browser = await open_chromium({ args: software_webgl });
  try {
    const page = await browser.newPage();
    page.on('console', (m) => m.type() === 'error' && console.error(m.text()));
    await page.goto(`http://127.0.0.1:${server.address().port}/`);
    await page.waitForFunction('window.result');
    const result = await page.evaluate('window.result');
    const picture = await page.evaluate('window.picture');
    if (picture) writeFileSync(out, Buffer.from(picture.split(',')[1], 'base64'));
    console.log(JSON.stringify(result));
    process.exitCode = result.error ? 1 : 0;
  } finally {
    await browser.close();
    server.close();
  }
}
