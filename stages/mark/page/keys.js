// Keyboard input.
import { save } from './file.js';

const kStep = 40, kNudge = 1;  // screen pixels per arrow key press

export function listen_to_keys(work) {
  addEventListener('keydown', (e) => {
    const act = e.target.closest?.('input, textarea, select') ? null : action(work, e);
    if (!act) return;
    e.preventDefault();
    act();
  });
  addEventListener('keyup', (e) => e.key === ' ' && (work.hand.space = false));
}

// Action of a key, or null.
function action(work, e) {
  const { sheet } = work, centre = [sheet.width / 2, sheet.height / 2], on_button = e.target.closest?.('button, summary, label');
  if (e.ctrlKey || e.metaKey) {
    const k = e.key.toLowerCase();
    if (k === 's') return () => save(work);
    if (k === 'y' || (k === 'z' && e.shiftKey)) return () => work.redo();
    return k === 'z' ? () => work.undo() : null;
  }
  if (e.altKey) return null;
  if (/^[1-9]$/.test(e.key)) return work.doc.things[e.key - 1] ? () => work.choose(work.doc.things[e.key - 1].id) : null;
  const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[e.key];
  if (arrow && (on_button || e.target === document.body || e.target === sheet.canvas)) {
    const by = arrow.map((v) => v * (work.selection.chosen?.corner != null ? kNudge * (e.shiftKey ? 10 : 1) : kStep));
    return work.selection.chosen?.corner != null ? () => work.selection.nudge(...by) : () => sheet.pan(-by[0], -by[1]);
  }
  if ((e.key === 'Enter' || e.key === ' ') && on_button) return null;
  switch (e.key) {
    case 'o': return () => work.set_tool('outline');
    case 'b': return () => work.set_tool('box');
    case 'c': return () => work.set_tool('change');
    case 'n': case 'PageDown': return () => work.show(work.photo_index + 1);
    case 'p': case 'PageUp': return () => work.show(work.photo_index - 1);
    case 'f': case '0': return () => sheet.fit();
    case '+': case '=': return () => sheet.zoom_at(centre, 1.25);
    case '-': return () => sheet.zoom_at(centre, 0.8);
    case 'h': return () => ((work.hidden = !work.hidden), work.changed());
    case 'm': return () => ((work.masks_shown = !work.masks_shown), work.changed());
    case 'Enter': return () => work.pen.close();
    case 'Backspace': case 'Delete': return () => work.delete();
    case ' ': return () => (work.hand.space = true);
    case 'Escape': return () => (work.pen.drawing ? work.pen.cancel() : (work.tell(''), work.selection.select(null, null)));
    default: return null;
  }
}
