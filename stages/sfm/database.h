// COLMAP's SQLite database: features per photo, image ids in name order, matches and two-view geometries.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/foundation/base/file.h"
#include "core/scene/camera/colmap_model.h"

struct sqlite3;

namespace vitrine {

struct PhotoFeatures {
  uint32_t image_id = 0, camera_id = 0;
  std::string name;
  size_t count = 0;
  std::vector<float> xy;             // [count * 2], pixels of the photo, pixel centres at .5
  std::vector<uint8_t> descriptors;  // [count * 128]
};

struct VerifiedPair {
  uint32_t image_a = 0, image_b = 0;  // image ids, a < b
  size_t inliers = 0;
  int config = 0;                  // COLMAP's TwoViewGeometry: 2 calibrated, 3 uncalibrated, 4 to 6 a plane or a rotation
  std::vector<double> homography;  // [9] row-major, pixels of a to pixels of b; empty: not known
};
inline constexpr int kCalibratedPair = 2, kUncalibratedPair = 3, kFirstPlanarPair = 4, kLastPlanarPair = 6;

struct PairMatches {
  uint32_t image_a = 0, image_b = 0;  // image ids, a < b
  std::vector<uint32_t> features;     // [2 n]: feature of a, feature of b
};

class ColmapDatabase {
 public:
  // Throws Error{Dependency} when the file is not a database with COLMAP's tables (left by a failed command).
  explicit ColmapDatabase(const fs::path& path);
  ~ColmapDatabase();
  ColmapDatabase(const ColmapDatabase&) = delete;
  ColmapDatabase& operator=(const ColmapDatabase&) = delete;

  // COLMAP 3.12 and later store rigs and frames next to the images: their ids are not changed.
  bool has_frames() const;
  // Renumbers image ids to 1..n in name order. A multithreaded extractor numbers them in order of completion.
  void renumber_by_name();
  // Sorted by name. Includes photos without features, with count 0.
  std::vector<PhotoFeatures> features() const;
  std::vector<VerifiedPair> verified_pairs() const;
  std::vector<PairMatches> descriptor_matches() const;  // before the geometric verification
  std::vector<PairMatches> inlier_matches() const;      // of the verified pairs
  size_t examined_pairs() const;                        // pairs that the geometric verification processed, successful or not
  void drop_descriptors();                              // for a copy used for verification, which needs only keypoints
  void drop_geometries();  // removes matches and two-view geometries, for a copy that is matched again
  // Replaces all cameras: `camera_of` pairs image ids with indices of `cameras`, `known` marks trusted focal lengths.
  void replace_cameras(std::span<const ColmapCamera> cameras, const std::vector<bool>& known,
                       std::span<const std::pair<uint32_t, size_t>> camera_of);
  // Copies matches and two-view geometries from another database with the same images.
  void take_geometries(const fs::path& other);

 private:
  void execute(const std::string& sql) const;
  std::vector<PairMatches> matches_of(const char* table) const;
  bool has_table(const std::string& name) const;
  fs::path path_;
  sqlite3* handle_ = nullptr;
};

}  // namespace vitrine
