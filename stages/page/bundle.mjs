// node page/bundle.mjs STAGE FILE.html: page/page.html with the body, the style and the script of STAGE/page, and all packages inside, and
// their licences. Same sources and lock file, same bytes.
import { readFileSync, writeFileSync } from 'node:fs';
import { build } from 'esbuild';

const [stage, file] = process.argv.slice(2), folder = `${stage}/page`;
const { outputFiles, metafile } = await build({
  entryPoints: [`${folder}/main.js`],
  bundle: true,
  minify: true,
  write: false,
  metafile: true,
  format: 'iife',
  target: 'es2022',
  charset: 'ascii',
  legalComments: 'none',
  loader: { '.glsl': 'text' },
});
const script = outputFiles[0].text.replaceAll('</script', '<\\/script');
const packages = new Set(Object.keys(metafile.inputs).flatMap((path) => path.match(/^node_modules\/((?:@[^/]+\/)?[^/]+)/)?.[1] ?? []));
const licences = [...packages].sort().map((name) => {
  const { version } = JSON.parse(readFileSync(`node_modules/${name}/package.json`));
  return `${name} ${version}\n\n${readFileSync(`node_modules/${name}/LICENSE`, 'utf8')}`;
});
const style = ['page/shared.css', `${folder}/style.css`].map((path) => readFileSync(path, 'utf8')).join('');
const body = readFileSync(`${folder}/body.html`, 'utf8');
const parts = { stage, body, style, script, licences: licences.join('\n').replaceAll('<', '&lt;') };
// A function, since what follows a dollar sign in a string would have a meaning.
writeFileSync(file, readFileSync('page/page.html', 'utf8').replace(/\/\*\{(\w+)\}\*\//g, (_, name) => parts[name]));
