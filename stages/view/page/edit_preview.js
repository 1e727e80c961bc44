// Preview of edits in the render buffers: materials, colours, visibility of surfels and shapes. Interreflections, shadows and,
// under the light of the photos, reflections in curved mirrors remain those of the unedited scene.
import { DataUtils } from 'three';
import { kInsideAlbedo } from './surfels.js';
import { is_geometric } from './selection.js';

const half = (v) => DataUtils.toHalfFloat(v);
const byte_of = (v) => Math.round(255 * Math.sqrt(Math.min(1, Math.max(0, v))));

export class EditPreview {
  constructor(picture, page, selection) {
    const t = picture.surfels.textures;
    this.picture = picture, this.scene = page.scene, this.selection = selection, this.blocks = page.blocks;
    // Unique textures: without materials some are shared.
    this.textures = {
      materials: [...new Set([t.materials, t.lit_materials])], weights: [...new Set([t.weights, t.lit_weights])], tints: [t.tints],
      albedo: page.scene.relit ? [t.albedo] : [],
    };
    this.originals = new Map(Object.values(this.textures).flat().map((one) => [one, one.image.data.slice()]));
  }

  // Applies the edits in order to the originals. Returns for each edit the number of surfels that `vitrine edit` would report,
  // and of content behind glass: [{surfels, content}].
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
  // Albedo is clamped to 1; radiance, which is proportional to it, is not.
  tint(i, tint, inside) {
    for (const { image: { data } } of this.textures.tints)
      for (let c = 0; c < 3; ++c) data[4 * i + c] = half(DataUtils.fromHalfFloat(data[4 * i + c]) * tint[c]);
    const unit = inside ? kInsideAlbedo : 1;
    for (const { image: { data } } of this.textures.albedo)
      for (let c = 0; c < 3; ++c) data[4 * i + c] = byte_of(Math.min((data[4 * i + c] / 255) ** 2 * tint[c] * unit, unit) / unit);
  }

  // Shapes whose surfels are mostly deleted (stages/edit/README.md), and their appendages.
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
