// Blending, a block for each tile and a thread for each pixel, in exact depth order per pixel.
//
// The block goes through the list of its tile in batches. The list is sorted by a lower bound of each surfel's depth in the tile,
// so a fragment is final once the bound of the next surfel lies behind it. Until then it waits in a list of the kWaiting nearest,
// sorted by (z, surfel). If the list is full, the farthest is dropped, and with it everything behind it: the pixel takes part in
// another sweep over the tile's list, for what it dropped. No pixel needs more memory than its registers, however many surfels
// lie in one plane. What becomes of the blended fragments is the matter of a sink: planes of the forward pass, or the list of
// fragments that the reverse pass reads.
#pragma once

#include "core/render/raster/blocks/tile_kernels.h"
#include "core/render/raster/kernels/blend.h"

namespace vitrine::blocks {

// Planes are [h, w]; those that are not wanted are null.
struct PixelPlanes {
  float* features[kMaxFeatures];
  float *zdepth, *alpha, *median_z, *distortion;
  uint32_t *fragments, *evaluated;  // of each pixel: blended, and evaluated to find them
};

struct Fragment {
  F32 z, alpha;
  uint32_t instance;
};

// Sums along a pixel. kFeatures: 3, 6 or 12, the number of blended channels.
template <int kFeatures, bool kDistortion>
struct PlaneSink {
  struct Pixel {
    F32 features[kFeatures], zdepth, alpha, median_z, pivot;
    DistortionSums<F32> sums;
    uint32_t fragments;
  };
  PixelPlanes out;

  VITRINE_HD void start(Pixel& p, F32 nearest_z, size_t) const {
    for (F32& f : p.features) f = 0.f;
    p.zdepth = p.alpha = p.median_z = 0.f;
    p.pivot = F32(1.f) / nearest_z;
    p.sums = {0.f, 0.f, 0.f};
    p.fragments = 0;
  }
  VITRINE_HD void add(Pixel& p, const Fragment& f, F32 transmittance, const SurfelRecord& record) const {
    const F32 w = blend_weight(f.alpha, transmittance);
    for (int c = 0; c < kFeatures; ++c) p.features[c] += w * F32(record.features[c]);
    p.zdepth += w * f.z;
    p.alpha += w;
    if (transmittance > F32(kMedianTransmittance)) p.median_z = f.z;
    if constexpr (kDistortion) p.sums.add(w, reciprocal(f.z) - p.pivot);
    ++p.fragments;
  }
  VITRINE_HD void finish(const Pixel& p, const BlockView& view, size_t at, uint32_t evaluated) const {
    const F32 behind = F32(1.f) - p.alpha;
    for (int c = 0; c < kFeatures; ++c) {
      F32 value = p.features[c];
      if (c < 3) value += behind * F32(view.background[c]);
      out.features[c][at] = value.v;
    }
    out.zdepth[at] = p.zdepth.v;
    out.alpha[at] = p.alpha.v;
    out.median_z[at] = p.median_z.v;
    out.fragments[at] = p.fragments;
    out.evaluated[at] = evaluated;
    if constexpr (kDistortion) {
      const F32 k = distortion_scale(F32(view.near_z), F32(view.far_z));
      out.distortion[at] = (k * k * max(F32(0.f), p.sums.value())).v;
    }
  }
};

// Which of the 256 pixels of its tile blend a fragment of an instance, row by row, and so where their fragments stand among those
// of the instance: one after the other, in the order of the pixels.
struct PixelMasks {
  static constexpr uint32_t kWords = BlockView::kTileSide * BlockView::kTileSide / 32;
  uint32_t* words;  // [instances, kWords]

  VITRINE_HD static uint32_t place(uint32_t x, uint32_t y) {
    constexpr uint32_t kSide = BlockView::kTileSide;
    return y % kSide * kSide + x % kSide;
  }
  VITRINE_HD const uint32_t* of(uint32_t instance) const { return words + size_t{kWords} * instance; }
  VITRINE_HD void add(uint32_t instance, uint32_t place) const {
    set_bits(words[size_t{kWords} * instance + place / 32], 1u << place % 32);
  }
  // Fragments of the instance in pixels before `place`.
  VITRINE_HD uint32_t rank(uint32_t instance, uint32_t place) const {
    const uint32_t* w = of(instance);
    uint32_t sum = bit_count(w[place / 32] & ((1u << place % 32) - 1));
    for (uint32_t k = 0; k < place / 32; ++k) sum += bit_count(w[k]);
    return sum;
  }
};

// Blended fragments, pixel by pixel, each pixel in depth order.
struct FragmentList {
  uint32_t* instance;
  float* transmittance;  // in front of it
};

// Lists what PlaneSink blends.
struct FragmentSink {
  struct Pixel {
    uint32_t next, place;
  };
  const uint32_t* offsets;  // of each pixel: the fragments of those before it (sums of PixelPlanes::fragments)
  FragmentList out;
  PixelMasks masks;
  uint32_t width;  // of the picture

  VITRINE_HD void start(Pixel& p, F32, size_t at) const {
    const uint32_t pixel = static_cast<uint32_t>(at);
    p = {offsets[at], PixelMasks::place(pixel % width, pixel / width)};
  }
  VITRINE_HD void add(Pixel& p, const Fragment& f, F32 transmittance, const SurfelRecord&) const {
    out.instance[p.next] = f.instance;
    out.transmittance[p.next++] = transmittance.v;
    masks.add(f.instance, p.place);
  }
  VITRINE_HD void finish(const Pixel&, const BlockView&, size_t, uint32_t) const {}
};

template <class Sink>
struct BlendKernel {
  static constexpr uint32_t kThreads = BlockView::kTileSide * BlockView::kTileSide;
  static constexpr int kWaiting = 8;
  static constexpr float kNowhere = 3e38f;  // depth of no fragment

  struct Shared {
    float constants[kThreads][12];
    float z_low[kThreads];
    uint32_t open[2], again[2];  // some pixel needs the next batch, another sweep; for even and odd batches
  };
  enum class State : uint32_t { Sweeping, Swept, Done };
  struct Thread {
    typename Sink::Pixel pixel;
    F32 transmittance;
    Fragment waiting[kWaiting];
    Fragment first, dropped;  // of this sweep: from `first` on; nothing from `dropped` on
    F32 px, py;
    uint32_t evaluated, position;
    State state;
  };

  BlockView view;
  const uint64_t* keys;     // of the instances, sorted
  const uint32_t* surfels;  // of the instances
  const uint32_t* begin;    // of each tile, into the instances
  const SurfelRecord* records;
  const uint8_t* wanted;  // [h, w]; null: all pixels
  Sink sink;

  // Phases alternate: 2 n loads batch n, 2 n + 1 blends it.
  VITRINE_HD bool has_phase(uint32_t phase, const Shared& shared) const {
    if (phase == 0 || phase % 2 == 1) return true;
    const uint32_t before = (phase / 2 - 1) & 1;
    return shared.open[before] != 0 || shared.again[before] != 0;
  }

  VITRINE_HD void run(uint32_t phase, Place at, Thread& t, Shared& shared) const {
    const uint32_t batch = phase / 2, list_begin = begin[at.block], list_size = begin[at.block + 1] - list_begin;
    if (phase % 2 == 1) {
      blend_batch(t, shared, list_begin, list_size, batch & 1);
      return;
    }
    if (phase == 0)
      start(at, t, list_begin, list_size);
    else if (shared.open[(batch - 1) & 1] != 0)
      t.position += kThreads;
    else
      start_sweep(t, t.dropped);
    if (at.thread == 0) shared.open[batch & 1] = shared.again[batch & 1] = 0;
    const uint32_t i = t.position + at.thread;
    if (i >= list_size) return;
    const uint32_t surfel = surfels[list_begin + i];
    shared.z_low[at.thread] = InstanceKey::depth(keys[list_begin + i]);
    memcpy(shared.constants[at.thread], &records[surfel].constants, sizeof shared.constants[0]);
  }

 private:
  VITRINE_HD void start(Place at, Thread& t, uint32_t list_begin, uint32_t list_size) const {
    constexpr uint32_t kSide = BlockView::kTileSide;
    const uint32_t across = static_cast<uint32_t>(view.tiles_x);
    const uint32_t x = at.block % across * kSide + at.thread % kSide, y = at.block / across * kSide + at.thread / kSide;
    t.transmittance = 1.f;
    t.px = static_cast<float>(x) + 0.5f;
    t.py = static_cast<float>(y) + 0.5f;
    t.evaluated = 0;
    t.state = State::Swept;
    start_sweep(t, {-kNowhere, 0.f, 0});
    if (x >= static_cast<uint32_t>(view.width) || y >= static_cast<uint32_t>(view.height)) {
      t.state = State::Done;
      return;
    }
    sink.start(t.pixel, list_size > 0 ? InstanceKey::depth(keys[list_begin]) : 1.f, pixel_of(t));
    if (wanted != nullptr && wanted[pixel_of(t)] == 0) finish(t);
  }
  // By (z, surfel).
  VITRINE_HD bool in_front(const Fragment& a, const Fragment& b) const {
    return a.z < b.z || (a.z == b.z && a.z < F32(kNowhere) && surfels[a.instance] < surfels[b.instance]);
  }
  VITRINE_HD void start_sweep(Thread& t, const Fragment& first) const {
    t.position = 0;
    if (t.state != State::Swept) return;
    t.first = first;
    t.dropped = {kNowhere, 0.f, 0};
    for (Fragment& f : t.waiting) f = {kNowhere, 0.f, 0};
    t.state = State::Sweeping;
  }

  VITRINE_HD void blend_batch(Thread& t, Shared& shared, uint32_t list_begin, uint32_t list_size, uint32_t parity) const {
    if (t.state == State::Sweeping) {
      const uint32_t left = list_size - t.position, count = left < kThreads ? left : kThreads;
      for (uint32_t j = 0; j < count && t.state == State::Sweeping; ++j) blend_surfel(t, shared, list_begin, j);
      if (t.state == State::Sweeping && left <= kThreads) end_sweep(t);
    }
    if (t.state == State::Sweeping) set_flag(shared.open[parity]);
    if (t.state == State::Swept) set_flag(shared.again[parity]);
  }
  VITRINE_HD void blend_surfel(Thread& t, const Shared& shared, uint32_t list_begin, uint32_t j) const {
    const F32 z_low = shared.z_low[j];
    while (t.waiting[0].z < z_low) blend_nearest(t);
    if (t.transmittance < F32(kMinTransmittance) || t.dropped.z < z_low) {
      end_sweep(t);
      return;
    }
    SplatConstants<float> constants;
    memcpy(&constants, shared.constants[j], sizeof constants);
    const SplatSample<F32> sample = splat_sample(constants, t.px, t.py);
    ++t.evaluated;
    if (!sample.counts) return;
    Fragment f{sample.z, sample.alpha, list_begin + t.position + j};
    if (in_front(f, t.first) || !in_front(f, t.dropped)) return;
    for (Fragment& w : t.waiting)  // insertion: what is behind f moves one back
      if (in_front(f, w)) {
        const Fragment behind = w;
        w = f;
        f = behind;
      }
    if (f.z < F32(kNowhere)) t.dropped = f;
  }
  VITRINE_HD void blend_nearest(Thread& t) const {
    const Fragment f = t.waiting[0];
    for (int k = 0; k + 1 < kWaiting; ++k) t.waiting[k] = t.waiting[k + 1];
    t.waiting[kWaiting - 1] = {kNowhere, 0.f, 0};
    if (t.transmittance >= F32(kMinTransmittance)) sink.add(t.pixel, f, t.transmittance, records[surfels[f.instance]]);
    t.transmittance *= F32(1.f) - f.alpha;
  }
  // All fragments up to the first that was dropped are known.
  VITRINE_HD void end_sweep(Thread& t) const {
    while (t.waiting[0].z < F32(kNowhere)) blend_nearest(t);
    if (t.dropped.z < F32(kNowhere) && t.transmittance >= F32(kMinTransmittance))
      t.state = State::Swept;
    else
      finish(t);
  }
  VITRINE_HD size_t pixel_of(const Thread& t) const {
    return static_cast<size_t>(t.py.v) * static_cast<size_t>(view.width) + static_cast<size_t>(t.px.v);
  }
  VITRINE_HD void finish(Thread& t) const {
    t.state = State::Done;
    sink.finish(t.pixel, view, pixel_of(t), t.evaluated);
  }
};

}  // namespace vitrine::blocks
