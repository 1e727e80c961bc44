// Mouse, fingers and keys on a slice.
//   drag            the crosshair                 right button, or shift and drag   grey values: right is softer, up is brighter
//   wheel           the next slice                ctrl and wheel, two fingers       zoom
//   middle button   moves the zoomed slice        double click                      this pane alone, and all again (panes.js)
const kZoomStep = 1.15;
const kWheel = 40;  // screen pixels of the wheel that are one slice
const kKeyZoom = 1.25;
const kWindow = 0.006;  // share of the range from black to white, per screen pixel

export function hold_slice(slice) {
  const { canvas, state } = slice, fingers = new Map();
  let held = null, turned = 0;  // {what, at}; of the wheel, screen pixels

  const point = (e) => {
    const box = canvas.getBoundingClientRect();
    return [e.clientX - box.left, e.clientY - box.top];
  };
  // Zooms so that the place below `at` stays there.
  const zoom = (factor, at) => {
    const before = slice.to_place(at);
    state.set_zoom(state.zoom * factor);
    const after = slice.to_place(at);
    state.set_zoom(state.zoom, state.focus.map((f, c) => f + before[c] - after[c]));
  };
  const pan = (dx, dy) => {
    const { scale } = slice.frame(), focus = [...state.focus];
    focus[slice.right] -= dx / scale, focus[slice.up] += dy / scale;
    state.set_zoom(state.zoom, focus);
  };
  const gesture = () => {
    const [a, b] = [...fingers.values()];
    return { middle: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], span: Math.hypot(a[0] - b[0], a[1] - b[1]) || 1 };
  };

  canvas.addEventListener('pointerdown', (e) => {
    canvas.setPointerCapture(e.pointerId);
    canvas.focus({ preventScroll: true });
    e.preventDefault();
    fingers.set(e.pointerId, point(e));
    const what = fingers.size > 1 ? 'fingers' : e.button === 1 ? 'pan' : e.button === 2 || e.shiftKey ? 'window' : state.measuring ? 'measure' : 'place';
    held = { what, at: point(e), ...(what === 'fingers' ? gesture() : {}) };
    if (what === 'place') state.go(slice.to_place(held.at));
    if (what === 'measure') held.from = slice.to_place(held.at), state.set_measure({ axis: slice.axis, from: held.from, to: held.from });
  });
  canvas.addEventListener('pointermove', (e) => {
    const at = point(e);
    if (!held) return state.hover(slice.to_place(at));
    fingers.set(e.pointerId, at);
    const [dx, dy] = [at[0] - held.at[0], at[1] - held.at[1]];
    if (held.what === 'place') state.hover(null), state.go(slice.to_place(at));
    if (held.what === 'measure') state.set_measure({ axis: slice.axis, from: held.from, to: slice.to_place(at) });
    if (held.what === 'pan') pan(dx, dy);
    if (held.what === 'window') {
      const half = (state.white - state.black) / 2, middle = (state.black + state.white) / 2 + dy * kWindow * half, wider = half * Math.exp(dx * kWindow);
      state.set_window(middle - wider, middle + wider);
    }
    if (held.what === 'fingers' && fingers.size > 1) {
      const now = gesture();
      pan(now.middle[0] - held.middle[0], now.middle[1] - held.middle[1]);
      zoom(now.span / held.span, now.middle);
      Object.assign(held, now);
    }
    held.at = at;
  });
  const release = (e) => {
    fingers.delete(e.pointerId);
    held = null;
  };
  canvas.addEventListener('pointerup', release);
  canvas.addEventListener('pointercancel', release);
  canvas.addEventListener('pointerleave', () => state.hover(null));
  canvas.addEventListener('contextmenu', (e) => e.preventDefault());
  canvas.addEventListener('wheel', (e) => {
    e.preventDefault();
    if (e.ctrlKey || e.metaKey) zoom(e.deltaY < 0 ? kZoomStep : 1 / kZoomStep, point(e));
    else {
      turned += e.deltaMode === 0 ? e.deltaY : e.deltaY * kWheel;
      const steps = Math.trunc(turned / kWheel);
      turned -= steps * kWheel;
      if (steps) state.step(slice.axis, -steps);
    }
  }, { passive: false });
  canvas.addEventListener('keydown', (e) => {
    const step = { ArrowLeft: [slice.right, -1], ArrowRight: [slice.right, 1], ArrowUp: [slice.up, 1], ArrowDown: [slice.up, -1], PageUp: [slice.axis, 1], PageDown: [slice.axis, -1] }[e.key];
    const middle = () => slice.to_screen(state.place);
    if (step) state.step(step[0], step[1] * (e.shiftKey ? 10 : 1));
    else if (e.key === '+' || e.key === '=') zoom(kKeyZoom, middle());
    else if (e.key === '-') zoom(1 / kKeyZoom, middle());
    else if (e.key === '0') state.show_whole();
    else return;
    e.preventDefault();
  });
}
