#include "stages/sfm/gains/bundle.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "stages/sfm/gains/ceres_log.h"

namespace vitrine {

namespace {

constexpr double kRobust = 1;  // pixel
constexpr size_t kDenseImages = 200;

// Supported lens models of COLMAP: number of focal lengths and distortion parameters.
struct Lens {
  size_t focals = 1, distortion = 0;
};
const Lens* lens_of(int model_id) {
  static const std::map<int, Lens> lenses{{0, {1, 0}}, {1, {2, 0}}, {2, {1, 1}}, {3, {1, 2}}, {4, {2, 4}}};
  const auto it = lenses.find(model_id);
  return it == lenses.end() ? nullptr : &it->second;
}

// Projects a point of the camera frame to pixels: focal lengths, principal point, and k1 k2 p1 p2 as far as the model has them.
class Reprojection {
 public:
  Reprojection(const Lens& lens, double x, double y) : lens_(lens), x_(x), y_(y) {}

  template <class T>
  bool operator()(const T* const* blocks, T* residual) const {
    const T *rotation = blocks[0], *translation = blocks[1], *point = blocks[2], *focal = blocks[3], *centre = blocks[4];
    T p[3];
    ceres::UnitQuaternionRotatePoint(rotation, point, p);
    for (int i = 0; i < 3; ++i) p[i] += translation[i];
    const T u = p[0] / p[2], v = p[1] / p[2], r2 = u * u + v * v;
    T du = T(0), dv = T(0);
    if (lens_.distortion > 0) {
      const T* k = blocks[5];
      T radial = k[0] * r2;
      if (lens_.distortion > 1) radial += k[1] * r2 * r2;
      du = u * radial, dv = v * radial;
      if (lens_.distortion > 2) {
        du += T(2) * k[2] * u * v + k[3] * (r2 + T(2) * u * u);
        dv += T(2) * k[3] * u * v + k[2] * (r2 + T(2) * v * v);
      }
    }
    residual[0] = focal[0] * (u + du) + centre[0] - x_;
    residual[1] = focal[lens_.focals - 1] * (v + dv) + centre[1] - y_;
    return true;
  }

 private:
  const Lens& lens_;
  double x_, y_;
};

}  // namespace

class BundleAdjustment::Problem {
 public:
  Problem(ColmapModel& model, Focals focals) : model_(model) {
    if (focals == Focals::OfPhotos)
      for (const ColmapImage& image : model_.images) {
        const std::vector<double>& params = model_.find_camera(image.camera_id)->params;
        focals_[image.id] = {params[0], params[1]};
      }
    for (ColmapImage& image : model_.images) {
      const Quatd q = normalized(image.rotation);
      image.rotation = q;
      rotations_[image.id] = {q.w, q.x, q.y, q.z};
    }
    for (ColmapPoint3D& point : model_.points)
      for (const ColmapTrackElement& seen : point.track) add(point, seen);
    if (observations_ == 0) return;
    auto* sphere = new ceres::QuaternionManifold;  // one instance, owned by the problem
    for (auto& [id, rotation] : rotations_)
      if (problem_.HasParameterBlock(rotation.data())) problem_.SetManifold(rotation.data(), sphere);
    // Fixes the gauge: the pose of the scene is arbitrary.
    for (ColmapImage& image : model_.images)
      if (problem_.HasParameterBlock(&image.translation.x)) {
        problem_.SetParameterBlockConstant(&image.translation.x);
        problem_.SetParameterBlockConstant(rotations_.at(image.id).data());
        break;
      }
  }
  size_t observations() const { return observations_; }

  double error() {
    double cost = HUGE_VAL;
    return problem_.Evaluate({}, &cost, nullptr, nullptr, nullptr) ? std::sqrt(2 * cost / double(observations_)) : HUGE_VAL;
  }

  // Returns the root mean square error after the adjustment.
  double solve(bool principal_points, int steps) {
    for (ColmapCamera& camera : model_.cameras) {
      double* centre = camera.params.data() + lens_of(camera.model_id)->focals;
      if (!problem_.HasParameterBlock(centre)) continue;
      if (principal_points)
        problem_.SetParameterBlockVariable(centre);
      else
        problem_.SetParameterBlockConstant(centre);
    }
    ceres_to_log();
    ceres::Solver::Options options;
    options.linear_solver_type = model_.images.size() <= kDenseImages ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
    options.max_num_iterations = steps;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    return summary.IsSolutionUsable() ? std::sqrt(2 * summary.final_cost / double(observations_)) : HUGE_VAL;
  }

  std::vector<double> focals() const {
    std::vector<double> out;
    for (const ColmapImage& image : model_.images) {
      const double* focal = focals_.empty() ? model_.find_camera(image.camera_id)->params.data() : focals_.at(image.id).data();
      out.push_back(problem_.HasParameterBlock(&image.translation.x) ? focal[0] : 0);
    }
    return out;
  }

  // Updates what the solver does not store in the model: rotations and point errors.
  void finish() {
    for (ColmapImage& image : model_.images) {
      const auto& r = rotations_.at(image.id);
      image.rotation = normalized(Quatd{r[0], r[1], r[2], r[3]});
    }
    for (ColmapPoint3D& point : model_.points) {
      double sum = 0;
      for (const ColmapTrackElement& seen : point.track) {
        const Sighting s = sighting(point, seen);
        double residual[2];
        s.reprojection(s.blocks.data(), residual);
        sum += std::hypot(residual[0], residual[1]);
      }
      if (!point.track.empty()) point.error_px = sum / double(point.track.size());
    }
  }

 private:
  struct Sighting {
    Reprojection reprojection;
    std::vector<double*> blocks;
    std::vector<int> sizes;
  };
  Sighting sighting(ColmapPoint3D& point, const ColmapTrackElement& seen) {
    auto image = std::ranges::lower_bound(model_.images, seen.image_id, {}, &ColmapImage::id);
    auto camera = std::ranges::lower_bound(model_.cameras, image->camera_id, {}, &ColmapCamera::id);
    const Lens& lens = *lens_of(camera->model_id);
    const ColmapPoint2D& at = image->points[seen.point2d_index];
    double* params = camera->params.data();
    Sighting s{Reprojection(lens, at.x, at.y),
               {rotations_.at(image->id).data(), &image->translation.x, &point.position.x,
                focals_.empty() ? params : focals_.at(image->id).data(), params + lens.focals},
               {4, 3, 3, int(lens.focals), 2}};
    if (lens.distortion > 0) s.blocks.push_back(params + lens.focals + 2), s.sizes.push_back(int(lens.distortion));
    return s;
  }

  void add(ColmapPoint3D& point, const ColmapTrackElement& seen) {
    const Sighting s = sighting(point, seen);
    auto* cost = new ceres::DynamicAutoDiffCostFunction<Reprojection, 4>(new Reprojection(s.reprojection));
    for (int size : s.sizes) cost->AddParameterBlock(size);
    cost->SetNumResiduals(2);
    problem_.AddResidualBlock(cost, &loss_, s.blocks);
    ++observations_;
  }

  static ceres::Problem::Options options() {
    ceres::Problem::Options o;
    o.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return o;
  }

  ColmapModel& model_;
  std::map<uint32_t, std::array<double, 4>> rotations_;
  std::map<uint32_t, std::array<double, 2>> focals_;  // of photos, if each has its own
  ceres::HuberLoss loss_{kRobust};
  ceres::Problem problem_{options()};
  size_t observations_ = 0;
};

BundleAdjustment::BundleAdjustment(ColmapModel& model, Focals focals) : problem_(std::make_unique<Problem>(model, focals)) {}
BundleAdjustment::~BundleAdjustment() = default;
size_t BundleAdjustment::observations() const { return problem_->observations(); }
double BundleAdjustment::error() { return problem_->error(); }
double BundleAdjustment::solve(bool principal_points, int steps) { return problem_->solve(principal_points, steps); }
std::vector<double> BundleAdjustment::focals() const { return problem_->focals(); }
void BundleAdjustment::finish() { problem_->finish(); }

bool bundle_supports(const ColmapModel& model) {
  return std::ranges::all_of(model.cameras, [](const ColmapCamera& c) { return lens_of(c.model_id) != nullptr; });
}

size_t focal_count(const ColmapCamera& camera) { return lens_of(camera.model_id)->focals; }

}  // namespace vitrine
