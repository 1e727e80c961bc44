// Writes Radiance HDR maps: RGBE, scanlines from the top, run-length coded per component (widths 8 to 32767).
const kMostRun = 127, kMostDump = 128, kLeastRun = 4;

// The mantissa of the largest channel uses all eight bits: 128 to 255.
function rgbe(out, at, r, g, b) {
  const most = Math.max(r, g, b);
  if (!(most > 1e-32)) return;  // black is all zeros
  let exponent = Math.floor(Math.log2(most)) + 1;
  if (Math.round((most / 2 ** exponent) * 256) > 255) ++exponent;
  const unit = 256 / 2 ** exponent;
  out[at] = Math.round(r * unit), out[at + 1] = Math.round(g * unit), out[at + 2] = Math.round(b * unit), out[at + 3] = exponent + 128;
}

function add_runs(bytes, out) {
  for (let at = 0; at < bytes.length;) {
    let run = 1;
    while (run < kMostRun && at + run < bytes.length && bytes[at + run] === bytes[at]) ++run;
    if (run >= kLeastRun) {
      out.push(128 + run, bytes[at]), (at += run);
      continue;
    }
    // Literal bytes up to the next run.
    let end = at;
    const begins_run = (i) => i + kLeastRun <= bytes.length && [1, 2, 3].every((k) => bytes[i + k] === bytes[i]);
    while (end < bytes.length && end - at < kMostDump && !begins_run(end)) ++end;
    out.push(end - at, ...bytes.subarray(at, end)), (at = end);
  }
}

export function radiance_hdr({ width, height, data }) {
  const head = `#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${height} +X ${width}\n`, parts = [head];
  for (let y = 0; y < height; ++y) {
    const pixels = new Uint8Array(4 * width), out = [2, 2, width >> 8, width & 255];
    for (let x = 0; x < width; ++x) rgbe(pixels, 4 * x, ...data.subarray(3 * (y * width + x), 3 * (y * width + x) + 3));
    for (let c = 0; c < 4; ++c) add_runs(pixels.filter((_, i) => i % 4 === c), out);
    parts.push(Uint8Array.from(out));
  }
  return new Blob(parts, { type: 'image/vnd.radiance' });
}
