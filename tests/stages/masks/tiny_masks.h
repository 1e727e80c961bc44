// A capture of three photos on disk, as the sfm stage leaves it, and masks beside it.
#pragma once

#include <cmath>

#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/undistort.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"

namespace vitrine::test {

struct TinySfm {
  ColmapCamera photographed{1, 2, 80, 60, {70, 40, 30, 0.0}};  // SIMPLE_RADIAL
  std::vector<std::string> names{"a.jpg", "left/b.jpg", "left/c.jpg"};
};

inline void write_tiny_sfm(const fs::path& folder, const TinySfm& tiny) {
  const Undistortion u = undistortion(tiny.photographed);
  ColmapModel model;
  model.cameras.push_back(colmap_pinhole(1, u.target));
  Gains gains;
  for (size_t i = 0; i < tiny.names.size(); ++i) {
    const double shift = 0.2 * double(i) - 0.2;
    model.images.push_back({uint32_t(i + 1), {}, {shift, 0, 2}, 1, tiny.names[i], {}});
    View view;
    view.name = tiny.names[i];
    write_exr_rgb(linear_image_path(folder, view), ImageF(u.target.width, u.target.height, 3, 0.3f));
    gains[view.name] = {1, 1, 1};
  }
  write_colmap_model(folder / "sparse/0", model, ColmapFormat::Binary);
  write_gains(folder / "sfm/gains.json", gains);
  write_scene_info(folder / "scene.json", {});
  const nlohmann::json camera{{"id", 1},
                              {"model", colmap_camera_type(tiny.photographed.model_id)->name},
                              {"width", tiny.photographed.width},
                              {"height", tiny.photographed.height},
                              {"params", tiny.photographed.params}};
  write_file(folder / "sfm/lenses.json", nlohmann::json{{"cameras", {{{"photographed", camera}}}}}.dump());
}

// White disk on black, in the middle of the picture unless told otherwise.
inline Image8 disk_mask(int width, int height, double radius, double cx = -1, double cy = -1) {
  if (cx < 0) cx = 0.5 * width, cy = 0.5 * height;
  Image8 mask(width, height, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) mask.at(x, y) = std::hypot(x + 0.5 - cx, y + 0.5 - cy) < radius ? 255 : 0;
  return mask;
}

inline Image8 negative(Image8 mask) {
  for (uint8_t& v : mask.data()) v = uint8_t(255 - v);
  return mask;
}

inline double coverage(const Image8& mask) {
  double sum = 0;
  for (uint8_t v : mask.data()) sum += v;
  return sum / 255 / double(mask.pixel_count());
}

inline double overlap(const Image8& a, const Image8& b) {  // intersection over union at one half
  size_t both = 0, any = 0;
  for (size_t i = 0; i < a.data().size(); ++i) {
    both += a.data()[i] > 127 && b.data()[i] > 127;
    any += a.data()[i] > 127 || b.data()[i] > 127;
  }
  return any == 0 ? 1 : double(both) / double(any);
}

}  // namespace vitrine::test
