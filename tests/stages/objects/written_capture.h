// Photos with cameras, and masks, as the stages before leave them.
#pragma once

#include <fmt/format.h>

#include "core/foundation/base/file.h"
#include "core/observe/stereo/silhouette.h"
#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/mask_class.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view_masks.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/image.h"
#include "core/scene/image/ldr.h"

namespace vitrine::test {

// Every pixel: radiance(eye, unit direction), a number or a colour.
template <class Radiance>
ImageF photo_of(const View& view, const Radiance& radiance) {
  const Intrinsics& k = view.intrinsics;
  ImageF out(k.width, k.height, 3);
  const Vec3d eye = view.centre_in_world();
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const Vec3d d = normalized(view.ray(x + 0.5, y + 0.5));
      if constexpr (requires(Vec3f colour) { colour = radiance(eye, d); }) {
        const Vec3f colour = radiance(eye, d);
        for (int c = 0; c < 3; ++c) out.at(x, y, c) = colour[size_t(c)];
      } else {
        for (int c = 0; c < 3; ++c) out.at(x, y, c) = static_cast<float>(radiance(eye, d));
      }
    }
  return out;
}

// photo(view): linear. Photo i is called v<i>.jpg.
template <class Photo>
std::vector<View> write_sfm(const fs::path& sfm, const std::vector<Silhouette>& cameras, const Photo& photo) {
  ColmapModel model;
  Gains gains;
  std::vector<View> views;
  model.cameras.push_back(colmap_pinhole(1, cameras[0].view.intrinsics));
  for (uint32_t v = 0; v < cameras.size(); ++v) {
    View& view = views.emplace_back(cameras[v].view);
    view.name = fmt::format("v{:02}.jpg", v);
    model.images.push_back({v + 1, quaternion(view.cam_from_world.rotation), view.cam_from_world.translation, 1, view.name, {}});
    make_folders(linear_image_path(sfm, view).parent_path());
    write_exr_rgb(linear_image_path(sfm, view), photo(view));
    gains[view.name] = {1, 1, 1};
  }
  write_colmap_model(sfm / "sparse/0", model, ColmapFormat::Binary);
  make_folders(sfm / "sfm");
  write_gains(sfm / "sfm/gains.json", gains);
  write_scene_info(sfm / "scene.json", {});
  return views;
}

// Held-out photos are marked all over: whoever looks at them fails.
inline void write_masks(const fs::path& masks, MaskClass kind, const std::vector<View>& views,
                        const std::vector<Silhouette>& silhouettes) {
  for (uint32_t v = 0; v < views.size(); ++v) {
    const ImageF& value = silhouettes[v].value;
    Image8 mask(value.width(), value.height(), 1, uint8_t(255));
    for (size_t i = 0; !is_heldout(v, 8) && i < mask.data().size(); ++i) mask.data()[i] = value.data()[i] > 0 ? 255 : 0;
    make_folders(view_mask_path(masks, kind, views[v]).parent_path());
    write_ldr(view_mask_path(masks, kind, views[v]), mask);
  }
}

}  // namespace vitrine::test
