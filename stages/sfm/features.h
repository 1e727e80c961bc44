// Feature extraction and matching: fills a database with features, matches and two-view geometries.
#pragma once

#include "stages/sfm/feature_masks.h"
#include "stages/sfm/pairs.h"
#include "stages/sfm/reconstruct.h"

namespace vitrine {

// Image names in the database are plain numbers: spaces and non-ASCII letters break COLMAP's list files.
std::string safe_name(size_t index);  // "000012.png"
std::optional<size_t> index_of_safe_name(const std::string& name);

// Photos that share one camera, in order of their first photo. `known` (optional): camera per photo, and only photos with one.
std::vector<std::vector<size_t>> camera_groups(const std::vector<SfmPhoto>& photos, const ColmapModel* known);

struct FeatureEffort {
  int max_features = 8192;
  double peak_threshold = 0.02 / 3;  // contrast threshold of SIFT; a lower value finds more and weaker features
};

struct MatchCounts {
  size_t compared = 0, matched = 0;
  std::vector<size_t> per_photo;  // matches over all pairs
  std::optional<MaskEffect> masks;
};

// Links the pictures into work/pictures under safe names; returns the folder.
fs::path link_pictures(const ReconstructDesc& desc);
// Links the pictures and fills work/<database>. `known` (optional): camera per photo, replaces the priors.
void extract_features(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc, const FeatureEffort& effort,
                      const fs::path& database, const ColmapModel* known);
MatchCounts match_and_verify(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc, const fs::path& database);

}  // namespace vitrine
