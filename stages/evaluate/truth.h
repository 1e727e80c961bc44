// The truth folder: transforms.json, {depth,normal}/<stem>.exr, mask/{object,transparent,specular}/<stem>.png, mesh.ply and
// mesh_opaque.ply; every part is optional. Truth maps live in the photo's frame and at their own resolution, our renders in the
// undistorted frame. Both cameras share centre and orientation, so a map is looked up by direction: our pixel -> ray in the
// camera frame -> pixel of the truth camera (scaled to the map's size). A map without a truth camera is taken to show exactly
// our frame. Nearest sample, never a blend: a mean of two depths or two classes is a place that does not exist.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string_view>

#include "core/camera/view.h"
#include "core/image/image.h"

namespace vitrine {

enum class MaskClass : unsigned char { Transparent, Specular, Object };
inline constexpr std::array<MaskClass, 3> kMaskClasses{MaskClass::Transparent, MaskClass::Specular, MaskClass::Object};
constexpr std::string_view name(MaskClass c) {
  constexpr std::string_view names[] = {"transparent", "specular", "object"};
  return names[static_cast<size_t>(c)];
}

struct TruthPicture {
  ImageF radiance;  // linear
  Intrinsics intrinsics;
};

class Truth {
 public:
  // Reads transforms.json when there is one and finds the truth camera of each view by its stem.
  Truth(std::filesystem::path folder, const std::vector<View>& views);

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path transforms_path() const { return folder_ / "transforms.json"; }
  bool has_cameras() const { return has_transforms_; }
  size_t matched_cameras() const;
  const std::optional<View>& camera(size_t view) const { return cameras_[view]; }

  // Maps as seen through `intrinsics` (ours, at render size). nullopt: no such file. Error{Input}: a file that is broken.
  std::optional<ImageF> zdepth(size_t view, const Intrinsics& intrinsics) const;  // truth units, 0 = nothing there
  std::optional<ImageF> normal(size_t view, const Intrinsics& intrinsics) const;  // truth frame, unit; 0 0 0 = nothing there
  std::optional<ImageF> mask(size_t view, MaskClass c, const Intrinsics& intrinsics) const;  // 0 or 1
  std::optional<TruthPicture> transmitted(size_t view, const Intrinsics& intrinsics) const;  // the scene without its glass
  bool has_maps(std::string_view kind) const;                                                // any file below folder/kind
  // mesh_opaque.ply, else mesh.ply, else nullopt.
  std::optional<std::filesystem::path> mesh_path() const;

 private:
  Intrinsics map_intrinsics(size_t view, const Intrinsics& ours, const ImageF& map, const std::filesystem::path& path) const;

  std::filesystem::path folder_;
  bool has_transforms_ = false;
  std::vector<std::string> stems_;
  std::vector<std::optional<View>> cameras_;
};

// Nearest sample of `map` along each pixel's ray; 0 outside the map.
ImageF sampled_by_direction(const ImageF& map, const Intrinsics& map_intrinsics, const Intrinsics& ours);

}  // namespace vitrine
