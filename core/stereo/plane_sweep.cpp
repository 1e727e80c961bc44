#include "core/stereo/plane_sweep.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace vitrine {

namespace {

constexpr int kRadius = 3;  // patches of 7x7 pixels
constexpr size_t kPatch = (2 * kRadius + 1) * (2 * kRadius + 1);
constexpr size_t kNeighbours = 6;
constexpr int kDepths = 80;          // steps of inverse depth
constexpr float kFlat = 0.015f;      // standard deviation of a patch without texture
constexpr double kConvincing = 0.8;  // NCC
constexpr double kMinAxisCosine = 0.6;

// NaN outside.
float bilinear(const ImageF& image, double x, double y) {
  const double fx = x - 0.5, fy = y - 0.5;
  if (!(fx >= 0 && fy >= 0 && fx < image.width() - 1 && fy < image.height() - 1)) return NAN;
  const int x0 = int(fx), y0 = int(fy);
  const float u = float(fx - x0), v = float(fy - y0);
  const float* top = image.pixel(x0, y0);
  const float* bottom = image.pixel(x0, y0 + 1);
  return (1 - v) * ((1 - u) * top[0] + u * top[1]) + v * ((1 - u) * bottom[0] + u * bottom[1]);
}

// Zero mean, unit length; false when flat or partly outside.
bool normalise(std::vector<float>& patch) {
  float mean = 0, squares = 0;
  for (float p : patch) mean += p / float(kPatch);
  if (!std::isfinite(mean)) return false;
  for (float& p : patch) {
    p -= mean;
    squares += p * p;
  }
  if (squares < kFlat * kFlat * float(kPatch)) return false;
  for (float& p : patch) p /= std::sqrt(squares);
  return true;
}

Vec2d projected(const View& view, const Vec3d& in_cam) {
  const Intrinsics& k = view.intrinsics;
  return {k.fx * in_cam.x / in_cam.z + k.cx, k.fy * in_cam.y / in_cam.z + k.cy};
}

// Photos beside `reference` that look the same way, nearest first: enough parallax comes from the capture itself.
std::vector<uint32_t> neighbours_of(const std::vector<SweepPhoto>& photos, uint32_t reference) {
  const View& own = photos[reference].view;
  const Vec3d axis = transposed_times(own.cam_from_world.rotation, Vec3d{0, 0, 1});
  std::vector<std::pair<double, uint32_t>> near;
  for (uint32_t other = 0; other < photos.size(); ++other) {
    if (other == reference || photos[other].grey.empty()) continue;
    const View& view = photos[other].view;
    if (dot(axis, transposed_times(view.cam_from_world.rotation, Vec3d{0, 0, 1})) < kMinAxisCosine) continue;
    near.emplace_back(squared_length(view.centre_in_world() - own.centre_in_world()), other);
  }
  std::sort(near.begin(), near.end());
  std::vector<uint32_t> found;
  for (size_t i = 0; i < std::min(near.size(), kNeighbours); ++i) found.push_back(near[i].second);
  return found;
}

}  // namespace

PlaneSweep::PlaneSweep(std::vector<SweepPhoto> photos) : pictures_(photos.size()) {
  for (uint32_t p = 0; p < photos.size(); ++p)
    if (!photos[p].grey.empty()) pictures_[p].neighbours = neighbours_of(photos, p);
  for (size_t p = 0; p < photos.size(); ++p) {
    pictures_[p].view = photos[p].view;
    pictures_[p].grey = std::move(photos[p].grey);
  }
}

double PlaneSweep::score(const Picture& reference, const std::vector<float>& patch, const Vec3d& ray, const Vec3d& normal,
                         double z, double x, double y) const {
  const Rigid world_from_cam = inverse(reference.view.cam_from_world);
  const Vec3d centre = z * ray;
  // Where the plane through `centre` meets the rays of the pixels to the right and below: the patch's affine map follows.
  const Intrinsics& k = reference.view.intrinsics;
  const double along = dot(normal, centre);
  std::array<Vec3d, 3> corners{centre, k.ray(x + kRadius, y), k.ray(x, y + kRadius)};
  for (size_t c = 1; c < 3; ++c) {
    const double facing = dot(normal, corners[c]);
    if (std::abs(facing) < 1e-9 || along / facing <= 0) return -1;
    corners[c] = (along / facing) * corners[c];
  }
  std::array<double, kNeighbours> scores;
  size_t count = 0;
  std::vector<float> other(kPatch);
  for (uint32_t n : reference.neighbours) {
    const Picture& picture = pictures_[n];
    std::array<Vec2d, 3> at;
    bool visible = true;
    for (size_t c = 0; c < 3; ++c) {
      const Vec3d p = picture.view.cam_from_world * (world_from_cam * corners[c]);
      if (!(visible = visible && p.z > 1e-6)) break;
      at[c] = projected(picture.view, p);
    }
    if (!visible) continue;
    const Vec2d right = (1.0 / kRadius) * (at[1] - at[0]), down = (1.0 / kRadius) * (at[2] - at[0]);
    size_t i = 0;
    for (int dy = -kRadius; dy <= kRadius; ++dy)
      for (int dx = -kRadius; dx <= kRadius; ++dx)
        other[i++] = bilinear(picture.grey, at[0].x + dx * right.x + dy * down.x, at[0].y + dx * right.y + dy * down.y);
    if (!normalise(other)) continue;
    double ncc = 0;
    for (size_t p = 0; p < kPatch; ++p) ncc += double(patch[p]) * other[p];
    scores[count++] = ncc;
  }
  if (count < 2) return -1;
  // Mean of the better half: a view that does not see the point must not decide.
  const size_t better = std::max<size_t>(2, (count + 1) / 2);
  double sum = 0;
  for (size_t i = 0; i < better; ++i) {
    double* largest = std::max_element(scores.data() + i, scores.data() + count);
    std::swap(scores[i], *largest);
    sum += scores[i];
  }
  return sum / double(better);
}

std::optional<SweptPoint> PlaneSweep::at(uint32_t photo, double x, double y, double near_z, double far_z) const {
  const Picture& reference = pictures_[photo];
  if (reference.grey.empty() || reference.neighbours.size() < 2) return std::nullopt;
  std::vector<float> patch;
  for (int dy = -kRadius; dy <= kRadius; ++dy)
    for (int dx = -kRadius; dx <= kRadius; ++dx) patch.push_back(bilinear(reference.grey, x + dx, y + dy));
  if (!normalise(patch)) return std::nullopt;

  const Vec3d ray = reference.view.intrinsics.ray(x, y), towards = -normalized(ray);
  // Facing the camera, and lying like a floor or a table: the world's up is +z.
  const Vec3d up = reference.view.cam_from_world.rotation * Vec3d{0, 0, 1};
  std::vector<Vec3d> normals{towards};
  if (dot(up, towards) > 0.1) normals.push_back(up);
  // An upright wall, turned towards the camera.
  if (const Vec3d level = towards - dot(towards, up) * up; length(level) > 0.3) normals.push_back(normalized(level));

  SweptPoint best{.score = -1};
  Vec3d best_normal{};
  const auto attempt = [&](const Vec3d& normal, double inverse_z) {
    const double s = score(reference, patch, ray, normal, 1 / inverse_z, x, y);
    if (s > best.score) {
      best.score = s;
      best.zdepth = 1 / inverse_z;
      best_normal = normal;
    }
  };
  const double step = (1 / near_z - 1 / far_z) / (kDepths - 1);
  for (const Vec3d& normal : normals)
    for (int d = 0; d < kDepths; ++d) attempt(normal, 1 / far_z + d * step);
  for (double fine : {0.5, 0.25, 0.125}) {
    const double middle = 1 / best.zdepth;
    const Vec3d normal = best_normal;
    attempt(normal, std::max(middle - fine * step, 0.25 / far_z));
    attempt(normal, middle + fine * step);
  }
  if (best.score < kConvincing) return std::nullopt;
  best.normal_in_world = transposed_times(reference.view.cam_from_world.rotation, best_normal);
  return best;
}

}  // namespace vitrine
