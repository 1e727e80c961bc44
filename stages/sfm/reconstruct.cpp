#include "stages/sfm/reconstruct.h"

#include <algorithm>
#include <map>
#include <set>

#include "core/foundation/base/error.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/timer.h"
#include "core/foundation/math/connected_components.h"
#include "stages/sfm/diagnosis.h"
#include "stages/sfm/features.h"
#include "stages/sfm/mapping.h"
#include "stages/sfm/sfm.h"

namespace vitrine {

namespace {

const Rung kLadder[] = {
    {.what = "standard"},
    {.what = "relaxed mapper (initial pair from 50 inliers and 6 degrees, poses from 20 inliers)", .relaxed_mapper = true},
    {.what = "more features (peak threshold / 3, limit x 2), relaxed mapper", .relaxed_mapper = true, .more_features = true}};
// The object fills a part of the picture, and two passes share only a part of it: use all features from the start.
const Rung kPassesLadder[] = {
    {.what = "passes joined by the object, more features (peak threshold / 3, limit x 2), relaxed mapper",
     .relaxed_mapper = true,
     .more_features = true}};

constexpr double kRetryBelow = 0.8;  // share of registered photos below which the retries run

// Connected components of the photos under verified pairs: index per photo; `sizes` largest first.
std::vector<size_t> connected_groups(size_t n, const std::vector<PairReport>& edges, std::vector<size_t>& sizes) {
  DisjointSets sets(n);
  for (const PairReport& e : edges) sets.unite(uint32_t(e.a), uint32_t(e.b));
  std::vector<size_t> count(n, 0), order, group(n);
  for (size_t i = 0; i < n; ++i) ++count[sets.representative(uint32_t(i))];
  for (size_t i = 0; i < n; ++i)
    if (count[i] > 0) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return count[a] > count[b]; });
  sizes.clear();
  for (size_t i : order) sizes.push_back(count[i]);
  for (size_t i = 0; i < n; ++i)
    group[i] = size_t(std::find(order.begin(), order.end(), sets.representative(uint32_t(i))) - order.begin());
  return group;
}

// Fills the photo reports from the database.
void survey(const ReconstructDesc& desc, const fs::path& database, const MatchCounts& counts, Reconstruction& out) {
  const ColmapDatabase db(database);
  std::vector<size_t> photo_of_id;
  out.photos.assign(desc.photos.size(), {});
  for (size_t i = 0; i < desc.photos.size(); ++i) {
    out.photos[i].name = desc.photos[i].name;
    out.photos[i].matches = counts.per_photo.empty() ? 0 : counts.per_photo[i];
  }
  for (const PhotoFeatures& f : db.features()) {
    const std::optional<size_t> i = index_of_safe_name(f.name);
    if (!i || *i >= desc.photos.size()) continue;
    if (photo_of_id.size() <= f.image_id) photo_of_id.resize(f.image_id + 1, desc.photos.size());
    photo_of_id[f.image_id] = *i;
    out.photos[*i].features = f.count;
  }
  const std::vector<VerifiedPair> verified = db.verified_pairs();
  size_t with_focal = 0, uncalibrated = 0;
  for (const VerifiedPair& pair : verified) {
    const size_t a = photo_of_id.at(pair.image_a), b = photo_of_id.at(pair.image_b);
    out.pairs.push_back({a, b, pair.inliers});
    if (desc.photos[a].focal_px && desc.photos[b].focal_px &&
        (pair.config == kCalibratedPair || pair.config == kUncalibratedPair)) {
      ++with_focal;
      uncalibrated += pair.config == kUncalibratedPair;
    }
    for (size_t i : {a, b}) {
      out.photos[i].verified += pair.inliers;
      ++out.photos[i].neighbours;
    }
  }
  out.masks = counts.masks;
  if (counts.masks)
    for (size_t i = 0; i < counts.masks->removed_of_photo.size(); ++i) out.photos[i].masked = counts.masks->removed_of_photo[i];
  out.pairs_compared = counts.compared;
  out.pairs_matched = counts.matched;
  out.pairs_verified = out.pairs.size();
  const std::vector<size_t> group = connected_groups(desc.photos.size(), out.pairs, out.groups);
  for (size_t i = 0; i < group.size(); ++i) out.photos[i].group = group[i];
  out.uncalibrated_share = with_focal > 0 ? double(uncalibrated) / double(with_focal) : 0;
  if (!desc.photos.empty()) out.rotation_share = rotation_share(verified, desc.photos[0].width, desc.photos[0].height);
}

// Number of photos with a pose; views without one have that of their rig if any view of it has one.
size_t posed(const ColmapModel& model, const std::vector<SfmPhoto>& photos) {
  std::set<std::string> names, rigs;
  for (const ColmapImage& image : model.images) names.insert(image.name);
  for (const SfmPhoto& p : photos)
    if (p.rig && names.contains(p.name)) rigs.insert(p.rig->panorama);
  return size_t(std::ranges::count_if(
      photos, [&](const SfmPhoto& p) { return names.contains(p.name) || (p.rig && rigs.contains(p.rig->panorama)); }));
}

// Maps the progress of a sub-step to [low, high].
ReconstructDesc with_progress_in(const ReconstructDesc& desc, double low, double high) {
  ReconstructDesc out = desc;
  if (desc.progress)
    out.progress = [report = desc.progress, low, high](double fraction, const std::string& text) {
      report(low + (high - low) * fraction, text);
    };
  return out;
}

MatchCounts prepare_database(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc, const FeatureEffort& effort,
                             const fs::path& database, const ColmapModel* known) {
  Timer timer;
  if (desc.found_features.empty()) {
    extract_features(colmap, config, with_progress_in(desc, 0, 0.3), effort, database, known);
  } else {
    fs::copy_file(desc.found_features, database);
    link_pictures(desc);
    if (desc.found_matches) return {};
    ColmapDatabase(database).drop_geometries();
  }
  if (desc.timing) desc.timing("features", timer.seconds());
  return match_and_verify(colmap, config, with_progress_in(desc, 0.3, 0.6), database);
}

ReconstructDesc fresh(const ReconstructDesc& desc) {
  ReconstructDesc out = desc;
  out.work_folder = fs::absolute(desc.work_folder);
  fs::remove_all(out.work_folder);
  make_folders(out.work_folder);
  return out;
}

}  // namespace

size_t observations_of(const ColmapImage& image) {
  return static_cast<size_t>(
      std::count_if(image.points.begin(), image.points.end(), [](const ColmapPoint2D& p) { return p.point3d_id != kNoPoint3D; }));
}

void mark_registered(Reconstruction& r) {
  std::map<std::string, size_t> observations;
  for (const ColmapImage& image : r.model.images) observations[image.name] = observations_of(image);
  for (PhotoReport& p : r.photos) {
    const auto found = observations.find(p.name);
    p.registered = found != observations.end();
    if (p.registered) p.observations = found->second;
  }
}

FoundMatches found_matches(std::span<const SfmPhoto> photos, const fs::path& database, MatchKind kind) {
  const ColmapDatabase db(database);
  std::map<uint32_t, std::pair<size_t, PhotoFeatures>> features;  // image id -> photo index and its features
  FoundMatches out;
  out.xy.resize(photos.size());
  for (PhotoFeatures& f : db.features()) {
    const std::optional<size_t> photo = index_of_safe_name(f.name);
    if (!photo || *photo >= photos.size()) continue;
    f.descriptors.clear();
    out.xy[*photo] = f.xy;
    features[f.image_id] = {*photo, std::move(f)};
  }
  for (const PairMatches& pair : kind == MatchKind::Verified ? db.inlier_matches() : db.descriptor_matches()) {
    const auto a = features.find(pair.image_a), b = features.find(pair.image_b);
    if (a == features.end() || b == features.end()) continue;
    const auto& [photo_a, features_a] = a->second;
    const auto& [photo_b, features_b] = b->second;
    PhotoMatches& m = out.pairs.emplace_back();
    m.a = photos[photo_a].name, m.b = photos[photo_b].name;
    std::vector<std::pair<uint32_t, uint32_t>>& indices = out.features.emplace_back();
    out.photos.push_back({photo_a, photo_b});
    for (size_t i = 0; i + 1 < pair.features.size(); i += 2) {
      const uint32_t fa = pair.features[i], fb = pair.features[i + 1];
      if (fa >= features_a.count || fb >= features_b.count) continue;
      m.in_a.push_back({features_a.xy[2 * fa], features_a.xy[2 * fa + 1]});
      m.in_b.push_back({features_b.xy[2 * fb], features_b.xy[2 * fb + 1]});
      indices.push_back({fa, fb});
    }
  }
  return out;
}

Reconstruction reconstruct(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& given) {
  const ReconstructDesc desc = fresh(given);
  const std::span<const Rung> ladder =
      !desc.pass_of.empty()
          ? std::span<const Rung>(kPassesLadder)
          : std::span<const Rung>(kLadder).first(desc.used == UsedFeatures::Surroundings ? 1 : size_t(config.retries) + 1);
  Reconstruction best;
  fs::path database;
  MatchCounts counts;
  for (size_t r = 0; r < ladder.size(); ++r) {
    const Rung& rung = ladder[r];
    if (r > 0)
      log_warning("sfm: {} of {} photos registered; attempt {}: {}", best.model.images.size(), desc.photos.size(), r + 1,
                  rung.what);
    if (r == 0 || (rung.more_features && !ladder[r - 1].more_features)) {
      database = desc.work_folder / fmt::format("attempt_{}.db", r);
      const FeatureEffort effort{.max_features = config.max_features * (rung.more_features ? 2 : 1),
                                 .peak_threshold = FeatureEffort{}.peak_threshold / (rung.more_features ? 3 : 1)};
      counts = prepare_database(colmap, config, desc, effort, database, nullptr);
    }
    Reconstruction now;
    now.database = database;
    survey(desc, database, counts, now);
    now.attempts = best.attempts;
    Attempt attempt{.what = rung.what, .model_sizes = {}};
    if (now.pairs_verified > 0)  // the mapper aborts on an empty graph
      attempt.model_sizes = run_mapper(colmap, config, desc, rung, desc.work_folder / fmt::format("models_{}", r), now);
    now.relaxed = rung.relaxed_mapper;
    finish_attempt(now, std::move(attempt));
    const bool better = r == 0 || posed(now.model, desc.photos) > posed(best.model, desc.photos);
    if (better) {
      best = std::move(now);
    } else {
      best.attempts = now.attempts;
    }
    if (double(posed(best.model, desc.photos)) >= std::max(kRetryBelow, config.min_registered) * double(desc.photos.size()))
      break;
  }
  return best;
}

Reconstruction triangulate(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& given, const ColmapModel& given_poses,
                           const PoseCheck& checked) {
  const ReconstructDesc desc = fresh(given);
  const fs::path database = desc.work_folder / "given.db";
  const FeatureEffort effort{.max_features = config.max_features};
  const MatchCounts counts = prepare_database(colmap, config, desc, effort, database, &given_poses);
  Reconstruction out;
  survey(desc, database, counts, out);
  const FoundMatches found = found_matches(desc.photos, database, MatchKind::Verified);
  const ColmapModel poses = checked(given_poses, found.pairs);
  out.rotation_share = 0;  // not tested: the camera positions are given

  // The triangulator needs the given poses with the names and ids of the database, without points.
  ColmapModel start;
  std::map<std::string, const ColmapImage*> pose_of;
  for (const ColmapImage& image : poses.images) pose_of[image.name] = &image;
  std::map<uint32_t, uint32_t> database_camera;  // our camera id -> the database's
  for (const PhotoFeatures& f : ColmapDatabase(database).features()) {
    const std::optional<size_t> i = index_of_safe_name(f.name);
    if (!i || *i >= desc.photos.size() || !pose_of.contains(desc.photos[*i].name)) continue;
    const ColmapImage& pose = *pose_of.at(desc.photos[*i].name);
    database_camera.emplace(pose.camera_id, f.camera_id);
    ColmapImage image = pose;
    image.id = f.image_id;
    image.camera_id = f.camera_id;
    image.name = f.name;
    image.points.clear();
    start.images.push_back(std::move(image));
  }
  for (const auto& [ours, theirs] : database_camera) {
    ColmapCamera camera = *poses.find_camera(ours);
    camera.id = theirs;
    start.cameras.push_back(std::move(camera));
  }
  check_colmap_model(start, "given poses");
  const fs::path input = desc.work_folder / "given", output = desc.work_folder / "triangulated";
  make_folders(output);
  make_folders(input);
  write_colmap_model(input, start, ColmapFormat::Binary);
  if (out.pairs_verified > 0)
    colmap.run({.command = "point_triangulator",
                .settings = {{"database", database.string()},
                             {"images", (desc.work_folder / "pictures").string()},
                             {"input", input.string()},
                             {"output", output.string()},
                             {"map_threads", "1"},
                             {"map_refine_focal", "0", false},
                             {"map_refine_extra", "0", false},
                             {"map_refine_principal", "0", false},
                             {"seed", std::to_string(config.seed), false}},
                .working_folder = desc.work_folder,
                .log = desc.work_folder / "colmap.log"});
  if (fs::exists(output / "images.bin")) {
    out.model = with_photo_names(read_colmap_model(output), desc.photos);
    // Points are new; the poses stay bit-identical to the given ones.
    for (ColmapImage& image : out.model.images) {
      const ColmapImage& pose = *pose_of.at(image.name);
      image.rotation = pose.rotation;
      image.translation = pose.translation;
    }
  } else {
    out.model = poses;
  }
  out.attempts.push_back(
      {.what = "given poses", .model_sizes = {out.model.images.size()}, .registered = out.model.images.size()});
  mark_registered(out);
  return out;
}

}  // namespace vitrine
