#include "stages/sfm/gains/rig_adjustment.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "stages/sfm/gains/ceres_log.h"

namespace vitrine {

namespace {

constexpr double kRigRobust = 1;  // pixel
constexpr int kMostRigSteps = 30;
constexpr size_t kDenseBodies = 200;

// Reprojection error against an observation without distortion.
class RigReprojection {
 public:
  RigReprojection(const Quatd& from_body, const Vec2d& direction, const Vec2d& focal)
      : from_body_{from_body.w, from_body.x, from_body.y, from_body.z}, direction_(direction), focal_(focal) {}

  template <class T>
  bool operator()(const T* rotation, const T* translation, const T* point, T* residual) const {
    T body[3], camera[3];
    ceres::UnitQuaternionRotatePoint(rotation, point, body);
    for (int i = 0; i < 3; ++i) body[i] += translation[i];
    const T from_body[4] = {T(from_body_[0]), T(from_body_[1]), T(from_body_[2]), T(from_body_[3])};
    ceres::UnitQuaternionRotatePoint(from_body, body, camera);
    residual[0] = focal_.x * (camera[0] / camera[2] - direction_.x);
    residual[1] = focal_.y * (camera[1] / camera[2] - direction_.y);
    return true;
  }

 private:
  std::array<double, 4> from_body_;
  Vec2d direction_, focal_;
};

struct Body {
  std::array<double, 4> rotation{1, 0, 0, 0};  // body_from_world
  Vec3d translation{};
};

// body_from_world of each body, from its first image.
std::map<size_t, Body> bodies_of(const ColmapModel& model, std::span<const RigCamera> cameras) {
  std::map<size_t, Body> bodies;
  for (size_t i = 0; i < cameras.size(); ++i) {
    if (bodies.contains(cameras[i].body)) continue;
    const Mat3d back = transposed(rotation_matrix(normalized(cameras[i].from_body)));
    const Rigid pose = model.images[i].cam_from_world();
    const Quatd q = quaternion(back * pose.rotation);
    bodies[cameras[i].body] = {{q.w, q.x, q.y, q.z}, back * pose.translation};
  }
  return bodies;
}

void set_poses(ColmapModel& model, std::span<const RigCamera> cameras, const std::map<size_t, Body>& bodies) {
  for (size_t i = 0; i < cameras.size(); ++i) {
    const Body& body = bodies.at(cameras[i].body);
    const auto& r = body.rotation;
    const Mat3d from_body = rotation_matrix(normalized(cameras[i].from_body));
    model.images[i].rotation = quaternion(from_body * rotation_matrix(normalized(Quatd{r[0], r[1], r[2], r[3]})));
    model.images[i].translation = from_body * body.translation;
  }
}

// Mean error of each point, in pixels.
void set_errors(ColmapModel& model) {
  for (ColmapPoint3D& point : model.points) {
    double sum = 0;
    for (const ColmapTrackElement& seen : point.track) {
      const ColmapImage& image = *model.find_image(seen.image_id);
      const ColmapPoint2D& at = image.points[seen.point2d_index];
      const Vec3d p = image.cam_from_world() * point.position;
      const Vec2d pixel = project(*model.find_camera(image.camera_id), {p.x / p.z, p.y / p.z});
      sum += std::hypot(pixel.x - at.x, pixel.y - at.y);
    }
    if (!point.track.empty()) point.error_px = sum / double(point.track.size());
  }
}

}  // namespace

RigAdjustment adjust_rigs(ColmapModel& model, std::span<const RigCamera> cameras) {
  RigAdjustment result;
  std::map<size_t, Body> bodies = bodies_of(model, cameras);
  ceres::HuberLoss loss(kRigRobust);
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  for (ColmapPoint3D& point : model.points)
    for (const ColmapTrackElement& seen : point.track) {
      const auto image = std::ranges::lower_bound(model.images, seen.image_id, {}, &ColmapImage::id);
      const RigCamera& camera = cameras[size_t(image - model.images.begin())];
      const ColmapCamera& lens = *model.find_camera(image->camera_id);
      const ColmapPoint2D& at = image->points[seen.point2d_index];
      const std::optional<Vec2d> direction = unproject(lens, {at.x, at.y});
      if (!direction) continue;
      const Intrinsics k = pinhole_part(lens);
      Body& body = bodies.at(camera.body);
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<RigReprojection, 2, 4, 3, 3>(
                                   new RigReprojection(normalized(camera.from_body), *direction, {k.fx, k.fy})),
                               &loss, body.rotation.data(), &body.translation.x, &point.position.x);
      ++result.observations;
    }
  if (result.observations > 0) {
    auto* sphere = new ceres::QuaternionManifold;  // one instance, owned by the problem
    bool fixed = false;                            // the gauge: the pose of the scene is arbitrary
    for (auto& [id, body] : bodies) {
      if (!problem.HasParameterBlock(body.rotation.data())) continue;
      problem.SetManifold(body.rotation.data(), sphere);
      if (fixed) continue;
      problem.SetParameterBlockConstant(body.rotation.data());
      problem.SetParameterBlockConstant(&body.translation.x);
      fixed = true;
    }
    ceres_to_log();
    ceres::Solver::Options options;
    options.linear_solver_type = bodies.size() <= kDenseBodies ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
    options.max_num_iterations = kMostRigSteps;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    const auto rms = [&](double cost) { return std::sqrt(2 * cost / double(result.observations)); };
    result.error_before = rms(summary.initial_cost), result.error_after = rms(summary.final_cost);
  }
  set_poses(model, cameras, bodies);
  set_errors(model);
  return result;
}

}  // namespace vitrine
