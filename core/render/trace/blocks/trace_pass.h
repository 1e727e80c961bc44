// Tracing for values in the memory of the host, over any executor, and the tracer "blocks" over it. Includes neither the table of
// a layer nor messages of errors, which nvcc does not compile: blocks_tracer.cpp is between it and Tracer.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "core/render/trace/blocks/trace_reverse_kernels.h"

namespace vitrine::blocks {

// Pointers are of the host. Every function throws ExecutorFailure.
class TracePass {
 public:
  virtual ~TracePass() = default;
  virtual void build(const SurfelBvh& bvh, const SurfelArrays& surfels) = 0;
  // counts: of each ray, the hits that it blends.
  virtual void forward(const RayArrays& rays, const MarchOptions& options, const RayPlanes<float>& out, uint32_t* counts) = 0;
  // The blended hits of rays [first, end) of the last forward(), ray by ray. Returns how many there are; `room` of them are
  // written at most.
  virtual uint32_t list(uint32_t first, uint32_t end, BlendedHit* out, uint32_t room) = 0;

  // A reverse pass: its rays, then their hits in batches, then the gradients.
  virtual void start_reverse(const RayArrays& rays, const MarchOptions& options, const TraceUpstream& upstream,
                             bool with_rays) = 0;
  virtual void reverse(uint32_t first, uint32_t end, const uint32_t* counts, const BlendedHit* hits, uint32_t hit_count) = 0;
  // Writes all values of `out`, and [n, 3] of `origins` and `directions` if start_reverse() was called `with_rays`.
  virtual void finish_reverse(const SurfelGradients& out, float* origins, float* directions) = 0;
};

template <class Executor>
class ExecutorTrace final : public TracePass {
 public:
  explicit ExecutorTrace(const Executor& executor) : executor_(executor) {}

  void build(const SurfelBvh& bvh, const SurfelArrays& here) override {
    const size_t n = here.count, places = bvh.shapes.size();
    scene_.nodes = uploaded(nodes_, bvh.nodes.data(), bvh.nodes.size());
    scene_.shapes = uploaded(shapes_, bvh.shapes.data(), places);
    scene_.surfel_at = uploaded(surfel_at_, bvh.surfel_at.data(), places);
    scene_.place_of = uploaded(place_of_, bvh.place_of.data(), n);
    for (size_t c = 0; c < 3; ++c) {
      scene_.low[c] = bvh.low[c];
      scene_.high[c] = bvh.high[c];
    }
    scene_.node_count = static_cast<uint32_t>(bvh.nodes.size());
    scene_.surfels = here.count;
    scene_.sh_rest_width = here.sh_rest_width;
    scene_.sh_dc = uploaded(values_[0], here.sh_dc, 3 * n);
    scene_.sh_rest = uploaded(values_[1], here.sh_rest, here.sh_rest_width * n);
    surfels_ = here;
    surfels_.mean = uploaded(values_[2], here.mean, 3 * n);
    surfels_.rotation = uploaded(values_[3], here.rotation, 4 * n);
    surfels_.log_scale = uploaded(values_[4], here.log_scale, 2 * n);
    places_ = static_cast<uint32_t>(places);
  }

  void forward(const RayArrays& rays, const MarchOptions& options, const RayPlanes<float>& out, uint32_t* counts) override {
    const size_t n = rays.count;
    rays_ = uploaded_rays(rays);
    options_ = options;
    planes_.resize(9 * n);
    counts_.resize(n);
    float* const p = planes_.data();
    const RayPlanes<float> there{p, p + 6 * n, p + 7 * n, p + 8 * n, p + 3 * n};
    for_degree([&](auto degree) {
      launch(n, TraceKernel<degree()>{scene_, rays_, options_, 0, rays.count, there, counts_.data(), nullptr, nullptr});
    });
    executor_.download(out.color, there.color, 3 * n);
    executor_.download(out.transmittance, there.transmittance, n);
    executor_.download(out.distance, there.distance, n);
    executor_.download(out.first_hit, there.first_hit, n);
    executor_.download(out.normal, there.normal, 3 * n);
    executor_.download(counts, counts_.data(), n);
  }

  // Tracing again is cheaper than memory for as many hits as any ray may have.
  uint32_t list(uint32_t first, uint32_t end, BlendedHit* out, uint32_t room) override {
    const uint32_t n = end - first, count = scan_counts(counts_.data() + first, n);
    if (count > room) return count;
    hits_.resize(count);
    for_degree([&](auto degree) {
      launch(n, TraceKernel<degree()>{scene_, rays_, options_, first, n, {}, nullptr, offsets_.data(), hits_.data()});
    });
    executor_.download(out, hits_.data(), count);
    return count;
  }

  void start_reverse(const RayArrays& rays, const MarchOptions& options, const TraceUpstream& here, bool with_rays) override {
    const size_t n = rays.count;
    rays_ = uploaded_rays(rays);
    options_ = options;
    upstream_.gradients.color = uploaded(upstream_values_[0], here.gradients.color, 3 * n);
    upstream_.gradients.transmittance = uploaded(upstream_values_[1], here.gradients.transmittance, n);
    upstream_.gradients.distance = uploaded(upstream_values_[2], here.gradients.distance, n);
    upstream_.gradients.first_hit = uploaded(upstream_values_[3], here.gradients.first_hit, n);
    upstream_.gradients.normal = uploaded(upstream_values_[4], here.gradients.normal, 3 * n);
    upstream_.error = uploaded(upstream_values_[5], here.error, n);
    ray_gradients_.resize(with_rays ? 6 * n : 0);
    sums_.resize(size_t{SurfelSums::kRow} * places_);
    launch(sums_.size(), ClearKernel<float>{sums_.data(), sums_.size()});
  }

  void reverse(uint32_t first, uint32_t end, const uint32_t* counts, const BlendedHit* hits, uint32_t hit_count) override {
    const uint32_t n = end - first;
    counts_.resize(n);
    executor_.upload(counts_.data(), counts, n);
    scan_counts(counts_.data(), n);
    hits_.resize(hit_count);
    executor_.upload(hits_.data(), hits, hit_count);
    records_.resize(hit_count);
    sort_.resize(hit_count);
    bases_.resize(size_t{kMaxShCoefficients} * n);
    float* const origins = ray_gradients_.size() == 0 ? nullptr : ray_gradients_.data();
    float* const directions = origins == nullptr ? nullptr : origins + size_t{3} * rays_.count;
    for_degree([&](auto degree) {
      launch(n, RayReverseKernel<degree()>{scene_,
                                           rays_,
                                           upstream_,
                                           options_.first_hit_weight,
                                           first,
                                           n,
                                           counts_.data(),
                                           offsets_.data(),
                                           hits_.data(),
                                           records_.data(),
                                           {sort_.keys.data(), sort_.values.data()},
                                           bases_.data(),
                                           origins,
                                           directions});
    });
    add_records(first, hit_count);
  }

  void finish_reverse(const SurfelGradients& out, float* origins, float* directions) override {
    // One array of the executor for each array of the host.
    struct Copy {
      float* SurfelGradients::*field;
      size_t width;
    };
    const Copy copies[] = {{&SurfelGradients::mean, 3},
                           {&SurfelGradients::rotation, 4},
                           {&SurfelGradients::log_scale, 2},
                           {&SurfelGradients::opacity, 1},
                           {&SurfelGradients::sh_dc, 3},
                           {&SurfelGradients::sh_rest, scene_.sh_rest_width},
                           {&SurfelGradients::screen_gradient, 1},
                           {&SurfelGradients::weight, 1},
                           {&SurfelGradients::error, 1}};
    static_assert(sizeof copies / sizeof copies[0] == kResults);
    SurfelGradients there{};
    const size_t n = scene_.surfels, rays = rays_.count;
    for (size_t i = 0; i < kResults; ++i) {
      results_[i].resize(copies[i].width * n);
      there.*copies[i].field = results_[i].data();
    }
    launch(n, TracedSurfelKernel{scene_, surfels_, sums_.data(), there});
    for (size_t i = 0; i < kResults; ++i) executor_.download(out.*copies[i].field, results_[i].data(), copies[i].width * n);
    if (ray_gradients_.size() == 0) return;
    executor_.download(origins, ray_gradients_.data(), 3 * rays);
    executor_.download(directions, ray_gradients_.data() + 3 * rays, 3 * rays);
  }

 private:
  template <class T>
  using Array = typename Executor::template Array<T>;
  static constexpr size_t kResults = 9;

  template <class T>
  const T* uploaded(Array<T>& to, const T* from, size_t size) {
    if (from == nullptr) return nullptr;
    to.resize(size);
    executor_.upload(to.data(), from, size);
    return to.data();
  }
  RayArrays uploaded_rays(const RayArrays& here) {
    const size_t n = here.count;
    return {uploaded(ray_values_[0], here.origins, 3 * n), uploaded(ray_values_[1], here.directions, 3 * n),
            uploaded(ray_values_[2], here.near, n), uploaded(ray_values_[3], here.far, n), here.count};
  }
  // One thread for each of `items`.
  template <class Kernel>
  void launch(size_t items, const Kernel& kernel) {
    executor_.launch(kernel, blocks_for(items, Kernel::kThreads));
  }
  // Their sums before each to offsets_. Returns the sum of all.
  uint32_t scan_counts(const uint32_t* counts, uint32_t n) {
    offsets_.resize(n);
    return checked_count(executor_.read(exclusive_scan(executor_, scan_, counts, offsets_.data(), n)), "hits of a batch of rays");
  }
  // Calls run(constant of the degree of the colours).
  template <class Run>
  void for_degree(const Run& run) const {
    switch (options_.sh_degree) {
      case 0:
        return run(std::integral_constant<int, 0>());
      case 1:
        return run(std::integral_constant<int, 1>());
      case 2:
        return run(std::integral_constant<int, 2>());
      default:
        return run(std::integral_constant<int, 3>());
    }
  }
  void add_records(uint32_t first_ray, uint32_t count) {
    uint32_t bits = 0;
    while (bits < 32 && places_ >> bits != 0) ++bits;
    const SortedPairs pairs = radix_sort(executor_, sort_, count, 0, bits);
    begin_.resize(places_ + size_t{1});
    launch(places_ + size_t{1}, PlaceBeginKernel{pairs.keys, begin_.data(), count, places_});
    run_offsets_.resize(places_);
    launch(places_, RunCountKernel{begin_.data(), run_offsets_.data(), places_});
    const uint32_t run_count =
        executor_.read(exclusive_scan(executor_, scan_, run_offsets_.data(), run_offsets_.data(), places_));
    const RecordRuns runs{begin_.data(), run_offsets_.data()};
    place_of_run_.resize(run_count);
    launch(places_, RunPlaceKernel{runs, place_of_run_.data(), places_});
    run_sums_.resize(size_t{SurfelSums::kRow} * run_count);
    const uint32_t coefficients = static_cast<uint32_t>(sh_coefficient_count(options_.sh_degree));
    executor_.launch(RunSumKernel{{pairs.keys, pairs.values, records_.data(), count},
                                  runs,
                                  place_of_run_.data(),
                                  upstream_,
                                  bases_.data(),
                                  first_ray,
                                  run_count,
                                  coefficients,
                                  run_sums_.data()},
                     blocks_for(run_count, RunSumKernel::kOfBlock));
    executor_.launch(PlaceSumKernel{runs, run_sums_.data(), sums_.data(), places_},
                     blocks_for(places_, PlaceSumKernel::kOfBlock));
  }

  Executor executor_;
  TraceScene scene_{};
  SurfelArrays surfels_{};
  RayArrays rays_{};
  MarchOptions options_{};
  TraceUpstream upstream_{};
  uint32_t places_ = 0;
  Array<BvhNode> nodes_;
  Array<SurfelShape> shapes_;
  Array<uint32_t> surfel_at_, place_of_, counts_, offsets_;
  Array<float> values_[5], ray_values_[4], planes_;
  Array<BlendedHit> hits_;
  Array<float> upstream_values_[6], ray_gradients_, bases_, sums_, run_sums_, results_[kResults];
  Array<HitRecord> records_;
  Array<uint32_t> begin_, run_offsets_, place_of_run_;
  ScanMemory<Executor> scan_;
  SortMemory<Executor> sort_;
};

}  // namespace vitrine::blocks

namespace vitrine {

class Tracer;

// most_hits: that are on the device at a time, but at least those of 64 rays; by default half a gigabyte with their records.
std::unique_ptr<Tracer> make_blocks_tracer(std::unique_ptr<blocks::TracePass> pass, size_t most_hits = size_t{1} << 22);

// On the CPU. seed 0: blocks in parallel. Otherwise blocks, and threads within each phase, run one by one in an order that the
// seed shuffles; the result is the same.
std::unique_ptr<Tracer> make_blocks_tracer(uint64_t shuffle_seed = 0);

// Of the device that use_device() chooses (core/render/raster/device.h): makes its tracers. nullptr: rays are traced on the CPU.
// Returns the one before.
using DeviceTraceMaker = std::unique_ptr<blocks::TracePass> (*)();
DeviceTraceMaker provide_device_tracer(DeviceTraceMaker maker);

// On the CUDA device that CUDA chooses. Only programs that link the target vitrine_cuda have it; throws blocks::ExecutorFailure
// if the machine has none. `kernel_ms`: as of make_cuda_pass().
std::unique_ptr<blocks::TracePass> make_cuda_trace(std::map<std::string, double>* kernel_ms = nullptr);

}  // namespace vitrine
