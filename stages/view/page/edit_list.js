// Edits in the format of `vitrine edit` (stages/edit/README.md):
//   {name, select: 'all' or {class, object, component, box: [6], marks: [{photo, box: [4] or polygon: [[x, y], ...], size}], except},
//    remove, set: {tint: [3], f0: [3], roughness, k_s, tau}}
import { crossing } from '../../page/polygon.js';
import { quoted, read_yaml } from '../../page/yaml.js';

export const kClasses = ['object', 'transparent', 'specular', 'ignore'];
export const kMostTint = 10;
const kSet = { tint: kMostTint, f0: 1, roughness: 1, k_s: 1, tau: 1 };
const kColors = ['tint', 'f0'];

const short = (v) => String(Number(v.toFixed(4)));
const list = (values) => `[${values.map(short).join(', ')}]`;
const map = (pairs) => `{${pairs.map(([key, text]) => `${key}: ${text}`).join(', ')}}`;

function mark_text({ photo, box, polygon, size }) {
  const where = box ? ['box', list(box)] : ['polygon', `[${polygon.map(list).join(', ')}]`];
  return map([['photo', quoted(photo)], ...(size ? [['size', list(size)]] : []), where]);
}
function select_text(select, indent) {
  if (select === 'all') return 'all';
  const { class: kind, object, component, box, marks, except } = select, pairs = [];
  if (kind) pairs.push(['class', kind]);
  if (object) pairs.push(['object', quoted(object)]);
  if (component) pairs.push(['component', short(component)]);
  if (box) pairs.push(['box', list(box)]);
  if (marks) pairs.push(['marks', `[${marks.map((m) => `\n${indent}  ${mark_text(m)}`).join(',')}]`]);
  if (except) pairs.push(['except', select_text(except, `${indent}  `)]);
  return map(pairs);
}

export function edits_yaml(edits) {
  const blocks = edits.map(({ name, select, remove, set }) => {
    const what = remove ? 'delete: true' : `set: ${map(Object.entries(set).map(([key, v]) => [key, Array.isArray(v) ? list(v) : short(v)]))}`;
    return `  - name: ${quoted(name)}\n    select: ${select_text(select, '      ')}\n    ${what}\n`;
  });
  return `# Made in the page of vitrine view: vitrine edit OUT edits.yaml\nedits:\n${blocks.join('')}`;
}

// Reason why `vitrine edit` would reject it; '' if valid.
export function mistake_of({ name, select, remove, set }, count) {
  if (!name.trim()) return 'it has no name';
  if (select !== 'all' && !['class', 'object', 'component', 'box', 'marks'].some((key) => select[key])) return 'it selects nothing yet';
  if (select.marks && select.marks.length === 0) return 'it has no marks yet';
  const crossed = (select.marks ?? []).find(({ polygon }) => polygon && crossing(polygon));
  if (crossed) return `its outline in ${crossed.photo} crosses itself`;
  if (!remove && Object.keys(set).length === 0) return 'it sets nothing yet';
  return count === 0 ? 'it finds nothing' : '';
}

// ---- parsing

function fail(where, what) {
  throw new Error(`${where}: ${what}.`);
}
function only(where, node, keys) {
  if (node === null || typeof node !== 'object' || Array.isArray(node)) fail(where, 'a map is wanted');
  for (const key of Object.keys(node)) if (!keys.includes(key)) fail(where, `\u201c${key}\u201d is not known here; known are ${keys.join(', ')}`);
}
function number(where, text, least, most) {
  const v = Number(text);
  if (typeof text !== 'string' || text.trim() === '' || !(v >= least && v <= most)) fail(where, `a number from ${least} to ${most} is wanted`);
  return v;
}
const far = 1e9;
const numbers = (where, node, count, least = -far, most = far) =>
  Array.isArray(node) && node.length === count ? node.map((v) => number(where, v, least, most)) : fail(where, `${count} numbers are wanted`);

function mark_of(where, node, photos) {
  only(where, node, ['photo', 'box', 'polygon', 'size']);
  const { photo, box, polygon, size } = node;
  if (!photos.includes(photo)) fail(where, `there is no photo \u201c${photo}\u201d`);
  if (!box === !polygon) fail(where, 'a mark has either a box or a polygon');
  if (polygon && !(Array.isArray(polygon) && polygon.length >= 3)) fail(where, 'a polygon has three corners or more');
  return {
    photo, ...(box ? { box: numbers(where, box, 4) } : { polygon: polygon.map((p) => numbers(where, p, 2)) }),
    ...(size ? { size: numbers(where, size, 2, 1) } : {}),
  };
}
function select_of(where, node, photos, objects, outer) {
  if (outer && node === 'all') return 'all';
  only(where, node, ['class', 'object', 'component', 'box', 'marks', ...(outer ? ['except'] : [])]);
  const out = {};
  if ('class' in node) out.class = kClasses.includes(node.class) ? node.class : fail(where, `there is no class \u201c${node.class}\u201d`);
  if ('object' in node) out.object = objects.includes(node.object) ? node.object : fail(where, `there is no object \u201c${node.object}\u201d`);
  if ('component' in node) out.component = number(where, node.component, 1, far);
  if ('box' in node) out.box = numbers(where, node.box, 6);
  if ('marks' in node) out.marks = Array.isArray(node.marks) ? node.marks.map((m) => mark_of(where, m, photos)) : fail(where, 'marks are a list');
  if ('except' in node) out.except = select_of(where, node.except, photos, objects, false);
  return out;
}

// photos, objects: their names. Throws Error with a message for the user.
export function edits_of(text, photos, objects) {
  const root = read_yaml(text);
  only('at its top', root, ['edits']);
  if (!Array.isArray(root.edits)) fail('at its top', 'edits are a list');
  return root.edits.map((node, i) => {
    const where = `edit ${i + 1}`;
    only(where, node, ['name', 'select', 'set', 'delete']);
    if (('set' in node) === ('delete' in node)) fail(where, 'it has either \u201cset\u201d or \u201cdelete: true\u201d');
    if ('delete' in node && node.delete !== 'true') fail(where, '\u201cdelete\u201d is either true or left out');
    const out = { name: String(node.name ?? where), select: select_of(where, node.select, photos, objects, true), remove: node.delete === 'true', set: {} };
    if ('set' in node) only(where, node.set, Object.keys(kSet));
    for (const [key, v] of Object.entries(node.set ?? {})) {
      const one = kColors.includes(key) && Array.isArray(v) ? numbers(where, v, 3, 0, kSet[key]) : number(where, v, 0, kSet[key]);
      out.set[key] = kColors.includes(key) && !Array.isArray(one) ? [one, one, one] : one;
    }
    return out;
  });
}
