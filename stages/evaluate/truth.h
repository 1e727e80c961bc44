// The truth folder: transforms.json, {depth,normal,albedo,transmitted}/<stem>.exr,
// relit/<name>/<stem>.exr with env/<name>.exr, mask/{object,transparent,specular,coated}/<stem>.png,
// mesh.ply and mesh_opaque.ply; every part is optional. Truth maps live in the photo's frame and at their own resolution, our
// renders in the undistorted frame. Both cameras share their centre, so a map is looked up by direction: our pixel -> ray in our
// camera's frame -> turned into that of the truth's camera, by what the alignment leaves between the two -> pixel there (scaled
// to the map's size). A map without a truth camera is taken to show exactly our frame. Nearest sample, never a blend: a mean of
// two depths or two classes is a place that does not exist.
#pragma once

#include <array>
#include <filesystem>
#include <optional>

#include "core/scene/camera/mask_class.h"
#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

// What a truth folder has masks of.
inline constexpr std::array kTruthClasses{MaskClass::Transparent, MaskClass::Specular, MaskClass::Object};

struct TruthPicture {
  ImageF radiance;  // linear
  Intrinsics intrinsics;
  Mat3d truth_from_ours = Mat3d::identity();  // camera frames
};

// The map as a picture of that size: an area average or bilinear.
ImageF at_size(const ImageF& image, const Intrinsics& k);

enum class LookupFrame : unsigned char { Ours, Truths };  // whose camera the given intrinsics belong to

class Truth {
 public:
  // Reads transforms.json when there is one and finds the truth camera of each view by its stem.
  Truth(std::filesystem::path folder, const std::vector<View>& views);

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path transforms_path() const { return folder_ / "transforms.json"; }
  bool has_cameras() const { return has_transforms_; }
  // After the alignment of the cameras: from now on lookups turn rays by what is left between the orientations, up to a few
  // degrees (more is a wrong pose, not a principal point).
  void align(const Similarity& truth_from_ours, const std::vector<View>& views);
  size_t matched_cameras() const;
  const std::optional<View>& camera(size_t view) const { return cameras_[view]; }

  // Maps as seen through `intrinsics` (ours, at render size). nullopt: no such file. Error{Input}: a file that is broken.
  std::optional<ImageF> zdepth(
      size_t view, const Intrinsics& intrinsics,
      LookupFrame frame = LookupFrame::Ours) const;  // along the axis of the camera that looks; truth units, 0 = nothing there
  std::optional<ImageF> normal(size_t view, const Intrinsics& intrinsics) const;  // truth frame, unit; 0 0 0 = nothing there
  std::optional<ImageF> mask(size_t view, MaskClass c, const Intrinsics& intrinsics,
                             LookupFrame frame = LookupFrame::Ours) const;  // 0 or 1
  // 0 or 1: the first surface is a clear coat over paint.
  std::optional<ImageF> coated(size_t view, const Intrinsics& intrinsics) const;
  std::optional<TruthPicture> transmitted(size_t view, const Intrinsics& intrinsics) const;  // the scene without its glass
  std::optional<TruthPicture> albedo(size_t view, const Intrinsics& intrinsics) const;  // linear; of the first opaque surface
  // Under the environment of that name.
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
  std::vector<Mat3d> turns_;  // truth's camera frame from ours
};

// Throws Error{Input} when it has no triangles.
TriMesh read_truth_mesh(const std::filesystem::path& path);

// Nearest sample of `map` along each pixel's ray; 0 outside the map.
ImageF sampled_by_direction(const ImageF& map, const Intrinsics& map_intrinsics, const Intrinsics& ours,
                            const Mat3d& map_from_ours = Mat3d::identity());

}  // namespace vitrine
