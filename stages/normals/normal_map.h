// Normal map of one photo in the OpenCV camera frame (a wall facing the camera is 0 0 -1), with a confidence.
#pragma once

#include <filesystem>
#include <optional>

#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"

namespace vitrine {

struct NormalMap {
  ImageF normal;      // [h,w,3], unit; 0 0 0 = unknown
  ImageF confidence;  // [h,w,1] in [0,1]; 0 where unknown

  NormalMap() = default;
  NormalMap(int width, int height) : normal(width, height, 3), confidence(width, height, 1) {}
  bool empty() const { return normal.empty(); }
  Vec3f at(int x, int y) const {
    const float* n = normal.pixel(x, y);
    return {n[0], n[1], n[2]};
  }
  void set(int x, int y, const Vec3f& n, float how_sure) {
    float* p = normal.pixel(x, y);
    p[0] = n.x, p[1] = n.y, p[2] = n.z;
    confidence.at(x, y) = how_sure;
  }
  void forget(int x, int y) { set(x, y, {}, 0); }
};

// Area average weighted by confidence, renormalised; a spread of the normals lowers the confidence.
NormalMap resized(const NormalMap& map, int width, int height);

struct Facing {
  size_t known = 0, away = 0;  // pixels with a normal; those of them facing away from the camera
};
// Removes normals facing away from the camera: no visible surface has them. `k` has the size of the map.
Facing forget_hidden_sides(NormalMap& map, const Intrinsics& k);

// `folder`/<stem>.exr and `folder`/<stem>_confidence.png.
void write_normal_map(const std::filesystem::path& folder, const View& view, const NormalMap& map);

// Normal maps of the user, from any predictor: PNG of 8 or 16 bits with rgb = (n + 1) / 2, or EXR. README.md lists the accepted
// file names.
//
// Path of a photo's map, `folder`/<stem>.exr and the like; nullopt if there is none.
std::optional<std::filesystem::path> find_normal_file(const std::filesystem::path& folder, const View& view);

// Reads a map in the file's frame and size; known pixels have confidence 1, or that of <stem>_confidence.png next to it. Throws
// Error{Input} when it is not a normal map, or has another aspect ratio than the photo.
NormalMap read_normal_file(const std::filesystem::path& file, const View& view);

}  // namespace vitrine
