#include "core/render/model/opaque_pass.h"

#include <algorithm>

#include "core/foundation/base/parallel.h"

namespace vitrine {

namespace {

constexpr size_t kOpaqueGrain = 1 << 13;  // pixels per parallel chunk

// Whether the twin contributes to a picture.
bool blends(const SplatScene& scene, const ImageOptions& options) {
  if (scene.opaque.size() == 0) return false;
  const ShapeSet* const set = options.shape.set.get();
  return options.opaque.layered < 1 ||
         (set != nullptr && std::ranges::any_of(set->entries, [](const ShapeSet::Entry& e) { return e.layered < 1; }));
}

}  // namespace

std::vector<uint32_t> shapes_shown(const Frame& frame) {
  std::vector<uint32_t> shown(frame.pixel_count(), 0);
  const auto take = [&](const std::vector<uint32_t>& entries) {
    for (size_t i = 0; i < entries.size(); ++i)
      if (entries[i] != 0) shown[i] = entries[i];
  };
  take(frame.coats.entry);
  take(frame.silhouette.shapes);
  for (const SilhouettePixel& p : frame.silhouette.pixels)
    if (p.covered > 0) shown[p.pixel] = p.entry + 1;
  take(frame.sheets.entry);
  return shown;
}

std::span<const float> OpaquePicture::draw(const SplatScene& scene, const View& view, const ImageOptions& options) {
  RasterDesc desc;
  desc.intrinsics = view.intrinsics;
  desc.cam_from_world = view.cam_from_world;
  desc.features = FeatureSet::ColorOnly;
  desc.sh_degree = scene.opaque.sh_degree();
  desc.near_z = options.diffuse.near_z;
  renderer_->forward(scene.opaque, desc, picture_);
  return picture_.plane(Aov::Color);
}

void OpaquePass::forward(const SplatScene& scene, Frame& frame) {
  if (frame.differentiable || !blends(scene, frame.options)) return;
  const ShapeSet* const set = frame.options.shape.set.get();
  const std::vector<uint32_t> shown = shapes_shown(frame);
  const std::span<const float> twin = twin_.draw(scene, *frame.view, frame.options);
  const size_t pixels = frame.pixel_count();
  LayerImages& layers = frame.layers;
  parallel_chunks(pixels, kOpaqueGrain, [&](size_t, size_t first, size_t last) {
    for (size_t pixel = first; pixel < last; ++pixel) {
      const float s =
          shown[pixel] == 0 ? frame.options.opaque.layered : static_cast<float>(set->entries[shown[pixel] - 1].layered);
      for (size_t at = pixel; at < 3 * pixels; at += pixels) {
        const float rest = (1 - s) * twin[at];
        frame.linear[at] = s * frame.linear[at] + rest;
        if (layers.diffuse.empty()) continue;
        for (auto* plane : {&layers.diffuse, &layers.reflection, &layers.transmission}) (*plane)[at] *= s;
        layers.diffuse[at] += rest;
      }
    }
  });
}

}  // namespace vitrine
