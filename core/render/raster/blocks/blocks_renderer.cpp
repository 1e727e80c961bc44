// Renderer "blocks": the table of a layer and the planes of a picture to the arrays of the kernels, and back.
#include <algorithm>
#include <utility>

#include "core/render/raster/blocks/block_pass.h"
#include "core/render/raster/renderer.h"

namespace vitrine {

namespace blocks {
namespace {

BlockView block_view(const RasterDesc& desc, const SplatLayer& layer) {
  const Intrinsics& k = desc.intrinsics;
  const Rigid& pose = desc.cam_from_world;
  BlockView v{};
  v.camera = {F32(k.fx),
              F32(k.fy),
              F32(k.cx),
              F32(k.cy),
              cast<F32>(pose.rotation),
              cast<F32>(pose.translation),
              cast<F32>(inverse(pose).translation)};
  v.near_z = desc.near_z;
  v.far_z = desc.far_z;
  v.low_pass = static_cast<float>(desc.low_pass ? kLowPassInvVariance : kNoLowPass);
  for (size_t c = 0; c < 3; ++c) v.background[c] = desc.background[c];
  v.width = k.width;
  v.height = k.height;
  v.tiles_x = (k.width + BlockView::kTileSide - 1) / BlockView::kTileSide;
  v.tiles_y = (k.height + BlockView::kTileSide - 1) / BlockView::kTileSide;
  v.sh_degree = std::min(desc.sh_degree, layer.sh_degree());
  return v;
}

SurfelArrays surfel_arrays(const SplatLayer& layer, FeatureSet features) {
  const auto at = [&](Attribute a) { return layer.width(a) == 0 ? nullptr : layer.values(a).data(); };
  SurfelArrays s{};
  s.mean = at(Attribute::Mean);
  s.rotation = at(Attribute::Rotation);
  s.log_scale = at(Attribute::LogScale);
  s.opacity = at(Attribute::Opacity);
  s.sh_dc = at(Attribute::ShDc);
  s.sh_rest = at(Attribute::ShRest);
  constexpr Attribute kMaterials[] = {Attribute::F0, Attribute::Roughness, Attribute::SpecularWeight, Attribute::Transmission};
  if (features == FeatureSet::Material)
    for (size_t m = 0; m < 4; ++m) s.material[m] = at(kMaterials[m]);
  s.sh_rest_width = static_cast<uint32_t>(layer.width(Attribute::ShRest));
  s.count = static_cast<uint32_t>(layer.size());
  return s;
}

PixelPlanes pixel_planes(RasterImages& images, const RasterDesc& desc, std::vector<PixelWork>& work) {
  const size_t pixels = desc.intrinsics.pixel_count();
  work.assign(pixels, {});
  PixelPlanes p{};
  size_t feature = 0;
  for (const AovRow& r : kAovs) {
    if (!r.feature || !produces(desc, r.id)) continue;
    for (size_t c = 0; c < static_cast<size_t>(r.width); ++c) p.features[feature++] = images.plane(r.id).data() + c * pixels;
  }
  p.zdepth = images.plane(Aov::ZDepth).data();
  p.alpha = images.plane(Aov::Alpha).data();
  p.median_z = images.plane(Aov::MedianZ).data();
  p.distortion = images.plane(Aov::Distortion).data();
  p.work = work.data();
  return p;
}

class BlocksRenderer final : public Renderer {
 public:
  explicit BlocksRenderer(std::unique_ptr<BlockPass> pass) : pass_(std::move(pass)) {}

  void forward(const SplatLayer& layer, const RasterDesc& desc, RasterImages& out) override {
    check_wanted(desc);
    out.resize(desc);
    const PassInput input{surfel_arrays(layer, desc.features), block_view(desc, layer),
                          static_cast<int>(feature_count(desc.features)), desc.distortion,
                          desc.wanted.empty() ? nullptr : desc.wanted.data()};
    counts_ = {};
    try {
      counts_.instances = pass_->run(input, pixel_planes(out, desc, work_));
    } catch (const ExecutorFailure& e) {
      throw Error(ErrorKind::Device, "the device failed",
                  {.why = e.what(), .hint = "use the renderer cpu", .code = "CUDA_FAILED"});
    }
    for (const PixelWork& w : work_) {
      counts_.fragments += w.fragments;
      counts_.lanes += w.evaluated;
    }
  }
  void backward(const BackwardInput&, SplatLayer&, SurfelStatistics*) override {
    VITRINE_CHECK(false, "the renderer {} has no reverse pass", name());
  }
  RasterCounts counts() const override { return counts_; }
  std::string_view name() const override { return "blocks"; }
  std::string_view numerics_tag() const override { return "cuda-1"; }  // the same on the CPU and on every device

 private:
  std::unique_ptr<BlockPass> pass_;
  std::vector<PixelWork> work_;
  RasterCounts counts_;
};

}  // namespace
}  // namespace blocks

std::unique_ptr<Renderer> make_blocks_renderer(std::unique_ptr<blocks::BlockPass> pass) {
  return std::make_unique<blocks::BlocksRenderer>(std::move(pass));
}

std::unique_ptr<Renderer> make_blocks_renderer(uint64_t shuffle_seed) {
  return make_blocks_renderer(std::make_unique<blocks::ExecutorPass<blocks::BlockLoops>>(blocks::BlockLoops(shuffle_seed)));
}

}  // namespace vitrine
