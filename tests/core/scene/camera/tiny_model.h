// A small COLMAP model with everything that a file can hold: several camera models, names in sub-folders, names with spaces
// and non-ASCII letters, images without points, tracks.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "core/foundation/base/rng.h"
#include "core/scene/camera/colmap_model.h"

namespace vitrine::test {

// A damaged file in place of a good one. Removed first: truncating a file makes some file systems wait for the disk.
inline void replace_file(const std::filesystem::path& path, const std::string& bytes) {
  std::filesystem::remove(path);
  std::ofstream(path, std::ios::binary) << bytes;
}

inline ColmapModel tiny_model(uint64_t seed = 1, int image_count = 5, int point_count = 12) {
  Rng rng(seed);
  ColmapModel m;
  m.cameras = {{1, 1, 640, 480, {500.25, 501, 320.5, 240}},
               {2, 2, 640, 480, {510, 320, 240, -0.031}},
               {4, 4, 800, 600, {700, 701, 400, 300, 0.1, -0.05, 0.001, -0.002}}};
  const char* const names[] = {"a.jpg", "left/b.jpg", "with space.png",
                               "gr\xc3\xb6\xc3\x9f"
                               "e/\xe5\x86\x99\xe7\x9c\x9f.jpg"};
  for (int i = 0; i < image_count; ++i) {
    ColmapImage image;
    image.id = static_cast<uint32_t>(3 * i + 1);
    image.rotation = normalized(Quatd{rng.normal(), rng.normal(), rng.normal(), rng.normal()});
    image.translation = {rng.normal(), rng.normal(), 3.0 + rng.uniform_double()};
    image.camera_id = m.cameras[static_cast<size_t>(i) % 3].id;
    image.name = i < 4 ? names[i] : "image_" + std::to_string(i) + ".png";
    m.images.push_back(image);
  }
  for (int k = 0; k < point_count; ++k) {
    ColmapPoint3D p;
    p.id = static_cast<uint64_t>(7 * k + 2);
    p.position = {rng.normal(), rng.normal(), rng.normal()};
    p.srgb = {static_cast<uint8_t>(rng.below(256)), static_cast<uint8_t>(rng.below(256)), static_cast<uint8_t>(rng.below(256))};
    p.error_px = rng.uniform_double();
    for (int i = 0; i + 1 < image_count; ++i) {  // the last image stays without points
      if (rng.uniform() < 0.4f) continue;
      ColmapImage& image = m.images[static_cast<size_t>(i)];
      p.track.push_back({image.id, static_cast<uint32_t>(image.points.size())});
      image.points.push_back({rng.uniform_double() * 640, rng.uniform_double() * 480, p.id});
      if (rng.uniform() < 0.3f) image.points.push_back({rng.uniform_double() * 640, 1.0 / 3.0, kNoPoint3D});
    }
    m.points.push_back(p);
  }
  return m;
}

}  // namespace vitrine::test
