// The passes as lists of kernels. Forward: projection, places of the instances, instances, sort, lists of tiles, blending.
// Reverse: list of fragments, gradients by pixel, sort by instance, sums by instance, gradients by surfel. Executor is BlockLoops
// or the CUDA launcher: both see the same kernels with the same arguments.
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
    const uint32_t count = executor.read(exclusive_scan(executor, scan_, blended, fragment_offsets_.data(), pixels));
    const FragmentList fragments = list_of(count);
    blend(executor, scene, FragmentSink{fragment_offsets_.data(), fragments});

    fragment_sort_.resize(count);
    launch(executor, count,
           FragmentKeyKernel{fragments.instance, {fragment_sort_.keys.data(), fragment_sort_.values.data()}, count});
    const SortedPairs by_instance = radix_sort(executor, fragment_sort_, count, 0, bits_of(instances_));
    const SweptInstances swept{surfel_of_.data(), records_.data()};
    sums_.resize(instances_);
    for_channels(scene.features, scene.distortion, [&](auto features, auto distortion) {
      launch(executor, pixels,
             PixelReverseKernel<features(), distortion()>{scene.view, swept, fragment_offsets_.data(), blended, fragments, in,
                                                          pixels});
      launch(executor, instances_,
             InstanceReverseKernel<features()>{scene.view, swept, sorted_.values, by_instance, fragments, in, sums_.data(),
                                               instances_, count});
    });
    launch(executor, scene.surfels.count,
           SurfelReverseKernel{scene.surfels, scene.view, records_.data(), sums_.data(), offsets_.data(), instances_, out});
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
  FragmentList list_of(uint32_t count) {
    fragment_instance_.resize(count);
    fragment_pixel_.resize(count);
    for (auto* values : {&transmittance_, &grad_alpha_, &grad_z_}) values->resize(count);
    return {fragment_instance_.data(), fragment_pixel_.data(), transmittance_.data(), grad_alpha_.data(), grad_z_.data()};
  }

  Array<SurfelRecord> records_;
  Array<SplatBounds> bounds_;
  Array<uint32_t> offsets_, owners_, surfel_of_, tile_begin_;
  ScanMemory<Executor> scan_;
  SortMemory<Executor> sort_, fragment_sort_;
  SortedPairs sorted_{};
  uint32_t instances_ = 0;
  Array<uint32_t> fragment_offsets_, fragment_instance_, fragment_pixel_;
  Array<float> transmittance_, grad_alpha_, grad_z_;
  Array<InstanceSums> sums_;
};

}  // namespace vitrine::blocks
