// The forward pass as a list of kernels: projection, offsets of the instances, instances, sort, lists of tiles, blending.
// Executor is BlockLoops or the CUDA launcher; both see the same kernels with the same arguments.
#pragma once

#include "core/render/raster/blocks/blend_kernel.h"
#include "core/render/raster/blocks/tile_kernels.h"

namespace vitrine::blocks {

template <class Executor>
class ForwardPass {
 public:
  // All pointers are into the executor's memory. kept until the next call: work of each pixel, tiles of each surfel.
  template <int kFeatures, bool kDistortion>
  void run(Executor& executor, const SurfelArrays& surfels, const BlockView& view, const uint8_t* wanted,
           const PixelPlanes& out) {
    records_.resize(surfels.count);
    bounds_.resize(surfels.count);
    offsets_.resize(surfels.count);
    executor.launch(ProjectKernel{surfels, view, records_.data(), bounds_.data(), offsets_.data()},
                    blocks_for(surfels.count, ProjectKernel::kThreads));
    const uint32_t* total = exclusive_scan(executor, scan_, offsets_.data(), offsets_.data(), surfels.count);
    instances_ = executor.read(total);
    sort_.resize(instances_);
    const SortedPairs unsorted{sort_.keys.data(), sort_.values.data()};
    executor.launch(InstanceKernel{view, bounds_.data(), offsets_.data(), total, unsorted, surfels.count},
                    blocks_for(surfels.count, InstanceKernel::kThreads));
    uint32_t last_bit = InstanceKey::kTileAt;
    while (last_bit < 64 && (uint64_t{view.tiles()} << InstanceKey::kTileAt) >> last_bit != 0) ++last_bit;
    const SortedPairs sorted = radix_sort(executor, sort_, instances_, InstanceKey::kDropped, last_bit);
    tile_begin_.resize(view.tiles() + size_t{1});
    executor.launch(TileBeginKernel{sorted.keys, tile_begin_.data(), instances_, view.tiles()},
                    blocks_for(view.tiles() + size_t{1}, TileBeginKernel::kThreads));
    executor.launch(
        BlendKernel<kFeatures, kDistortion>{view, sorted.keys, sorted.values, tile_begin_.data(), records_.data(), wanted, out},
        view.tiles());
  }

  // features: the number of blended channels, 3, 6 or 12.
  void run(Executor& executor, const SurfelArrays& surfels, const BlockView& view, int features, bool distortion,
           const uint8_t* wanted, const PixelPlanes& out) {
    if (features == 3)
      distortion ? run<3, true>(executor, surfels, view, wanted, out) : run<3, false>(executor, surfels, view, wanted, out);
    else if (features == 6)
      distortion ? run<6, true>(executor, surfels, view, wanted, out) : run<6, false>(executor, surfels, view, wanted, out);
    else
      distortion ? run<12, true>(executor, surfels, view, wanted, out) : run<12, false>(executor, surfels, view, wanted, out);
  }

  uint32_t instances() const { return instances_; }

 private:
  template <class T>
  using Array = typename Executor::template Array<T>;

  Array<SurfelRecord> records_;
  Array<SplatBounds> bounds_;
  Array<uint32_t> offsets_, tile_begin_;
  ScanMemory<Executor> scan_;
  SortMemory<Executor> sort_;
  uint32_t instances_ = 0;
};

}  // namespace vitrine::blocks
