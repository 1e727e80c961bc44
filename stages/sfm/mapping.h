// COLMAP's mapper on a database with verified matches, and what becomes of its models.
#pragma once

#include <span>
#include <vector>

#include "stages/sfm/reconstruct.h"

namespace vitrine {

// One attempt of the retries: changes against the previous one.
struct Rung {
  std::string what;
  bool relaxed_mapper = false, more_features = false;
};

// Replaces safe names by photo names; image ids become 1..n in name order, and tracks are updated.
ColmapModel with_photo_names(ColmapModel model, const std::vector<SfmPhoto>& photos);
// Maps the photos of the database of `now` and fills its models; returns their numbers of photos.
std::vector<size_t> run_mapper(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc, const Rung& rung,
                               const fs::path& models, Reconstruction& now);
// Removes photos whose pose depends on few points, and records the attempt. Relaxed thresholds at the start require stricter ones
// at the end.
void finish_attempt(Reconstruction& now, Attempt attempt);

// A camera for a new mapping, from which focal length it starts, and its photos (indices).
struct CameraOfPhotos {
  ColmapCamera start;
  bool trusted = true;  // false: the mapper looks for the focal length
  std::vector<size_t> photos;
};
// The photos of `found` mapped once more from the same matches, with these cameras. Features and matches are computed anew with
// versions of COLMAP whose database has rigs, because cameras cannot be exchanged there.
Reconstruction mapped_with_cameras(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc,
                                   const Reconstruction& found, std::span<const CameraOfPhotos> cameras, const fs::path& folder);

}  // namespace vitrine
