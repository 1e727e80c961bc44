#include "stages/sfm/second_motion.h"

#include <map>
#include <set>

#include "stages/sfm/features.h"

namespace vitrine {

namespace {

constexpr size_t kFewestOfMotion = 25;      // matches
constexpr double kLeastUnexplained = 0.25;  // of a pair's matches: wrong ones are fewer where photos overlap well

}  // namespace

std::vector<std::vector<uint8_t>> second_motion_features(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc,
                                                         const Reconstruction& r, const FoundMatches& matches) {
  std::vector<std::vector<uint8_t>> moving(matches.xy.size());
  for (size_t i = 0; i < moving.size(); ++i) moving[i].resize(matches.xy[i].size() / 2, 0);
  const FoundMatches verified = found_matches(desc.photos, r.database, MatchKind::Verified);
  std::map<std::pair<size_t, size_t>, size_t> index;
  for (size_t p = 0; p < verified.photos.size(); ++p) index[verified.photos[p]] = p;
  std::vector<PhotoPair> pairs;
  std::vector<std::vector<Match>> unexplained;
  for (size_t p = 0; p < matches.photos.size(); ++p) {
    const auto first = index.find(matches.photos[p]);
    if (first == index.end()) continue;
    const auto& inliers = verified.features[first->second];
    const std::set<std::pair<uint32_t, uint32_t>> explained(inliers.begin(), inliers.end());
    std::vector<Match> left;
    for (const auto& [a, b] : matches.features[p])
      if (!explained.contains({a, b})) left.push_back({a, b});
    if (left.size() < kFewestOfMotion || double(left.size()) < kLeastUnexplained * double(matches.features[p].size())) continue;
    pairs.push_back({uint32_t(matches.photos[p].first), uint32_t(matches.photos[p].second)});
    unexplained.push_back(std::move(left));
  }
  if (pairs.empty()) return moving;
  const fs::path database = desc.work_folder / "second_motion.db";
  fs::copy_file(r.database, database, fs::copy_options::overwrite_existing);
  ColmapDatabase(database).drop_geometries();
  verify_pairs(colmap, config, desc, database, pairs, unexplained, kFewestOfMotion);
  const FoundMatches second = found_matches(desc.photos, database, MatchKind::Verified);
  for (size_t p = 0; p < second.photos.size(); ++p)
    for (const auto& [a, b] : second.features[p]) {
      moving[second.photos[p].first][a] = 1;
      moving[second.photos[p].second][b] = 1;
    }
  return moving;
}

}  // namespace vitrine
