// Photos -> COLMAP model: features (COLMAP's SIFT), matches (ours), two-view geometry and mapping (COLMAP's), each step
// reproducible:
//
//   extraction   any number of threads; image ids are put in name order afterwards
//   matching     integer arithmetic, pairs in parallel (matcher.h)
//   verification `matches_importer raw` in chunks of pairs that depend on the problem alone, one process per chunk
//   mapping      one thread and a fixed seed: COLMAP's bundle adjustment adds in a fixed order then
//
// When too few photos are registered, the ladder of retries (README) goes on; the best result of all attempts counts.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/scene/camera/colmap_model.h"
#include "core/intake/poses/pose_agreement.h"
#include "stages/sfm/colmap_driver.h"
#include "stages/sfm/database.h"
#include "stages/sfm/feature_masks.h"

namespace vitrine {

struct SfmConfig;

inline constexpr size_t kMinMatches = 15;  // pairs of photos with fewer are left out

struct SfmPhoto {
  std::string name;  // what the model calls it
  fs::path picture;  // 8-bit file for feature extraction
  int width = 0, height = 0;
  std::optional<double> focal_px;  // prior
  std::string camera;              // maker and model; photos of one camera, size and focal length share intrinsics
};

// What is known about a photo after the attempts.
struct PhotoReport {
  std::string name;
  size_t masked = 0;                                                                 // of its features: not used, by the masks
  size_t features = 0, matches = 0, verified = 0, neighbours = 0, observations = 0;  // verified matches over all pairs
  bool registered = false;
  size_t group = 0;               // of photos that verified pairs connect; 0 = the largest
  std::optional<double> blur_px;  // measured when something went wrong (core/intake/photos/measures.h)
  std::optional<double> brightness_ev;
  bool pose_missing = false;          // poses were given, but none for this photo
  bool other_pass = false;            // of a pass that shares too little of the object with the one that is reconstructed
  std::optional<size_t> weak_points;  // the mapper gave it a pose from so few points that it was taken out again
};

struct Attempt {
  std::string what;                 // "standard", "relaxed mapper", ...
  std::vector<size_t> model_sizes;  // registered photos of every model, largest first
  size_t registered = 0;
};

struct PairReport {
  size_t a = 0, b = 0, verified = 0;  // indices of photos
};

struct Reconstruction {
  ColmapModel model;                             // image names are photo names; ids 1..n in name order
  std::vector<ColmapModel> smaller_models = {};  // of photos that did not join the model
  fs::path database = {};                        // features and matches of the attempt that counts
  std::vector<PhotoReport> photos;               // in the order given
  std::vector<Attempt> attempts;
  std::vector<size_t> groups;     // sizes of groups connected by verified pairs, largest first
  std::vector<PairReport> pairs;  // verified ones
  double rotation_share = 0;      // of the verified pairs: explained by a camera that turned on the spot
  double uncalibrated_share = 0;  // of the pairs of photos with a focal length from EXIF: explained only without it
  size_t pairs_compared = 0, pairs_matched = 0, pairs_verified = 0;
  std::optional<MaskEffect> masks;  // of the attempt that counts
};

struct ReconstructDesc {
  std::vector<SfmPhoto> photos;  // sorted by name
  fs::path work_folder;          // emptied first
  int threads = 1;
  const FeatureMasks* masks = nullptr;  // null: every feature is used
  UsedFeatures used = UsedFeatures::ByTurntable;
  fs::path found_features = {};  // a database of these photos, whose features are used; empty: they are extracted
  // [photo] the pass in which it was taken (passes.h). Between photos of two passes features of the object alone are matched;
  // what surrounds it stood still in each. Empty: one pass.
  std::vector<size_t> pass_of = {};
  std::function<void(double fraction, const std::string& text)> progress;
  std::function<void(const std::string& name, double seconds)> timing;
};

// Matches between the features of photos, as a database holds them.
enum class MatchKind { Descriptors, Verified };  // before and after the geometric verification
struct FoundMatches {
  std::vector<std::vector<float>> xy;                                // [photo][2 n] all its features, pixels
  std::vector<PhotoMatches> pairs;                                   // in order of the photos
  std::vector<std::pair<size_t, size_t>> photos;                     // [pair] indices of the two photos
  std::vector<std::vector<std::pair<uint32_t, uint32_t>>> features;  // [pair][match] indices of the two features
};
FoundMatches found_matches(std::span<const SfmPhoto> photos, const fs::path& database, MatchKind kind);

// Without enough photos registered it returns what there is (perhaps an empty model): diagnosis.h decides.
Reconstruction reconstruct(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc);
// Poses and intrinsics are given (image names = photo names): matches, then triangulates the points only. `checked` sees the
// poses and the verified matches first; it throws, or returns the poses to be used.
using PoseCheck = std::function<ColmapModel(const ColmapModel& poses, const std::vector<PhotoMatches>& matches)>;
Reconstruction triangulate(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc, const ColmapModel& poses,
                           const PoseCheck& checked);

}  // namespace vitrine
