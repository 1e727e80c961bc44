// Checks of the marks of an object, with the criteria of stages/masks: what is missing, and what a run would reject.
import { kEnough, kWell, problem_of, words_of } from './marks.js';
import { sides } from './sides.js';

// level: none, few (a run rejects it), enough, well. problems: [{ photo, here, text }]. next: a photo worth marking.
export function state_of(doc, thing, scene) {
  const marks = doc.marks.filter((m) => m.thing === thing.id), photo = (name) => scene.photos.find((p) => p.name === name);
  const problems = marks.map((m) => ({ photo: m.photo, here: !!photo(m.photo), text: problem_of(m, photo(m.photo)) })).filter((p) => p.text);
  const twins = doc.things.filter((t) => t.kind === thing.kind && t.name === thing.name);
  if (twins.length > 1) problems.push({ photo: null, text: 'has the class and the name of another one: give each its own name' });
  const here = marks.filter((m) => photo(m.photo)), usable = scene.has_cameras ? here.filter((m) => photo(m.photo).camera) : here;
  const lost = here.length - usable.length;
  const view = scene.has_cameras && usable.length > 0 ? sides(usable, scene) : null;
  const tight = marks.every((m) => !m.box), in_photos = (n) => `${n} photo${n === 1 ? '' : 's'}`;
  const state = { problems, next: view?.next ?? null, marks: marks.length };
  const but = lost ? ` ${in_photos(lost)} of the run ${lost === 1 ? 'has' : 'have'} no camera: what is marked there does not count.` : '';
  if (!usable.length) return { ...state, level: 'none', text: (marks.length ? 'Marked in no photo that has a camera.' : `Not marked yet: draw it in ${kEnough} photos or more.`) + but };
  if (usable.length < kEnough) return { ...state, level: 'few', text: `Marked in one photo. It needs a second one, taken from another side.${but}` };
  if (view?.one_sided) return { ...state, level: 'few', text: `Marked in ${in_photos(usable.length)} that look from the same side: nothing tells how far away it is. It needs one from another side.${but}` };
  if (usable.length < kWell) return { ...state, level: 'enough', text: `Marked in ${in_photos(usable.length)}: enough${scene.has_cameras ? '' : ' if they look from different sides'}. A third one makes its outline tighter.${but}` };
  const more = tight ? (thing.kind === 'transparent' ? 'If it is a box, its box will be found.' : 'Its colours decide near its edge alone.') : 'Outlines in place of boxes make it tighter.';
  return { ...state, level: 'well', text: `Marked in ${in_photos(usable.length)}. ${more}${but}`, next: null };
}

// Sentences about everything that a run would reject: mistakes, and objects with too few marks.
export function refusals(doc, scene) {
  if (!doc.marks.length) return ['Nothing is marked yet.'];
  return doc.things.flatMap((thing) => {
    const { level, text, problems, marks } = state_of(doc, thing, scene), word = words_of(thing);
    const wrong = problems.map((p) => (p.photo ? `${word}: the outline in ${p.photo} ${p.text}.` : `${word} ${p.text}.`));
    return level === 'few' || (level === 'none' && marks > 0) ? [`${word}: ${text}`, ...wrong] : wrong;
  });
}

