#include "core/observe/stereo/patch_match.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/scene/camera/projection.h"
#include "core/observe/stereo/patch_score.h"

namespace vitrine {

namespace {

enum : uint64_t { kPlaneStream = 0x5701 };

constexpr double kMostSlantedMatch = 0.15;  // minimum cosine between the normal and the ray
constexpr double kSurelyRotated = 0.9998;   // of two normals: above it a plane counts as the same and is not scored again
constexpr float kLonelyPenalty = 0.1f;      // for a plane that only one neighbour sees
constexpr float kGoodScore = 0.75f;
constexpr double kAgreeDepth = 0.02, kAgreePixels = 1.5;

struct PlaneHypothesis {
  double z;      // along the pixel's ray (z = 1)
  Vec3d normal;  // camera frame, towards the camera
};

class Scan {
 public:
  Scan(std::span<const StereoPhoto> photos, uint32_t reference, const PatchMatchDesc& desc)
      : photo_(photos[reference]), photos_(photos), rng_(desc.seed, mix64(kPlaneStream, reference)) {
    for (uint32_t n : photo_.neighbours) transfers_.push_back(transfer_between(photo_.view, photos[n].view));
    const Intrinsics& k = photo_.view.intrinsics;
    width_ = k.width, height_ = k.height;
    planes_.resize(size_t(width_) * size_t(height_));
    scores_.resize(planes_.size(), -1.f);
    nearest_ = 1 / photo_.near_z, farthest_ = 1 / photo_.far_z;
    up_ = photo_.view.cam_from_world.rotation * Vec3d{0, 0, 1};
  }

  DepthMap run(int iterations) {
    start();
    for (int i = 0; i < iterations; ++i) sweep(i);
    DepthMap map;
    map.width = width_, map.height = height_;
    map.score = scores_;
    map.agreeing.resize(planes_.size(), 0);
    map.trusted.resize(planes_.size(), 0);
    for (const PlaneHypothesis& p : planes_) {
      map.zdepth.push_back(float(p.z));
      map.normal.push_back(cast<float>(p.normal));
    }
    return map;
  }

 private:
  Vec3d ray(int x, int y) const { return photo_.view.intrinsics.ray(x + 0.5, y + 0.5); }

  float score(const ReferencePatch& patch, const PlaneHypothesis& plane, int x, int y) const {
    const Vec3d r = ray(x, y);
    const double offset = plane.z * dot(plane.normal, r);  // negative: the normal faces the camera
    if (!(plane.z >= photo_.near_z && plane.z <= photo_.far_z) || !(offset < 0)) return -1;
    if (-dot(plane.normal, r) < kMostSlantedMatch * length(r)) return -1;
    const Intrinsics& k = photo_.view.intrinsics;
    const Vec3d n = plane.normal / offset;
    const Vec3d by_pixel{n.x / k.fx, n.y / k.fy, n.z - n.x * k.cx / k.fx - n.y * k.cy / k.fy};
    float best = -2, second = -2;
    for (size_t i = 0; i < transfers_.size(); ++i) {
      if (dot(plane.normal, transfers_[i].centre) <= offset) continue;  // back-facing for that camera
      const float s = patch_score(patch, photos_[photo_.neighbours[i]].luma, transfers_[i], by_pixel, x + 0.5, y + 0.5);
      if (s > best)
        second = std::exchange(best, s);
      else if (s > second)
        second = s;
    }
    if (best < -1.5f) return -1;
    return second < -1.5f ? best - kLonelyPenalty : 0.5f * (best + second);
  }

  bool attempt(const ReferencePatch& patch, const PlaneHypothesis& plane, int x, int y) {
    const float s = score(patch, plane, x, y);
    const size_t i = at(x, y);
    if (!(s > scores_[i])) return false;
    planes_[i] = plane;
    scores_[i] = s;
    return true;
  }

  Vec3d turned(const Vec3d& normal, double amount) {
    const Vec3d jitter{rng_.uniform_double() - 0.5, rng_.uniform_double() - 0.5, rng_.uniform_double() - 0.5};
    return normalized(normal + (2 * amount) * jitter);
  }
  double random_inverse() { return farthest_ + rng_.uniform_double() * (nearest_ - farthest_); }

  // Depth of the nearest sparse point on a coarse grid; used as the first hypothesis.
  std::vector<double> hinted() const {
    std::vector<double> z(planes_.size(), 0);
    std::vector<std::pair<int, int>> front;
    for (const Vec3d& h : photo_.hints) {
      const int x = int(h.x), y = int(h.y);
      if (x < 0 || y < 0 || x >= width_ || y >= height_) continue;
      if (z[at(x, y)] == 0) front.emplace_back(x, y);
      z[at(x, y)] = h.z;
    }
    for (size_t i = 0; i < front.size(); ++i) {  // breadth-first: nearest in city-block distance
      const auto [x, y] = front[i];
      for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        const int nx = x + dx, ny = y + dy;
        if (nx < 0 || ny < 0 || nx >= width_ || ny >= height_ || z[at(nx, ny)] != 0) continue;
        z[at(nx, ny)] = z[at(x, y)];
        front.emplace_back(nx, ny);
      }
    }
    return z;
  }

  void start() {
    const std::vector<double> hint = hinted();
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        const Vec3d towards = -normalized(ray(x, y));
        const ReferencePatch patch = reference_patch(photo_.luma, x, y);
        const size_t i = at(x, y);
        planes_[i] = {hint[i] > 0 ? std::clamp(hint[i], photo_.near_z, photo_.far_z) : 1 / random_inverse(), towards};
        if (patch.flat()) continue;
        scores_[i] = score(patch, planes_[i], x, y);
        attempt(patch, {1 / random_inverse(), turned(towards, 0.7)}, x, y);
        const double z = planes_[i].z;
        // Prior for man-made scenes: try a horizontal plane (floor, table) and a vertical one (wall).
        attempt(patch, {z, up_}, x, y);
        if (const Vec3d level = towards - dot(towards, up_) * up_; length(level) > 0.2)
          attempt(patch, {z, normalized(level)}, x, y);
      }
  }

  void sweep(int iteration) {
    const int step = iteration % 2 == 0 ? 1 : -1;
    const double amount = std::pow(0.5, iteration + 1);
    for (int row = 0; row < height_; ++row)
      for (int column = 0; column < width_; ++column) {
        const int x = step > 0 ? column : width_ - 1 - column, y = step > 0 ? row : height_ - 1 - row;
        const ReferencePatch patch = reference_patch(photo_.luma, x, y);
        const size_t i = at(x, y);
        const Vec3d own_ray = ray(x, y);
        for (const auto& [nx, ny] : {std::pair{x - step, y}, {x, y - step}}) {
          if (nx < 0 || ny < 0 || nx >= width_ || ny >= height_) continue;
          const PlaneHypothesis& near = planes_[at(nx, ny)];
          const double facing = dot(near.normal, own_ray);
          if (facing > -1e-6) continue;
          const PlaneHypothesis carried{near.z * dot(near.normal, ray(nx, ny)) / facing, near.normal};
          if (patch.flat()) {  // a textureless patch takes the plane of its neighbour
            if (scores_[at(nx, ny)] >= 0.5f && carried.z >= photo_.near_z && carried.z <= photo_.far_z) planes_[i] = carried;
            continue;
          }
          if (std::abs(carried.z / planes_[i].z - 1) < 1e-4 && dot(carried.normal, planes_[i].normal) > kSurelyRotated) continue;
          attempt(patch, carried, x, y);
        }
        if (patch.flat()) continue;
        const auto nudged = [&] {
          return 1 / std::clamp(1 / planes_[i].z + amount * 0.1 * (2 * rng_.uniform_double() - 1) * (nearest_ - farthest_),
                                farthest_, nearest_);
        };
        attempt(patch, {nudged(), planes_[i].normal}, x, y);
        attempt(patch, {planes_[i].z, turned(planes_[i].normal, amount)}, x, y);
        attempt(patch, {nudged(), turned(planes_[i].normal, amount)}, x, y);
        if (iteration < 2) attempt(patch, {1 / random_inverse(), turned(-normalized(own_ray), 0.7)}, x, y);
      }
  }

  size_t at(int x, int y) const { return size_t(y) * size_t(width_) + size_t(x); }

  const StereoPhoto& photo_;
  std::span<const StereoPhoto> photos_;
  Rng rng_;
  std::vector<Transfer> transfers_;
  std::vector<PlaneHypothesis> planes_;
  std::vector<float> scores_;
  int width_, height_;
  double nearest_, farthest_;  // inverse depths
  Vec3d up_;
};

}  // namespace

std::vector<DepthMap> patch_match(std::span<const StereoPhoto> photos, const PatchMatchDesc& desc) {
  std::vector<DepthMap> maps(photos.size());
  parallel_for(photos.size(), 1, [&](size_t i) {
    if (!photos[i].luma.empty() && !photos[i].neighbours.empty()) maps[i] = Scan(photos, uint32_t(i), desc).run(desc.iterations);
  });
  return maps;
}

void count_agreement(std::span<const StereoPhoto> photos, std::span<DepthMap> maps) {
  parallel_for(photos.size(), 1, [&](size_t i) {
    DepthMap& map = maps[i];
    const StereoPhoto& photo = photos[i];
    const Intrinsics& k = photo.view.intrinsics;
    std::fill(map.agreeing.begin(), map.agreeing.end(), uint8_t(0));
    for (uint32_t n : photo.neighbours) {
      const DepthMap& other = maps[n];
      if (other.zdepth.empty()) continue;
      const Rigid there = photos[n].view.cam_from_world * inverse(photo.view.cam_from_world), back = inverse(there);
      const Intrinsics& ko = photos[n].view.intrinsics;
      for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
          const Vec3d p = there * (double(map.zdepth[map.index(x, y)]) * k.ray(x + 0.5, y + 0.5));
          const auto at = image_point(p, ko, 1e-6);
          if (!at) continue;
          const size_t j = other.index(int(at->x), int(at->y));
          // Intersection of this ray with the plane of the other map's pixel.
          const Vec3d normal = cast<double>(other.normal[j]), ray = ko.ray(at->x, at->y);
          const double facing = dot(normal, ray);
          if (facing > -1e-6) continue;
          const double z = double(other.zdepth[j]) * dot(normal, ko.ray(int(at->x) + 0.5, int(at->y) + 0.5)) / facing;
          if (!(std::abs(z / p.z - 1) < kAgreeDepth)) continue;
          const auto returned = projection(back * (z * ray), k, 1e-6);
          if (!returned) continue;
          const double ex = returned->x - (x + 0.5), ey = returned->y - (y + 0.5);
          if (ex * ex + ey * ey < kAgreePixels * kAgreePixels) ++map.agreeing[map.index(x, y)];
        }
    }
    for (size_t p = 0; p < map.trusted.size(); ++p) map.trusted[p] = map.agreeing[p] >= 1 && map.score[p] >= kGoodScore;
  });
}

std::vector<std::vector<uint32_t>> stereo_neighbours(const ViewSet& set, std::span<const uint32_t> use, size_t count) {
  const size_t n = set.views.size();
  std::vector<Vec3d> centres;
  for (const View& view : set.views) centres.push_back(view.centre_in_world());
  std::vector<bool> usable(n, false);
  for (uint32_t v : use) usable[v] = true;
  // Weight of a shared point by the angle between its two rays: zero below one degree, full from ten degrees.
  std::vector<double> shared(n * n, 0);
  for (const ScenePoint& point : set.points)
    for (uint32_t a : point.views)
      for (uint32_t b : point.views) {
        if (a == b || !usable[a] || !usable[b]) continue;
        const Vec3d da = normalized(centres[a] - point.position), db = normalized(centres[b] - point.position);
        const double degrees = std::acos(std::clamp(dot(da, db), -1.0, 1.0)) * 57.29578;
        if (degrees < 1 || degrees > 70) continue;
        shared[a * n + b] += std::min(degrees / 10, 1.0);
      }
  std::vector<std::vector<uint32_t>> found(n);
  for (uint32_t a : use) {
    std::vector<uint32_t> order;
    for (uint32_t b : use)
      if (b != a) order.push_back(b);
    std::sort(order.begin(), order.end(), [&](uint32_t l, uint32_t r) {
      const double sl = shared[a * n + l], sr = shared[a * n + r];
      if (sl != sr) return sl > sr;
      const double dl = squared_length(centres[l] - centres[a]), dr = squared_length(centres[r] - centres[a]);
      return dl != dr ? dl < dr : l < r;
    });
    order.resize(std::min(order.size(), count));
    found[a] = std::move(order);
  }
  return found;
}

}  // namespace vitrine
