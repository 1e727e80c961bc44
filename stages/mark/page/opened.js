// Reads marks from a parsed file. Content that cannot be shown is reported, and nothing is lost: marks of missing photos are kept
// unchanged.
import { add_thing, empty_marks, kClasses, mark_in } from './marks.js';

const folded = (text) => text.normalize('NFC').toLowerCase();
const bare = (text) => text.replace(/\.[^./]*$/, '');

// Finds a photo by name: exact, then the end of its path, case-insensitive, without extension; null if none or several match.
function meant(name, photos) {
  const given = name.replaceAll('\\', '/').replace(/^\.\//, '');
  for (const as of [(t) => t, folded, bare, (t) => bare(folded(t))]) {
    const exact = photos.filter((p) => as(p.name) === as(given));
    const ends = photos.filter((p) => as(p.name).endsWith(`/${as(given)}`) || as(given).endsWith(`/${as(p.name)}`));
    for (const found of [exact, ends]) if (found.length === 1) return found[0];
  }
  return null;
}

function numbers(list, count) {
  if (!Array.isArray(list) || list.length !== count) return null;
  const values = list.map((t) => (typeof t === 'string' && t.trim() !== '' ? Number(t) : NaN));
  return values.every(Number.isFinite) ? values : null;
}

function region(mark) {
  if (mark.box) {
    const b = numbers(mark.box, 4);
    return b && b[0] < b[2] && b[1] < b[3] ? { box: true, corners: [[b[0], b[1]], [b[2], b[3]]] } : null;
  }
  const corners = Array.isArray(mark.polygon) ? mark.polygon.map((c) => numbers(c, 2)) : [];
  return corners.length >= 3 && corners.every(Boolean) ? { box: false, corners } : null;
}

// `tree`: maps, lists and strings of a file. Returns { doc, notes }; throws an Error if it is not a file of marks.
export function marks_of(tree, photos) {
  if (!tree || !Array.isArray(tree.marks)) throw new Error('it has no list \u201cmarks\u201d');
  const doc = empty_marks(), notes = [], elsewhere = new Set(), by_name = new Map();
  const usual = numbers(tree.size, 2);
  tree.marks.forEach((mark, i) => {
    const which = `Mark ${i + 1}`, kind = mark?.class;
    if (typeof mark?.photo !== 'string') return notes.push(`${which} names no photo and is left out.`);
    if (!Object.hasOwn(kClasses, kind ?? '')) return notes.push(`${which} (${mark.photo}) has the class \u201c${kind ?? ''}\u201d, which there is not, and is left out.`);
    const drawn = region(mark), size = numbers(mark.size, 2) ?? usual;
    if (!drawn) return notes.push(`${which} (${mark.photo}) has neither a box nor a polygon of three corners and is left out.`);
    if (!size || size[0] <= 0 || size[1] <= 0) return notes.push(`${which} (${mark.photo}) says no size of its photo and is left out.`);
    const name = mark.thing ?? '', key = `${kind} ${name}`;
    if (!by_name.has(key)) by_name.set(key, Object.assign(add_thing(doc, kind), { name }));
    const thing = by_name.get(key).id, photo = meant(mark.photo, photos);
    if (mark_in(doc, thing, photo?.name ?? mark.photo)) return notes.push(`${which} marks the same object twice in ${mark.photo}: the first one stays.`);
    if (!photo) return elsewhere.add(mark.photo), doc.marks.push({ thing, photo: mark.photo, size, ...drawn });
    const [sx, sy] = [photo.width / size[0], photo.height / size[1]];
    if (Math.abs(sx / sy - 1) > 0.01) notes.push(`${which} was drawn on a photo of ${size.join(' x ')}; ${photo.name} has ${photo.width} x ${photo.height}: look whether it fits.`);
    doc.marks.push({ thing, photo: photo.name, box: drawn.box, corners: drawn.corners.map(([x, y]) => [x * sx, y * sy]) });
  });
  if (elsewhere.size) notes.push(`Marks of photos that are not here (${[...elsewhere].join(', ')}) stay in the file.`);
  return { doc, notes };
}
