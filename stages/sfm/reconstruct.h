// Reconstruction from photos to a COLMAP model: features (COLMAP's SIFT), matches (ours), two-view geometry and mapping
// (COLMAP's). Each step is reproducible:
//
//   extraction   any number of threads; image ids are renumbered in name order afterwards
//   matching     integer arithmetic, pairs in parallel (matcher.h)
//   verification `matches_importer raw` in chunks of pairs that depend on the input alone, one process per chunk
//   mapping      one thread and a fixed seed: COLMAP's bundle adjustment then sums in a fixed order
//
// When too few photos are registered, the retries of the README follow; the best attempt is kept.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/intake/photos/photo_list.h"
#include "core/scene/camera/colmap_model.h"
#include "core/intake/poses/pose_agreement.h"
#include "stages/sfm/colmap_driver.h"
#include "stages/sfm/database.h"
#include "stages/sfm/feature_masks.h"

namespace vitrine {

struct SfmConfig;

inline constexpr size_t kMinMatches = 15;  // pairs of photos with fewer are left out

struct SfmPhoto {
  std::string name;  // image name in the model
  fs::path picture;  // 8-bit file for feature extraction
  int width = 0, height = 0;
  std::optional<double> focal_px;  // prior
  std::string camera;              // maker and model; photos of equal camera, size and focal length share intrinsics
  std::optional<PhotoRig> rig = {};  // of a view cut from a panorama: pinhole, its focal length is exact
};

// Result of the attempts for one photo.
struct PhotoReport {
  std::string name;
  size_t masked = 0;                                                                 // features removed by the masks
  size_t features = 0, matches = 0, verified = 0, neighbours = 0, observations = 0;  // verified: matches, summed over all pairs
  bool registered = false;
  size_t group = 0;               // of photos connected by verified pairs; 0 = the largest
  std::optional<double> blur_px;  // measured only when photos are missing (core/intake/photos/measures.h)
  std::optional<double> brightness_ev;
  bool pose_missing = false;          // poses were given, but none for this photo
  bool other_pass = false;            // its pass shares too little of the object with the reconstructed pass
  std::optional<size_t> weak_points;  // set when it was removed because its pose depends on so few points
};

struct Attempt {
  std::string what;                 // "standard", "relaxed mapper", ...
  std::vector<size_t> model_sizes;  // registered photos of every model, largest first
  size_t registered = 0;
};

struct PairReport {
  size_t a = 0, b = 0, verified = 0;  // indices of photos
};

// Effect of one pose for all views of a rig.
struct RigEffect {
  size_t rigs = 0, views = 0;                // with a pose
  size_t completed = 0;                      // views without a pose of their own that take that of their rig
  double error_before = 0, error_after = 0;  // of the adjustment, RMS, pixels
};

struct Reconstruction {
  ColmapModel model;                             // image names are photo names; ids 1..n in name order
  std::vector<ColmapModel> smaller_models = {};  // of photos that are not in the main model
  fs::path database = {};                        // features and matches of the best attempt
  std::vector<PhotoReport> photos;               // in input order
  std::vector<Attempt> attempts;
  std::vector<size_t> groups;     // sizes of groups connected by verified pairs, largest first
  std::vector<PairReport> pairs;  // verified ones
  double rotation_share = 0;      // share of the verified pairs explained by a purely rotating camera
  double uncalibrated_share = 0;  // share of the pairs with an EXIF focal length that fit only without it
  bool relaxed = false;           // found by a relaxed mapper
  size_t pairs_compared = 0, pairs_matched = 0, pairs_verified = 0;
  std::optional<MaskEffect> masks;  // of the best attempt
  std::optional<RigEffect> rigs;    // of views cut from panorama pictures (rigs.h)
};

struct ReconstructDesc {
  std::vector<SfmPhoto> photos;  // sorted by name
  fs::path work_folder;          // emptied first
  int threads = 1;
  const FeatureMasks* masks = nullptr;  // null: every feature is used
  UsedFeatures used = UsedFeatures::ByTurntable;
  fs::path found_features = {};  // database of these photos with features to reuse; empty: extract them
  bool found_matches = false;    // reuse its verified matches, too
  // [photo] its pass (passes.h). Between passes only features of the object are matched, because the surroundings moved. Empty:
  // one pass.
  std::vector<size_t> pass_of = {};
  std::function<void(double fraction, const std::string& text)> progress;
  std::function<void(const std::string& name, double seconds)> timing;
};

// Matches between features, before and after the geometric verification.
enum class MatchKind { Descriptors, Verified };
struct FoundMatches {
  std::vector<std::vector<float>> xy;                                // [photo][2 n] pixels of all its features
  std::vector<PhotoMatches> pairs;                                   // in photo order
  std::vector<std::pair<size_t, size_t>> photos;                     // [pair] indices of the two photos
  std::vector<std::vector<std::pair<uint32_t, uint32_t>>> features;  // [pair][match] indices of the two features
};
FoundMatches found_matches(std::span<const SfmPhoto> photos, const fs::path& database, MatchKind kind);

// Number of 2D points with a 3D point.
size_t observations_of(const ColmapImage& image);
// Sets the observations of the photos that have a pose; clears `registered` of the others.
void mark_registered(Reconstruction& r);

// With too few registered photos it returns the partial (perhaps empty) model: diagnosis.h decides.
Reconstruction reconstruct(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc);
// Poses and intrinsics are given (image names = photo names): matches, then triangulates the points only. `checked` receives the
// poses and the verified matches first; it throws, or returns the poses to use.
using PoseCheck = std::function<ColmapModel(const ColmapModel& poses, const std::vector<PhotoMatches>& matches)>;
Reconstruction triangulate(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc, const ColmapModel& poses,
                           const PoseCheck& checked);

}  // namespace vitrine
