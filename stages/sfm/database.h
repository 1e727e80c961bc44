// COLMAP's SQLite database, read and mended: features per photo, image ids in name order, two-view geometries.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/foundation/base/file.h"

struct sqlite3;

namespace vitrine {

struct PhotoFeatures {
  uint32_t image_id = 0, camera_id = 0;
  std::string name;
  size_t count = 0;
  std::vector<float> xy;             // [count * 2], pixels of the photo, centres at .5
  std::vector<uint8_t> descriptors;  // [count * 128]
};

struct VerifiedPair {
  uint32_t image_a = 0, image_b = 0;  // image ids, a < b
  size_t inliers = 0;
  int config = 0;                  // COLMAP's TwoViewGeometry: 2 calibrated, 3 uncalibrated, 4 to 6 a plane or a rotation
  std::vector<double> homography;  // [9] row by row, pixels of a to pixels of b; empty: not known
};
inline constexpr int kCalibratedPair = 2, kUncalibratedPair = 3, kFirstPlanarPair = 4, kLastPlanarPair = 6;

struct PairMatches {
  uint32_t image_a = 0, image_b = 0;  // image ids, a < b
  std::vector<uint32_t> features;     // [2 n]: feature of a, feature of b
};

class ColmapDatabase {
 public:
  // Throws Error{Dependency} when the file is no database with COLMAP's tables (what a failed command leaves).
  explicit ColmapDatabase(const fs::path& path);
  ~ColmapDatabase();
  ColmapDatabase(const ColmapDatabase&) = delete;
  ColmapDatabase& operator=(const ColmapDatabase&) = delete;

  // Versions from 3.12 keep rigs and frames beside the images: their ids are left as they are.
  bool has_frames() const;
  // Image ids become 1..n in the order of names. With several threads the extractor gives them in order of completion.
  void renumber_by_name();
  // Sorted by name. Photos without features are there with count 0.
  std::vector<PhotoFeatures> features() const;
  std::vector<VerifiedPair> verified_pairs() const;
  std::vector<PairMatches> descriptor_matches() const;  // before the geometric verification
  std::vector<PairMatches> inlier_matches() const;      // of the verified pairs
  size_t examined_pairs() const;                        // by the geometric verification, successful or not
  void drop_descriptors();                              // in a copy for verification, which needs keypoints only
  void drop_geometries();                               // matches and two-view geometries: in a copy that is matched anew
  // Copies matches and two-view geometries of another database with the same images.
  void take_geometries(const fs::path& other);

 private:
  void execute(const std::string& sql) const;
  std::vector<PairMatches> matches_of(const char* table) const;
  bool has_table(const std::string& name) const;
  fs::path path_;
  sqlite3* handle_ = nullptr;
};

}  // namespace vitrine
