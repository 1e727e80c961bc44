// State of the page in the fragment of its address, so that a link restores the view:
//   #mode=relit&light=studio&turn=30&sky=0.5&lamps=-50,40,12,3,ffffff,1&exposure=0.5&background=1&eye=1,0,0.2&target=0,0,0&photo=IMG_0001.jpg
// Other parts of the page add their own entries.
import { lamps_of, lamps_text } from './lamps.js';

const numbers = (text) => text?.split(',').map(Number);
const share = (v) => (v >= 0 && v <= 1 ? v : undefined);
const valid = (list) => (list?.length === 3 && list.every(Number.isFinite) ? list : undefined);

export function read_state() {
  const q = new URLSearchParams(location.hash.slice(1)), number = (name) => (q.has(name) && Number.isFinite(Number(q.get(name))) ? Number(q.get(name)) : undefined);
  return {
    query: q, mode: q.get('mode') ?? undefined, light: q.get('light') ?? undefined, turn: number('turn'), sky: share(number('sky')),
    lamps: q.has('lamps') ? lamps_of(q.get('lamps')) : undefined, exposure: number('exposure'),
    background: q.has('background') ? q.get('background') !== '0' : undefined, photo: q.get('photo'),
    eye: valid(numbers(q.get('eye'))), target: valid(numbers(q.get('target'))),
  };
}

export function write_state({ mode, light, turn, sky, lamps, exposure, background }, eye, target, photo, more = []) {
  const place = (p) => p.map((v) => v.toFixed(4)).join(',');
  const q = new URLSearchParams({ mode, light, turn, exposure, background: background ? 1 : 0, eye: place(eye), target: place(target) });
  if (sky !== 1) q.set('sky', sky);
  if (lamps.length) q.set('lamps', lamps_text(lamps));
  if (photo) q.set('photo', photo);
  for (const [name, value] of more) q.append(name, value);
  history.replaceState(null, '', `#${q}`);
}
