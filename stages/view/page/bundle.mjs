// node bundle.mjs FILE.html: index.html with its style, its script and all packages inside, and their licences. Same sources and
// lock file, same bytes.
import { readFileSync, writeFileSync } from 'node:fs';
import { build } from 'esbuild';

const { outputFiles } = await build({
  entryPoints: ['main.js'],
  bundle: true,
  minify: true,
  write: false,
  format: 'iife',
  target: 'es2022',
  charset: 'ascii',
  legalComments: 'none',
  loader: { '.glsl': 'text' },
});
const script = outputFiles[0].text.replaceAll('</script', '<\\/script');
const licences = Object.keys(JSON.parse(readFileSync('package.json')).dependencies).map((name) => {
  const { version } = JSON.parse(readFileSync(`node_modules/${name}/package.json`));
  return `${name} ${version}\n\n${readFileSync(`node_modules/${name}/LICENSE`, 'utf8')}`;
});
const parts = { style: readFileSync('style.css', 'utf8'), script, licences: licences.join('\n').replaceAll('<', '&lt;') };
// A function, since what follows a dollar sign in a string would have a meaning.
writeFileSync(process.argv[2], readFileSync('index.html', 'utf8').replace(/\/\*\{(\w+)\}\*\//g, (_, name) => parts[name]));
