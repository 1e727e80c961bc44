// Reader of the truth folder: transforms.json, {depth,normal,albedo,transmitted,clear}/<stem>.exr, relit/<name>/<stem>.exr with
// env/<name>.exr, mask/{object,transparent,specular,coated}/<stem>.png, mesh.ply and mesh_opaque.ply; every part is optional.
// Truth maps have the photo's frame and their own resolution, our renders the undistorted frame. Both cameras share their centre,
// so maps are sampled by direction: our pixel -> ray in our camera's frame -> rotated to the truth camera's frame by the residual
// rotation of the alignment -> pixel there (scaled to the map's size). A map without a truth camera is taken as our frame.
// Nearest sample without interpolation: a mean of two depths or two classes is invalid.
#pragma once

#include <array>
#include <filesystem>
#include <optional>

#include "core/scene/camera/mask_class.h"
#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

// Mask classes of a truth folder.
inline constexpr std::array kTruthClasses{MaskClass::Transparent, MaskClass::Specular, MaskClass::Object};

struct TruthPicture {
  ImageF radiance;  // linear
  Intrinsics intrinsics;
  Mat3d truth_from_ours = Mat3d::identity();  // camera frames
};

// The map resampled to that size: area average or bilinear.
ImageF at_size(const ImageF& image, const Intrinsics& k);

enum class LookupFrame : unsigned char { Ours, Truths };  // camera of the given intrinsics

class Truth {
 public:
  // Reads transforms.json if there is one, and finds the truth camera of each view by its stem.
  Truth(std::filesystem::path folder, const std::vector<View>& views);

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path transforms_path() const { return folder_ / "transforms.json"; }
  bool has_cameras() const { return has_transforms_; }
  // Call after the camera alignment: lookups then apply the residual rotation between the orientations, up to a few degrees (more
  // is a wrong pose, not a principal point).
  void align(const Similarity& truth_from_ours, const std::vector<View>& views);
  size_t matched_cameras() const;
  const std::optional<View>& camera(size_t view) const { return cameras_[view]; }

  // Maps as seen through `intrinsics` (ours, at render size). nullopt: no such file. Error{Input}: a broken file.
  std::optional<ImageF> zdepth(
      size_t view, const Intrinsics& intrinsics,
      LookupFrame frame = LookupFrame::Ours) const;  // along the axis of the viewing camera; truth units, 0 = no surface
  std::optional<ImageF> normal(size_t view, const Intrinsics& intrinsics) const;  // truth frame, unit; 0 0 0 = no surface
  std::optional<ImageF> mask(size_t view, MaskClass c, const Intrinsics& intrinsics,
                             LookupFrame frame = LookupFrame::Ours) const;  // 0 or 1
  // 0 or 1; 1 = the first surface is a clear coat over paint.
  std::optional<ImageF> coated(size_t view, const Intrinsics& intrinsics) const;
  std::optional<TruthPicture> transmitted(size_t view, const Intrinsics& intrinsics) const;  // the scene without its glass
  std::optional<TruthPicture> clear(size_t view, const Intrinsics& intrinsics) const;        // the scene in air
  std::optional<TruthPicture> albedo(size_t view, const Intrinsics& intrinsics) const;  // linear; of the first opaque surface
  // Under the named environment.
  std::optional<TruthPicture> relit(std::string_view name, size_t view, const Intrinsics& intrinsics) const;
  bool has_relit(std::string_view name, size_t view) const;
  bool has_maps(std::string_view kind) const;  // any file below folder/kind
  // mesh_opaque.ply, else mesh.ply, else nullopt.
  std::optional<std::filesystem::path> mesh_path() const;

 private:
  std::optional<ImageF> mask_file(std::string_view kind, size_t view, const Intrinsics& intrinsics, LookupFrame frame) const;
  std::optional<TruthPicture> picture(const std::filesystem::path& kind, size_t view, const Intrinsics& intrinsics) const;
  Mat3d turn(size_t view, LookupFrame frame) const { return frame == LookupFrame::Ours ? turns_[view] : Mat3d::identity(); }
  Intrinsics map_intrinsics(size_t view, const Intrinsics& ours, const ImageF& map, const std::filesystem::path& path) const;

  std::filesystem::path folder_;
  bool has_transforms_ = false;
  std::vector<std::string> stems_;
  std::vector<std::optional<View>> cameras_;
  std::vector<Mat3d> turns_;  // rotation from our camera frame to the truth's
};

// Throws Error{Input} for a mesh without triangles.
TriMesh read_truth_mesh(const std::filesystem::path& path);

// Nearest sample of `map` along each pixel's ray; 0 outside the map.
ImageF sampled_by_direction(const ImageF& map, const Intrinsics& map_intrinsics, const Intrinsics& ours,
                            const Mat3d& map_from_ours = Mat3d::identity());

}  // namespace vitrine
