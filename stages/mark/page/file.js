// The file of marks: export, saving, opening.
import { download } from '../../page/elements.js';
import { refusals } from './checks.js';
import { marks_of } from './opened.js';
import { read_yaml } from '../../page/yaml.js';
import { yaml_of } from './marks_file.js';

const kFile = 'marks.yaml';

export function yaml_text({ doc, scene }) {
  return yaml_of(doc, (name) => scene.photos.filter((p) => p.name === name).map((p) => [p.width, p.height])[0], scene.command);
}

// Shows first what a run would reject.
export function save(work) {
  const refused = refusals(work.doc, work.scene);
  const write = () => {
    download(kFile, new Blob([yaml_text(work)], { type: 'application/yaml' }));
    work.saved = JSON.stringify(work.doc);
    work.keep();
    work.tell(`Saved as ${kFile}, where this browser puts its downloads. The command to run stands below \u201cFile\u201d.`);
    work.changed();
  };
  if (!refused.length) return write();
  work.tell(`A run would refuse this: ${refused.join(' ')}`, ['Save all the same', write]);
}

function open_text(work, text, name) {
  try {
    const { doc, notes } = marks_of(read_yaml(text), work.scene.photos);
    work.pen.cancel(false);
    const replaced = work.doc.marks.length > 0;
    work.doc = doc, work.selection.clear(), work.thing = doc.things[0]?.id ?? null;
    work.commit();
    const first = work.scene.photos.findIndex((p) => doc.marks.some((m) => m.photo === p.name));
    if (first >= 0) work.show(first);
    work.tell([`${name} is open: ${doc.marks.length} marks.`, ...notes].join(' '), ...(replaced ? [['Back to those before', () => work.undo()]] : []));
  } catch (e) {
    work.tell(`${name} is no file of marks: ${e.message}.`);
  }
}

export async function open_file(work, file) {
  open_text(work, await file.text(), file.name);
}

function dragged(work, e) {
  if (![...(e.dataTransfer?.types ?? [])].includes('Files')) return;
  e.preventDefault();
  document.body.classList.toggle('dropping', e.type === 'dragover');
  if (e.type === 'drop' && e.dataTransfer.files[0]) open_file(work, e.dataTransfer.files[0]);
}

export function take_dropped_files(work) {
  for (const name of ['dragover', 'dragleave', 'drop']) addEventListener(name, (e) => dragged(work, e));
}
