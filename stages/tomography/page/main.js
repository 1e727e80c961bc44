// Entry point: reads the volume, opens the four pictures and the panel.
import { button, element } from '../../page/elements.js';
import { Cut } from './cut.js';
import { make_panel } from './panel.js';
import { Slice } from './slice.js';
import { State } from './state.js';
import { read_transfer, Transfer } from './transfer.js';
import { read_volume } from './volume.js';
import { VolumeView } from './volume_view.js';

const kMostBytes = 1e6;  // of a file with a transfer function

const notice = document.getElementById('notice');
function tell(sentence) {
  notice.hidden = !sentence;
  notice.textContent = sentence ?? '';
}

// One of the four pictures alone, and all again.
function make_large(panes) {
  const all = document.getElementById('panes');
  for (const pane of panes) {
    const flip = () => {
      const alone = !pane.classList.contains('alone');
      for (const p of panes) p.classList.toggle('alone', alone && p === pane);
      all.classList.toggle('one', alone);
      for (const p of panes) p.querySelector('.large').setAttribute('aria-pressed', p.classList.contains('alone'));
    };
    const large = button('\u2922', flip, { className: 'large', title: 'alone, or all four' });
    large.setAttribute('aria-label', 'this picture alone, or all four');
    large.setAttribute('aria-pressed', 'false');
    const canvas = pane.querySelector('canvas');
    canvas.addEventListener('dblclick', flip);
    canvas.addEventListener('keydown', (e) => e.key === 'm' && flip());
    pane.append(large);
  }
  all.append(...panes);
}

// A file with a transfer function; one that is none changes nothing.
async function open_transfer(file, transfer) {
  try {
    if (file.size > kMostBytes) throw new Error('it is too large');
    const read = read_transfer(await file.text(), transfer.volume.unit);
    transfer.set(read);
    tell('');
  } catch (e) {
    tell(`\u201c${file.name}\u201d is no transfer function: ${e.message}. Nothing was changed.`);
  }
}

function take_dropped_files(open) {
  for (const name of ['dragover', 'dragleave', 'drop'])
    addEventListener(name, (e) => {
      e.preventDefault();
      document.body.classList.toggle('dropping', e.type === 'dragover');
      const file = e.type === 'drop' && e.dataTransfer?.files[0];
      if (file) open(file);
    });
}

async function open() {
  const volume = await read_volume(), state = new State(volume), transfer = new Transfer(volume), cut = new Cut(volume);
  const slices = [0, 1, 2].map((axis) => new Slice(state, axis)), view = new VolumeView(state, transfer, cut, tell);
  make_large([slices[2].node, view.node, slices[1].node, slices[0].node]);
  const open_file = (file) => open_transfer(file, transfer);
  make_panel({ state, transfer, cut, view, slices, open: open_file });
  take_dropped_files(open_file);
  for (const s of slices) s.draw();
  await view.first_picture;
  return { volume, state, transfer, cut, slices, view };
}

// Interface for tests.
window.vitrine = open().catch((e) => {
  tell(`This page cannot be shown: ${e.message}`);
  throw e;
});
