// Outlines: [[x, y], ...].
const turn = (a, b, c) => (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);

// Sides that cross, by their first corners; sides that only touch do not.
export function crossing(corners) {
  const n = corners.length, end = (i) => corners[(i + 1) % n];
  for (let i = 0; i < n; ++i)
    for (let j = i + 1; j < n; ++j) {
      const a = corners[i], b = end(i), c = corners[j], d = end(j);
      if (turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0) return [i, j];
    }
  return null;
}

export function area(corners) {
  let twice = 0;
  for (let i = 1; i + 1 < corners.length; ++i) twice += turn(corners[0], corners[i], corners[i + 1]);
  return Math.abs(twice) / 2;
}

// Even-odd, as the masks are filled.
export function inside(corners, [x, y]) {
  let odd = false;
  corners.forEach((a, i) => {
    const b = corners[(i + 1) % corners.length];
    if (a[1] <= y !== b[1] <= y && x < a[0] + ((y - a[1]) / (b[1] - a[1])) * (b[0] - a[0])) odd = !odd;
  });
  return odd;
}
