// Writes the file of marks in the format of stages/masks.
import { quoted } from '../../page/yaml.js';

const number = (v) => String(Math.round(10 * v) / 10);  // tenths of a pixel of the original photo

const kWidth = 120;

function wrapped(head, parts) {
  const rows = [];
  let row = head;
  parts.forEach((part, i) => {
    const text = part + (i + 1 < parts.length ? ', ' : ']');
    if (row.length + text.length > kWidth && row.trim()) rows.push(row.trimEnd()), (row = ' '.repeat(head.length));
    row += text;
  });
  return [...rows, row].join('\n');
}

// `size_of`: size of a photo by name; marks of missing photos store their own.
export function yaml_of(doc, size_of, command) {
  const sizes = doc.marks.map((m) => (m.size ?? size_of(m.photo)).join(', ')), count = {};
  for (const s of sizes) count[s] = (count[s] ?? 0) + 1;
  const usual = Object.keys(count).sort((a, b) => count[b] - count[a])[0];
  let out = `# Drawn in the page of vitrine mark. ${command}\n`;
  if (usual) out += `size: [${usual}]\n`;
  out += doc.marks.length ? 'marks:\n' : 'marks: []\n';
  for (const thing of doc.things)
    doc.marks.forEach((m, i) => {
      if (m.thing !== thing.id) return;
      out += `  - photo: ${quoted(m.photo)}\n    class: ${thing.kind}\n`;
      if (thing.name) out += `    thing: ${quoted(thing.name)}\n`;
      if (sizes[i] !== usual) out += `    size: [${sizes[i]}]\n`;
      out += m.box ? `    box: [${m.corners.flat().map(number).join(', ')}]\n`
                   : wrapped('    polygon: [', m.corners.map(([x, y]) => `[${number(x)}, ${number(y)}]`)) + '\n';
    });
  return out;
}
