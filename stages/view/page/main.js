import { WebGLRenderer } from 'three';
import { read_page } from './scene_data.js';
import { Picture } from './picture.js';
import { sky, studio, evening, read_sky } from './sky.js';
const page = await_page();
async function await_page() {
  const page = await read_page();
  const canvas = document.getElementById('picture');
  const renderer = new WebGLRenderer({ canvas, antialias: false, alpha: false, preserveDrawingBuffer: true });
  const picture = new Picture(renderer, page);
  window.page = page; window.picture = picture; window.renderer = renderer; window.skies={studio,evening,read_sky,sky};
  window.ready = true;
}
