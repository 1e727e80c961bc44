// The passes as lists of kernels. Forward: projection, places of the instances, instances, sort, lists of tiles, blending.
// Reverse: list of fragments, their places by instance, gradients by pixel, sums by instance, gradients by surfel. Executor is
// BlockLoops or the CUDA launcher: both see the same kernels with the same arguments.
#pragma once

#include "core/render/raster/blocks/reverse_kernels.h"

namespace vitrine::blocks {

// Calls run(constant of the number of channels, constant of distortion); features: 3, 6 or 12.
template <class Run>
void for_channels(int features, bool distortion, const Run& run) {
  const auto with = [&](auto channels) { distortion ? run(channels, std::true_type()) : run(channels, std::false_type()); };
  if (features == 3)
    with(std::integral_constant<int, 3>());
  else if (features == 6)
    with(std::integral_constant<int, 6>());
  else
    with(std::integral_constant<int, 12>());
}

// A picture that is rendered: all pointers are into the executor's memory.
struct PassScene {
  SurfelArrays surfels;
  BlockView view;
  int features;
  bool distortion;
  const uint8_t* wanted;  // [h, w]; null: all pixels
  VITRINE_HD uint32_t pixels() const { return static_cast<uint32_t>(view.width) * static_cast<uint32_t>(view.height); }
};

template <class Executor>
class PassKernels {
 public:
  void forward(Executor& executor, const PassScene& scene, const PixelPlanes& out) {
    const uint32_t surfels = scene.surfels.count;
    records_.resize(surfels);
    bounds_.resize(surfels);
    offsets_.resize(surfels);
    launch(executor, surfels, ProjectKernel{scene.surfels, scene.view, records_.data(), bounds_.data(), offsets_.data()});
    const uint32_t* total = exclusive_scan(executor, scan_, offsets_.data(), offsets_.data(), surfels);
    instances_ = checked_count(executor.read(total), "pairs of a surfel and a tile");
    sort_.resize(instances_);
    owners_.resize(instances_);
    surfel_of_.resize(instances_);
    const SortedPairs unsorted{sort_.keys.data(), sort_.values.data()};
    launch(executor, surfels,
           InstanceKernel{scene.view, bounds_.data(), offsets_.data(), total, unsorted, owners_.data(), surfels});
    sorted_ = radix_sort(executor, sort_, instances_, InstanceKey::kDropped, InstanceKey::kTileAt + bits_of(scene.view.tiles()));
    launch(executor, instances_, OwnerKernel{sorted_.values, owners_.data(), surfel_of_.data(), instances_});
    tile_begin_.resize(scene.view.tiles() + size_t{1});
    launch(executor, scene.view.tiles() + 1, TileBeginKernel{sorted_.keys, tile_begin_.data(), instances_, scene.view.tiles()});
    for_channels(scene.features, scene.distortion,
                 [&](auto features, auto distortion) { blend(executor, scene, PlaneSink<features(), distortion()>{out}); });
  }

  // Of the last forward(), with the same scene; `blended`: PixelPlanes::fragments that it wrote.
  void reverse(Executor& executor, const PassScene& scene, const uint32_t* blended, const GradientPlanes& in,
               const SurfelGradients& out) {
    const uint32_t pixels = scene.pixels();
    fragment_offsets_.resize(pixels);
    const uint32_t count =
        checked_count(executor.read(exclusive_scan(executor, scan_, blended, fragment_offsets_.data(), pixels)), "fragments");
    list_instance_.resize(count);
    list_transmittance_.resize(count);
    const FragmentList list{list_instance_.data(), list_transmittance_.data()};
    masks_.resize(size_t{PixelMasks::kWords} * instances_);
    const PixelMasks masks{masks_.data()};
    launch(executor, masks_.size(), ClearKernel<uint32_t>{masks_.data(), masks_.size()});
    blend(executor, scene, FragmentSink{fragment_offsets_.data(), list, masks, static_cast<uint32_t>(scene.view.width)});

    instance_offsets_.resize(instances_);
    launch(executor, instances_, MaskCountKernel{masks, instance_offsets_.data(), instances_});
    exclusive_scan(executor, scan_, instance_offsets_.data(), instance_offsets_.data(), instances_);
    fragments_.resize(count);
    const InstanceFragments fragments{instance_offsets_.data(), masks, fragments_.data()};
    const SweptInstances swept{surfel_of_.data(), records_.data()};
    sums_.resize(size_t{InstanceSums::values_of(static_cast<uint32_t>(scene.features))} * instances_);
    for_channels(scene.features, scene.distortion, [&](auto features, auto distortion) {
      launch(executor, pixels,
             PixelReverseKernel<features(), distortion()>{scene.view, swept, fragment_offsets_.data(), blended, list, fragments,
                                                          in, pixels});
      using OfInstances = InstanceReverseKernel<features()>;
      executor.launch(OfInstances{scene.view, swept, sorted_.keys, sorted_.values, fragments, in, sums_.data(), instances_},
                      blocks_for(instances_, OfInstances::kOfBlock));
    });
    launch(executor, scene.surfels.count,
           SurfelReverseKernel{scene.surfels, scene.view, records_.data(), sums_.data(), static_cast<uint32_t>(scene.features),
                               offsets_.data(), instances_, out});
  }

  uint32_t instances() const { return instances_; }

 private:
  template <class T>
  using Array = typename Executor::template Array<T>;

  // One thread for each of `items`.
  template <class Kernel>
  static void launch(Executor& executor, size_t items, const Kernel& kernel) {
    executor.launch(kernel, blocks_for(items, Kernel::kThreads));
  }
  template <class Sink>
  void blend(Executor& executor, const PassScene& scene, const Sink& sink) {
    executor.launch(
        BlendKernel<Sink>{scene.view, sorted_.keys, surfel_of_.data(), tile_begin_.data(), records_.data(), scene.wanted, sink},
        scene.view.tiles());
  }
  static uint32_t bits_of(uint32_t largest) {
    uint32_t bits = 0;
    while (bits < 32 && largest >> bits != 0) ++bits;
    return bits;
  }
  Array<SurfelRecord> records_;
  Array<SplatBounds> bounds_;
  Array<uint32_t> offsets_, owners_, surfel_of_, tile_begin_;
  ScanMemory<Executor> scan_;
  SortMemory<Executor> sort_;
  SortedPairs sorted_{};
  uint32_t instances_ = 0;
  Array<uint32_t> fragment_offsets_, list_instance_, masks_, instance_offsets_;
  Array<float> list_transmittance_, sums_;
  Array<InstanceFragments::Values> fragments_;
};

}  // namespace vitrine::blocks
