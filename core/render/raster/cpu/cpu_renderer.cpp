// Renderer "cpu": tiles, SIMD, threads (README 6-8).
#include "core/render/raster/renderer.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/plain_array.h"
#include "core/render/raster/cpu/binning.h"
#include "core/render/raster/cpu/raster_pass.h"
#include "core/render/raster/kernels/blend.h"
#include "core/render/raster/kernels/shade.h"

namespace vitrine {

namespace {

using namespace cpu;
static_assert(kMaxFeatureSlots == kMaxFeatures);

constexpr size_t kProjectChunk = 512;    // surfels
constexpr size_t kGradientBatches = 16;  // SIMD batches per task

struct ThreadScratch {
  PlainArray<RasterSplat> local;
  PlainArray<uint32_t> list, sorted;
  PlainArray<float> z_min, sorted_z, pixels;
  PlainArray<unsigned char> slots;
};

struct TileLists {  // per-tile state kept by forward
  std::vector<uint32_t> seen;
  std::array<uint32_t, kBlocks + 1> offset{};
  std::array<uint32_t, 2> fragments{};
};

template <class Layer>
LayerPointers pointers(Layer& layer) {
  const auto at = [&](Attribute a) { return const_cast<float*>(layer.values(a).data()); };
  const bool materials = layer.width(Attribute::F0) > 0;
  return {at(Attribute::Mean),
          at(Attribute::Rotation),
          at(Attribute::LogScale),
          at(Attribute::Opacity),
          at(Attribute::ShDc),
          at(Attribute::ShRest),
          {materials ? at(Attribute::F0) : nullptr, materials ? at(Attribute::Roughness) : nullptr,
           materials ? at(Attribute::SpecularWeight) : nullptr, materials ? at(Attribute::Transmission) : nullptr},
          static_cast<int>(layer.width(Attribute::ShRest))};
}

PassView pass_view(const RasterDesc& desc, const SplatLayer& layer) {
  const Intrinsics& k = desc.intrinsics;
  const Vec3d eye = inverse(desc.cam_from_world).translation;
  PassView v{};
  v.fx = static_cast<float>(k.fx);
  v.fy = static_cast<float>(k.fy);
  v.cx = static_cast<float>(k.cx);
  v.cy = static_cast<float>(k.cy);
  for (size_t c = 0; c < 3; ++c) {
    for (size_t r = 0; r < 3; ++r) v.rotation[3 * c + r] = static_cast<float>(desc.cam_from_world.rotation(r, c));
    v.translation[c] = static_cast<float>(desc.cam_from_world.translation[c]);
    v.eye[c] = static_cast<float>(eye[c]);
    v.background[c] = desc.background[c];
  }
  v.near_z = desc.near_z;
  v.far_z = desc.far_z;
  v.low_pass = static_cast<float>(desc.low_pass ? kLowPassInvVariance : kNoLowPass);
  v.width = k.width;
  v.height = k.height;
  v.sh_degree = std::min(desc.sh_degree, layer.sh_degree());
  v.features = static_cast<int>(feature_count(desc.features));
  v.distortion = desc.distortion;
  return v;
}

// Missing planes are null. Their size must be that of the last forward().
template <class Images>
auto planes_of(Images& images, size_t features) {
  using Plane = decltype(images.plane(Aov::Color).data());
  const auto plane = [&](Aov a) { return images.plane(a).empty() ? nullptr : images.plane(a).data(); };
  TilePlanes<Plane> out{};
  size_t feature = 0;
  for (const AovRow& r : kAovs) {
    if (!r.feature) continue;
    const size_t pixels = images.plane(r.id).size() / static_cast<size_t>(r.width);
    for (size_t c = 0; c < static_cast<size_t>(r.width) && feature < features; ++c)
      out.features[feature++] = plane(r.id) ? plane(r.id) + c * pixels : nullptr;
  }
  out.zdepth = plane(Aov::ZDepth);
  out.alpha = plane(Aov::Alpha);
  out.median_z = plane(Aov::MedianZ);
  out.distortion = plane(Aov::Distortion);
  return out;
}

class CpuRenderer final : public Renderer {
 public:
  explicit CpuRenderer(const PassTable& passes) : passes_(passes) {}

  void forward(const SplatLayer& layer, const RasterDesc& desc, RasterImages& out) override;
  void backward(const BackwardInput& input, SplatLayer& grad, SurfelStatistics* statistics) override;
  RasterCounts counts() const override;
  std::string_view name() const override { return "cpu"; }
  std::string_view numerics_tag() const override { return passes_.tag; }

 private:
  void project();
  TileTask tile_task(size_t tile, ThreadScratch& scratch, size_t slot_bytes);

  const PassTable& passes_;
  const SplatLayer* layer_ = nullptr;
  RasterDesc desc_;
  PassView view_{};
  WantedPixels wanted_;
  PlainArray<RasterSplat> splats_;
  PlainArray<SplatBounds> bounds_;
  std::vector<uint32_t> chunk_size_, visible_;
  TileBinning binning_;
  std::vector<TileLists> lists_;
  PlainArray<float> kept_, records_;
};

ThreadScratch& thread_scratch() {
  static thread_local ThreadScratch scratch;
  return scratch;
}

void CpuRenderer::project() {
  const size_t n = layer_->size();
  splats_.resize(n);
  bounds_.resize(n);
  chunk_size_.assign(chunk_count(n, kProjectChunk), 0);
  const LayerPointers values = pointers(*layer_);
  parallel_chunks(n, kProjectChunk, [&](size_t chunk, size_t begin, size_t end) {
    chunk_size_[chunk] = passes_.project(values, view_, static_cast<uint32_t>(begin), static_cast<uint32_t>(end - begin),
                                         splats_.data() + begin, bounds_.data() + begin);
  });
  visible_.clear();
  for (size_t chunk = 0; chunk < chunk_size_.size(); ++chunk) {
    for (uint32_t i = 0; i < chunk_size_[chunk]; ++i) {
      const uint32_t at = static_cast<uint32_t>(chunk * kProjectChunk) + i;
      if (wanted_.all() || wanted_.meets(bounds_[at])) visible_.push_back(at);
    }
  }
}

TileTask CpuRenderer::tile_task(size_t tile, ThreadScratch& scratch, size_t slot_bytes) {
  const uint32_t count = binning_.tile_size(tile);
  scratch.local.resize(count);
  scratch.slots.resize(static_cast<size_t>(count + kSpareSlots) * slot_bytes);
  TileTask task{};
  task.x0 = static_cast<int>(tile % static_cast<size_t>(binning_.tiles_x())) * kTileSide;
  task.y0 = static_cast<int>(tile / static_cast<size_t>(binning_.tiles_x())) * kTileSide;
  task.instances = binning_.instances() + binning_.tile_begin(tile);
  task.count = count;
  task.splats = splats_.data();
  task.bounds = bounds_.data();
  task.kept = kept_.data() + tile * static_cast<size_t>(kBlocks * kLanes * view_.kept_channels());
  task.wanted = wanted_.all() ? nullptr : wanted_.pixels(tile);
  task.wanted_blocks = wanted_.all() ? static_cast<uint16_t>(~0u) : wanted_.blocks(tile);
  scratch.pixels.resize(kMaxChannels * kBlocks * kLanes);
  task.pixels = scratch.pixels.data();
  task.local = scratch.local.data();
  task.slots = scratch.slots.data();
  return task;
}

void CpuRenderer::forward(const SplatLayer& layer, const RasterDesc& desc, RasterImages& out) {
  VITRINE_CHECK(desc.features != FeatureSet::Material || layer.width(Attribute::F0) > 0, "layer '{}' has no materials to blend",
                vitrine::name(layer.kind()));
  check_wanted(desc);
  layer_ = &layer;
  desc_ = desc;
  view_ = pass_view(desc, layer);
  wanted_.build(desc.wanted, view_.width, view_.height);
  project();
  binning_.build(visible_, bounds_.data(), wanted_, view_.width, view_.height);
  const size_t tiles = binning_.tile_count();
  lists_.resize(tiles);
  kept_.resize(tiles * static_cast<size_t>(kBlocks * kLanes * view_.kept_channels()));
  out.resize(desc);
  const TileImages images = planes_of(out, static_cast<size_t>(view_.features));
  parallel_for(tiles, 1, [&](size_t tile) {
    ThreadScratch& scratch = thread_scratch();
    TileTask task = tile_task(tile, scratch, passes_.forward_slot_bytes);
    const size_t capacity = list_capacity(task.count);
    scratch.list.resize(capacity * kBlocks);
    scratch.z_min.resize(capacity * kBlocks);
    scratch.sorted.resize(capacity);
    scratch.sorted_z.resize(capacity);
    std::array<uint32_t, kBlocks + 1> offset;
    std::array<uint32_t, kBlocks> size;
    task.list = scratch.list.data();
    task.z_min = scratch.z_min.data();
    task.sorted = scratch.sorted.data();
    task.sorted_z = scratch.sorted_z.data();
    task.list_offset = offset.data();
    task.list_size = size.data();
    TileLists& keep = lists_[tile];
    keep.fragments = {};
    task.fragments = keep.fragments.data();
    passes_.forward_tile(view_, task, images);
    keep.seen.clear();
    for (size_t b = 0; b < kBlocks; ++b) {
      keep.offset[b] = static_cast<uint32_t>(keep.seen.size());
      keep.seen.insert(keep.seen.end(), task.list + offset[b], task.list + offset[b] + size[b]);
    }
    keep.offset[kBlocks] = static_cast<uint32_t>(keep.seen.size());
  });
}

RasterCounts CpuRenderer::counts() const {
  RasterCounts c;
  if (layer_ == nullptr) return c;
  c.surfels = visible_.size();
  c.instances = binning_.instance_count();
  for (const TileLists& tile : lists_) {
    c.fragments += tile.fragments[0];
    c.lanes += static_cast<uint64_t>(tile.fragments[1]) * kLanes;
  }
  return c;
}

void CpuRenderer::backward(const BackwardInput& input, SplatLayer& grad, SurfelStatistics* statistics) {
  VITRINE_CHECK(layer_ != nullptr && input.gradients != nullptr, "backward needs a forward pass and gradients");
  VITRINE_CHECK(grad.size() == layer_->size() && grad.kind() == layer_->kind(), "gradient and layer differ in shape");
  TileGradients gradients{{planes_of(*input.gradients, static_cast<size_t>(view_.features))}, nullptr, nullptr};
  gradients.error = input.error_image.empty() ? nullptr : input.error_image.data();

  records_.resize(binning_.instance_count() * kRecordFloats);
  parallel_for(binning_.tile_count(), 1, [&](size_t tile) {
    if (binning_.tile_size(tile) == 0) return;
    TileTask task = tile_task(tile, thread_scratch(), passes_.backward_slot_bytes);
    task.list = lists_[tile].seen.data();
    task.list_offset = lists_[tile].offset.data();
    TileGradients of_tile = gradients;
    of_tile.records = records_.data() + static_cast<size_t>(binning_.tile_begin(tile)) * kRecordFloats;
    passes_.backward_tile(view_, task, of_tile);
  });

  if (statistics) {
    for (auto* v : {&statistics->screen_gradient, &statistics->weight, &statistics->error}) v->resize(layer_->size(), 0.f);
  }
  const LayerPointers values = pointers(*layer_), out = pointers(grad);
  const size_t n = visible_.size();
  parallel_for(chunk_count(n, kLanes), kGradientBatches, [&](size_t batch) {
    const size_t begin = batch * kLanes;
    GradientTask task{};
    task.values = &values;
    task.grad = &out;
    task.splats = splats_.data();
    task.batch = visible_.data() + begin;
    task.count = static_cast<uint32_t>(std::min<size_t>(kLanes, n - begin));
    task.available = static_cast<uint32_t>(n - begin);
    task.rank = binning_.rank();
    task.record_begin = binning_.surfel_begin();
    task.record_index = binning_.instance_of_surfel();
    task.records = records_.data();
    task.screen_gradient = statistics ? statistics->screen_gradient.data() : nullptr;
    task.weight = statistics ? statistics->weight.data() : nullptr;
    task.error = statistics ? statistics->error.data() : nullptr;
    passes_.gradients(view_, task);
  });
}

}  // namespace

bool machine_has(Simd simd) {
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  const bool avx512 = avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
  return simd == Simd::Avx512 ? avx512 : avx2;
}

std::unique_ptr<Renderer> make_cpu_renderer(Simd simd) {
  if (simd == Simd::Best) {
    const char* wish = std::getenv("VITRINE_SIMD");
    const std::string_view word = wish ? wish : "";
    if (!word.empty() && word != "avx2" && word != "avx512")
      throw Error(ErrorKind::Usage, "VITRINE_SIMD must be avx2 or avx512",
                  {.why = "it is '" + std::string(word) + "'", .hint = "unset VITRINE_SIMD", .code = "BAD_SIMD"});
    simd = word == "avx2" ? Simd::Avx2 : word == "avx512" || machine_has(Simd::Avx512) ? Simd::Avx512 : Simd::Avx2;
  }
  if (!machine_has(simd))
    throw Error(ErrorKind::Device, "this processor lacks the requested instruction set",
                {.where = simd == Simd::Avx512 ? "avx512" : "avx2", .hint = "unset VITRINE_SIMD", .code = "NO_SIMD"});
  return std::make_unique<CpuRenderer>(simd == Simd::Avx512 ? avx512_passes() : avx2_passes());
}

}  // namespace vitrine
