#include "stages/sfm/rigs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "core/foundation/base/error.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/timer.h"
#include "stages/sfm/gains/rig_adjustment.h"
#include "stages/sfm/sfm.h"

namespace vitrine {

namespace {

constexpr int kRounds = 2;        // of triangulation and adjustment: better poses find more points
constexpr int kMedianSteps = 60;  // Weiszfeld's algorithm

struct Estimate {
  std::array<double, 4> rotation{};  // of the rig from the world: w, x, y, z
  std::array<double, 3> centre{};
  double weight = 1;
};

// Geometric median by Weiszfeld's algorithm (1937); `value` selects the coordinates, `start` is the first guess.
template <size_t N, class Value>
std::array<double, N> geometric_median(std::span<const Estimate> estimates, Value value, std::array<double, N> start) {
  constexpr double kLeast = 1e-12;
  for (int step = 0; step < kMedianSteps; ++step) {
    std::array<double, N> sum{};
    double weights = 0;
    for (const Estimate& e : estimates) {
      const std::array<double, N>& v = value(e);
      double squared = 0;
      for (size_t i = 0; i < N; ++i) squared += (v[i] - start[i]) * (v[i] - start[i]);
      const double w = e.weight / std::max(std::sqrt(squared), kLeast);
      for (size_t i = 0; i < N; ++i) sum[i] += w * v[i];
      weights += w;
    }
    for (size_t i = 0; i < N; ++i) start[i] = sum[i] / weights;
  }
  return start;
}

// The estimate with the least weighted distance to all others.
template <class Value>
auto medoid(std::span<const Estimate> estimates, Value value) {
  const auto distance = [&](const Estimate& a) {
    double sum = 0;
    for (const Estimate& b : estimates) {
      double squared = 0;
      for (size_t i = 0; i < value(a).size(); ++i) squared += (value(a)[i] - value(b)[i]) * (value(a)[i] - value(b)[i]);
      sum += b.weight * std::sqrt(squared);
    }
    return sum;
  };
  return value(*std::ranges::min_element(estimates, {}, distance));
}

// rig_from_world
Rigid mean_pose(std::vector<Estimate> estimates) {
  const auto& first = std::ranges::max_element(estimates, {}, &Estimate::weight)->rotation;
  const std::array<double, 4> sign = first;
  for (Estimate& e : estimates) {  // q and -q are one rotation
    double along = 0;
    for (size_t i = 0; i < 4; ++i) along += e.rotation[i] * sign[i];
    if (along < 0)
      for (double& v : e.rotation) v = -v;
  }
  const auto rotation = [](const Estimate& e) -> const std::array<double, 4>& { return e.rotation; };
  const auto centre = [](const Estimate& e) -> const std::array<double, 3>& { return e.centre; };
  const auto q = geometric_median<4>(estimates, rotation, medoid(std::span<const Estimate>(estimates), rotation));
  const auto c = geometric_median<3>(estimates, centre, medoid(std::span<const Estimate>(estimates), centre));
  const Mat3d r = rotation_matrix(normalized(Quatd{q[0], q[1], q[2], q[3]}));
  return {r, -(r * Vec3d{c[0], c[1], c[2]})};
}

std::map<std::string, Rigid> rig_poses(const ColmapModel& model, const std::map<std::string, const SfmPhoto*>& photo_of) {
  std::map<std::string, std::vector<Estimate>> estimates;
  for (const ColmapImage& image : model.images) {
    const SfmPhoto& photo = *photo_of.at(image.name);
    if (!photo.rig) continue;
    const Rigid pose = image.cam_from_world();
    const Quatd q = quaternion(transposed(rotation_matrix(photo.rig->rotation)) * pose.rotation);
    const Vec3d c = inverse(pose).translation;
    estimates[photo.rig->panorama].push_back({{q.w, q.x, q.y, q.z}, {c.x, c.y, c.z}, 1.0 + double(observations_of(image))});
  }
  std::map<std::string, Rigid> poses;
  for (auto& [panorama, list] : estimates) poses[panorama] = mean_pose(std::move(list));
  return poses;
}

std::map<std::string, const SfmPhoto*> by_name(std::span<const SfmPhoto> photos) {
  std::map<std::string, const SfmPhoto*> out;
  for (const SfmPhoto& p : photos) out[p.name] = &p;
  return out;
}

// One entry per image: photos of no rig are rigs of their own.
std::vector<RigCamera> rig_cameras(const ColmapModel& model, std::span<const SfmPhoto> photos) {
  const std::map<std::string, const SfmPhoto*> photo_of = by_name(photos);
  std::map<std::string, size_t> bodies;
  std::vector<RigCamera> cameras;
  for (const ColmapImage& image : model.images) {
    const std::optional<PhotoRig>& rig = photo_of.at(image.name)->rig;
    const std::string key = rig ? "rig " + rig->panorama : "photo " + image.name;
    cameras.push_back({bodies.try_emplace(key, bodies.size()).first->second, rig ? rig->rotation : Quatd{}});
  }
  return cameras;
}

}  // namespace

bool has_rigs(std::span<const SfmPhoto> photos) {
  return std::ranges::any_of(photos, [](const SfmPhoto& p) { return p.rig.has_value(); });
}

ColmapModel with_rig_poses(const ColmapModel& model, std::span<const SfmPhoto> photos) {
  const std::map<std::string, Rigid> poses = rig_poses(model, by_name(photos));
  std::map<std::string, const ColmapImage*> image_of;
  for (const ColmapImage& image : model.images) image_of[image.name] = &image;
  ColmapModel out;
  uint32_t next_camera = 1;
  for (const ColmapCamera& camera : model.cameras) next_camera = std::max(next_camera, camera.id + 1);
  std::map<std::tuple<int, int, double, std::string>, uint32_t> lenses;  // as features.cpp groups the views
  for (const SfmPhoto& photo : photos) {
    ColmapImage image{.id = uint32_t(out.images.size()) + 1,
                      .rotation = {},
                      .translation = {},
                      .camera_id = 0,
                      .name = photo.name,
                      .points = {}};
    if (!photo.rig) {
      const auto found = image_of.find(photo.name);
      if (found == image_of.end()) continue;
      image.rotation = found->second->rotation, image.translation = found->second->translation;
      image.camera_id = found->second->camera_id;
      if (std::ranges::none_of(out.cameras, [&](const ColmapCamera& c) { return c.id == image.camera_id; }))
        out.cameras.push_back(*model.find_camera(image.camera_id));
    } else {
      const auto pose = poses.find(photo.rig->panorama);
      if (pose == poses.end()) continue;
      const Mat3d view_from_rig = rotation_matrix(photo.rig->rotation);
      image.rotation = quaternion(view_from_rig * pose->second.rotation);
      image.translation = view_from_rig * pose->second.translation;
      const auto [lens, is_new] = lenses.try_emplace({photo.width, photo.height, *photo.focal_px, photo.camera}, next_camera);
      image.camera_id = lens->second;
      if (is_new) {
        const ColmapCameraType& type = *colmap_camera_type("SIMPLE_PINHOLE");
        out.cameras.push_back({next_camera++,
                               type.id,
                               uint64_t(photo.width),
                               uint64_t(photo.height),
                               {*photo.focal_px, 0.5 * photo.width, 0.5 * photo.height}});
      }
    }
    out.images.push_back(std::move(image));
  }
  check_colmap_model(out, "poses of rigs");
  return out;
}

void one_pose_per_rig(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc, Reconstruction& r,
                      StageContext& context) {
  if (r.model.images.empty() || r.database.empty()) return;
  const Timer timer;
  RigEffect effect;
  const size_t own = r.model.images.size();
  ReconstructDesc again = desc;
  again.found_features = r.database;
  again.found_matches = true;
  if (desc.progress) again.progress = [report = desc.progress](double, const std::string& text) { report(1, text); };
  for (int round = 0; round < kRounds; ++round) {
    again.work_folder = desc.work_folder / fmt::format("rigs_{}", round);
    const ColmapModel poses = with_rig_poses(r.model, desc.photos);
    ColmapModel model = triangulate(colmap, config, again, poses, [](const ColmapModel& m, const auto&) { return m; }).model;
    const RigAdjustment adjusted = adjust_rigs(model, rig_cameras(model, desc.photos));
    if (round == 0) effect.error_before = adjusted.error_before;
    effect.error_after = adjusted.error_after;
    r.model = std::move(model);
  }
  std::map<std::string, size_t> rigs;
  const std::map<std::string, const SfmPhoto*> photo_of = by_name(desc.photos);
  for (const ColmapImage& image : r.model.images)
    if (const auto& rig = photo_of.at(image.name)->rig) ++rigs[rig->panorama], ++effect.views;
  effect.rigs = rigs.size();
  effect.completed = r.model.images.size() - own;
  mark_registered(r);
  r.rigs = effect;
  context.timing("rigs", timer.seconds());
  context.metric("panoramas", double(effect.rigs));
  log_info("sfm: {} views of {} panoramas share a pose each, {} of them without matches of their own; error {:.2f} -> {:.2f} px",
           effect.views, effect.rigs, effect.completed, effect.error_before, effect.error_after);
}

}  // namespace vitrine
