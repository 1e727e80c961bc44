// What the stage leaves for the others: undistorted pictures and cameras, and the report.
#pragma once

#include <functional>
#include <span>

#include "core/intake/photos/photo_list.h"
#include "core/scene/camera/undistort.h"
#include "stages/sfm/normalize.h"
#include "stages/sfm/object_poses.h"
#include "stages/sfm/point_filter.h"
#include "stages/sfm/reconstruct.h"

namespace vitrine {

struct PicturesDesc {
  std::filesystem::path ingest, output;
  std::span<const Photo> photos;                // of the capture
  const ColmapModel* model = nullptr;           // before undistortion: which photos, which camera
  std::span<const Undistortion> undistortions;  // per camera of the model
  std::function<void(size_t done)> progress;
};

// The model without lens distortion. Cameras become PINHOLE, observations follow, 2D points without a 3D point leave. Points seen
// less than twice leave, too.
ColmapModel undistorted(const ColmapModel& model, const std::vector<Undistortion>& per_camera);

// linear/<stem>.exr and images/<name> for every photo of the model.
void write_pictures(const PicturesDesc& desc);

struct SfmReportDesc {
  const Reconstruction* reconstruction = nullptr;
  std::string colmap;                        // version, or "none" when the poses were complete
  const ColmapModel* final_model = nullptr;  // null for a failed run
  std::span<const Undistortion> undistortions = {};
  Orientation orientation = {};
  FilterCounts points = {};
  const ObjectPasses* passes = nullptr;  // null: not looked for
  std::string code = {};                 // of the diagnosis, for a failed run
};

// Evidence: a square for every pair of photos in name order, darker blue with more verified matches; on the diagonal green with a
// pose, red without.
void write_match_matrix(const std::filesystem::path& path, const Reconstruction& r);

void write_sfm_report(const std::filesystem::path& path, const SfmReportDesc& desc);
// The lenses as photographed and undistorted, and the photos without a camera: read by core/intake/poses/photo_lenses.h.
void write_lenses(const std::filesystem::path& path, const std::vector<Undistortion>& undistortions, const ColmapModel& model,
                  const Reconstruction& reconstruction);

}  // namespace vitrine
