// What edits change, in the buffers that the page draws from: materials, colours, and which surfels and shapes are there. Light that
// surfaces send each other, shadows and, as photographed, what curved mirrors show stay those of the scene without edits.
import { DataUtils } from 'three';
import { kInsideAlbedo } from './surfels.js';
import { is_geometric } from './selection.js';

const half = (v) => DataUtils.toHalfFloat(v);
const byte_of = (v) => Math.round(255 * Math.sqrt(Math.min(1, Math.max(0, v))));

export class EditPreview {
  constructor(picture, page, selection) {
    const t = picture.surfels.textures;
    this.picture = picture, this.scene = page.scene, this.selection = selection, this.blocks = page.blocks;
    // Every kind of texture once: without materials some are the same.
    this.textures = {
      materials: [...new Set([t.materials, t.lit_materials])], weights: [...new Set([t.weights, t.lit_weights])], tints: [t.tints],
      albedo: page.scene.relit ? [t.albedo] : [],
    };
    this.originals = new Map(Object.values(this.textures).flat().map((one) => [one, one.image.data.slice()]));
  }

  // Applies the edits in their order to the originals. -> of each the number of surfels that `vitrine edit` would report,
  // and that of content behind glass which it changes: [{surfels, content}].
  show(edits) {
    const { selection } = this;
    for (const [one, data] of this.originals) one.image.data.set(data);
    const gone = new Uint8Array(selection.count), counts = [];
    for (const { select, remove, set } of edits) {
      const chosen = selection.flags_of(select), geometric = is_geometric(select);
      let surfels = 0, content = 0;
      for (let i = 0; i < selection.count; ++i) {
        if (!chosen[i] || gone[i]) continue;
        const inside = selection.is_inside(i);
        if (remove) gone[i] = 1;
        else if (!inside && selection.is_sky(i)) continue;
        if (!inside) ++surfels;
        else if (remove || (set.tint && geometric)) ++content;
        if (remove || i >= selection.drawn) continue;
        if (!inside) this.change(i, set);
        if (set.tint && (!inside || geometric)) this.tint(i, set.tint, inside);
      }
      counts.push({ surfels, content });
    }
    for (const one of this.originals.keys()) one.needsUpdate = true;
    this.picture.leave_out('deleted', gone, this.gone_shapes(gone));
    return counts;
  }

  change(i, { f0, roughness, k_s, tau }) {
    for (const { image: { data } } of this.textures.materials) {
      if (f0) for (let c = 0; c < 3; ++c) data[4 * i + c] = half(f0[c]);
      if (roughness !== undefined) data[4 * i + 3] = half(roughness);
    }
    for (const { image: { data } } of this.textures.weights) {
      if (k_s !== undefined) data[4 * i] = half(k_s);
      if (tau !== undefined) data[4 * i + 1] = half(tau);
    }
  }
  // Albedo ends at 1; radiance, which is proportional to it, does not.
  tint(i, tint, inside) {
    for (const { image: { data } } of this.textures.tints)
      for (let c = 0; c < 3; ++c) data[4 * i + c] = half(DataUtils.fromHalfFloat(data[4 * i + c]) * tint[c]);
    const unit = inside ? kInsideAlbedo : 1;
    for (const { image: { data } } of this.textures.albedo)
      for (let c = 0; c < 3; ++c) data[4 * i + c] = byte_of(Math.min((data[4 * i + c] / 255) ** 2 * tint[c] * unit, unit) / unit);
  }

  // Entries that go with most of the surfels that show them (stages/edit/README.md), and what stands out of those.
  gone_shapes(gone_surfels) {
    const gone = new Set(), { entries } = this.scene.shapes, list = this.blocks.shape_surfel;
    if (!gone_surfels.includes(1)) return gone;
    let at = 0;
    entries.forEach(({ role, parent, surfels }, entry) => {
      let left = 0;
      for (let k = 0; k < surfels; ++k) left += 1 - gone_surfels[list[at + k]];
      at += surfels;
      const stays = surfels > 0 ? 2 * left >= surfels : role === 'sheet';
      if (!stays || gone.has(parent)) gone.add(entry);
    });
    return gone;
  }
}
