// Entry point: checks the browser's capabilities and opens the view and the panel.
import { ClipPlane, clip_section } from './clip_plane.js';
import { read_page } from './scene_data.js';
import { show_mesh } from './mesh_canvas.js';
import { Objects, objects_section } from './objects.js';
import { read_state } from './url_state.js';
import { View } from './view.js';
import { make_panel } from './panel.js';

const notice = document.getElementById('notice');
export function tell(sentence) {
  notice.hidden = !sentence;
  notice.textContent = sentence ?? '';
}

// Reason why surfels cannot be rendered; empty if they can.
function missing() {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (!gl) return 'This browser has no WebGL2';
  const there = gl.getExtension('EXT_color_buffer_float') && gl.getParameter(gl.MAX_DRAW_BUFFERS) >= 4;
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return there ? '' : 'This browser cannot draw into floating-point textures';
}

async function open() {
  const page = await read_page();
  const why = missing();
  if (why) {
    const panel = document.getElementById('panel'), clip = new ClipPlane(page.scene.middle, page.blocks.mesh_position ?? []);
    const objects = new Objects(page.scene.objects);
    for (const part of [clip, objects]) part.restore(read_state().query);
    const shown = show_mesh(document.getElementById('picture'), page, clip, objects);
    tell(`${why}: ${shown ? 'the mesh alone is shown, in its plain colours' : 'and the scene has no mesh to show instead'}.`);
    if (!shown) panel.remove();
    else {
      const { nodes, show } = clip_section(clip, page.scene.metres_per_unit === 1 ? ' m' : '', () => shown.position.toArray()), draw = clip.on_change;
      clip.on_change = () => (draw(), show());
      panel.append(...nodes, ...objects_section(objects).nodes);
    }
    return { mesh_alone: true, page };
  }
  const view = new View(page, tell);
  make_panel(view, page);
  if (page.scene.left_out > 0)
    tell(`This page leaves out ${page.scene.left_out} surfels that show little: the scene has ${page.scene.drawn + page.scene.left_out}, and the page draws ${page.scene.drawn}.`);
  await view.first_picture;
  return view;
}

// Interface for tests.
window.vitrine = open().catch((e) => {
  tell(`This page cannot be shown: ${e.message}`);
  throw e;
});
