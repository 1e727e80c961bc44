// Outputs of the stage: undistorted pictures and cameras, and the report.
#pragma once

#include <functional>
#include <span>

#include "core/intake/photos/photo_list.h"
#include "core/scene/camera/undistort.h"
#include "stages/sfm/focal_search.h"
#include "stages/sfm/gps_frame.h"
#include "stages/sfm/normalize.h"
#include "stages/sfm/object_poses.h"
#include "stages/sfm/point_filter.h"
#include "stages/sfm/reconstruct.h"
#include "stages/sfm/wide_photos.h"

namespace vitrine {

struct PicturesDesc {
  std::filesystem::path ingest, output;
  const CutPhotos* photos = nullptr;
  std::function<void(size_t done)> progress;
};

// The model without lens distortion. Cameras become PINHOLE, views of cut photos get their rotation, and observations are
// undistorted. Removes 2D points without a 3D
// point, and points seen less than twice.
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
  const ObjectPasses* passes = nullptr;  // null: not searched
  const GpsFit* gps = nullptr;           // null: no photo has coordinates
  FocalSearch focals = {};
  std::string code = {};  // of the diagnosis, for a failed run
};

// Match matrix: one square per pair of photos in name order, darker blue = more verified matches; diagonal: green = registered,
// red = not.
void write_match_matrix(const std::filesystem::path& path, const Reconstruction& r);

void write_sfm_report(const std::filesystem::path& path, const SfmReportDesc& desc);
// Writes the original and undistorted lenses, the photos without a camera, and whether the flash of the camera fired in most of
// `photos`; read by core/intake/poses/photo_orientation.h.
void write_lenses(const std::filesystem::path& path, const std::vector<Undistortion>& undistortions, const ColmapModel& model,
                  const Reconstruction& reconstruction, std::span<const Photo> photos);

}  // namespace vitrine
