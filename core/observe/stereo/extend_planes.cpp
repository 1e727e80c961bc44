
#include <algorithm>
#include <cmath>
#include <optional>
#include <queue>
#include <utility>

#include "core/scene/camera/projection.h"
#include "core/observe/stereo/patch_score.h"
#include "core/observe/stereo/scene_planes.h"

namespace vitrine {

namespace {

constexpr double kEdgeCost = 40;      // path length of a full brightness step, in pixels
constexpr double kLongestBlind = 40;  // maximum path length of an extrapolation where no other photo looks
constexpr double kMostStretched = 4;  // maximum depth ratio to the source pixel for an extrapolation
constexpr double kMostSlanted = 0.1;  // minimum cosine between ray and normal

// Costs of a candidate, in brightness.
constexpr float kImpossible = 1;
constexpr float kUnseen = 0.06f;                     // not visible in any other photo
constexpr float kContradicted = 0.6f;                // occludes reliable surfaces of other photos, or lies close to their cameras
constexpr float kOtherSurface = 0.07f;               // at a reliable pixel: differs from its surface
constexpr float kLocalHandicap = 0.005f;             // a large plane is more accurate than an extrapolation of a few pixels
constexpr float kFarHandicap = 0.02f;                // textureless plaster matches at any depth
constexpr double kSameDepth = 0.02, kBefore = 0.06;  // relative depths
constexpr double kReach = 4;                         // pixels: radius of the cost filter
constexpr int kAverages = 2;

struct Nearest {
  std::vector<double> path;      // path length in pixels, including edge costs
  std::vector<uint32_t> source;  // the reliable pixel where the path starts
};

Nearest nearest_reliable(const ImageF& luma, const DepthMap& map) {
  const size_t pixels = map.zdepth.size();
  Nearest nearest{std::vector<double>(pixels, 1e300), std::vector<uint32_t>(pixels)};
  using Entry = std::pair<double, uint32_t>;  // ties broken by index, for a deterministic order
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  for (size_t i = 0; i < pixels; ++i)
    if (map.reliable(i)) {
      nearest.path[i] = 0;
      nearest.source[i] = uint32_t(i);
      open.emplace(0.0, uint32_t(i));
    }
  while (!open.empty()) {
    const auto [c, i] = open.top();
    open.pop();
    if (c > nearest.path[i]) continue;
    const int x = int(i) % map.width, y = int(i) / map.width;
    for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const int u = x + dx, v = y + dy;
      if (u < 0 || v < 0 || u >= map.width || v >= map.height) continue;
      const size_t j = map.index(u, v);
      const double next = c + 1 + kEdgeCost * double(std::abs(luma.at(u, v) - luma.at(x, y)));
      if (!(next < nearest.path[j])) continue;
      nearest.path[j] = next;
      nearest.source[j] = nearest.source[i];
      open.emplace(next, uint32_t(j));
    }
  }
  return nearest;
}

// Photometric and occlusion cost of a plane at a pixel, from the other photos.
class Witnesses {
 public:
  Witnesses(std::span<const StereoPhoto> photos, std::span<const DepthMap> maps, size_t index)
      : photos_(photos), maps_(maps), photo_(photos[index]) {
    for (size_t o = 0; o < photos.size(); ++o)
      if (o != index && !photos[o].luma.empty() && !maps[o].zdepth.empty())
        others_.push_back({o, transfer_between(photo_.view, photos[o].view),
                           photos[o].view.cam_from_world * inverse(photo_.view.cam_from_world)});
  }

  // Mean brightness difference to the two best matching photos, plus a penalty for occluding their reliable surfaces or lying
  // close to their cameras.
  float cost(const ReferencePatch& patch, const InversePlane& plane, double x, double y) const {
    const Vec3d point = photo_.view.intrinsics.ray(x, y) / plane.at(x, y);
    float best = 1, second = 1;
    double against = 0, in_favour = 0;
    for (const Other& other : others_) {
      const Vec3d p = other.from_reference * point;
      // The space around a camera is empty in every direction.
      if (dot(p, p) < photos_[other.index].near_z * photos_[other.index].near_z) {
        against += 1;
        continue;
      }
      const auto at = image_point(p, photos_[other.index].view.intrinsics);
      if (!at) continue;
      const DepthMap& map = maps_[other.index];
      const size_t pixel = map.index(int(at->x), int(at->y));
      if (map.reliable(pixel)) {
        const double z = double(map.zdepth[pixel]);
        if (p.z > (1 + kBefore) * z) continue;  // occluded there
        if (p.z < (1 - kBefore) * z)
          against += 1;
        else if (std::abs(p.z - z) < kSameDepth * z)
          in_favour += 1;
      }
      const float d = patch_difference(patch, photos_[other.index].luma, other.transfer, {plane.a, plane.b, plane.c}, x, y);
      if (d < 0) continue;
      if (d < best)
        second = std::exchange(best, d);
      else if (d < second)
        second = d;
    }
    const float unexplained = second < 1 ? 0.5f * (best + second) : best < 1 ? best : kUnseen;
    return unexplained + kContradicted * float(against / (against + in_favour + 0.5));
  }

 private:
  struct Other {
    size_t index;
    Transfer transfer;
    Rigid from_reference;
  };
  std::span<const StereoPhoto> photos_;
  std::span<const DepthMap> maps_;
  const StereoPhoto& photo_;
  std::vector<Other> others_;
};

// Edge-preserving average: recursive filter forward and back along rows, then columns (Gastal and Oliveira, "Domain Transform
// for Edge-Aware Image and Video Processing", 2011).
void average_alike(const ImageF& luma, std::vector<float>& values) {
  const int width = luma.width(), height = luma.height();
  const auto carry = [&](int x, int y, int u, int v) {
    const float keep = std::exp(-(1 + float(kEdgeCost) * std::abs(luma.at(x, y) - luma.at(u, v))) / float(kReach));
    float& value = values[size_t(v) * size_t(width) + size_t(u)];
    value += keep * (values[size_t(y) * size_t(width) + size_t(x)] - value);
  };
  for (int round = 0; round < kAverages; ++round) {
    for (int y = 0; y < height; ++y) {
      for (int x = 1; x < width; ++x) carry(x - 1, y, x, y);
      for (int x = width - 1; x > 0; --x) carry(x, y, x - 1, y);
    }
    for (int x = 0; x < width; ++x) {
      for (int y = 1; y < height; ++y) carry(x, y - 1, x, y);
      for (int y = height - 1; y > 0; --y) carry(x, y, x, y - 1);
    }
  }
}

}  // namespace

DepthMap extended(std::span<const StereoPhoto> photos, std::span<const DepthMap> maps, std::span<const ScenePlane> planes,
                  size_t index) {
  DepthMap map = maps[index];
  if (std::find(map.trusted.begin(), map.trusted.end(), 1) == map.trusted.end()) return map;
  const StereoPhoto& photo = photos[index];
  const Intrinsics& k = photo.view.intrinsics;
  const size_t pixels = map.zdepth.size();
  const Nearest nearest = nearest_reliable(photo.luma, map);
  const Witnesses witnesses(photos, maps, index);

  // Candidates: large planes, far background, extrapolation.
  std::vector<InversePlane> choices, floors;
  std::vector<std::pair<Vec3d, double>> reach;  // [choice] large planes only: centre in the camera frame, radius
  for (const ScenePlane& plane : planes) {
    const Vec3d normal = photo.view.cam_from_world.rotation * plane.normal;
    const double offset = plane.offset + dot(normal, photo.view.cam_from_world.translation);
    if (!(std::abs(offset) > 1e-6)) continue;
    choices.push_back(inverse_plane(k, normal, offset));
    reach.emplace_back(photo.view.cam_from_world * plane.centre, plane.reach());
    if (plane.floor) floors.push_back(choices.back());
  }
  const size_t far = choices.size(), local = far + 1;
  const double far_z = std::max(photo.far_z, photo.background_z);
  choices.push_back({0, 0, 1 / far_z});
  const InversePlane end{0, 0, 1 / photo.far_z};  // end of the searched depth range: floors beyond it do not occlude the sky
  std::vector<std::optional<InversePlane>> fitted(pixels);
  std::vector<std::vector<float>> cost(choices.size() + 1, std::vector<float>(pixels, kImpossible));
  const auto above_floors = [&](const InversePlane& plane, double x, double y) {
    return std::ranges::none_of(floors,
                                [&](const InversePlane& floor) { return plane.at(x, y) < (1 - kSameDepth) * floor.at(x, y); });
  };
  const auto possible = [&](const InversePlane& plane, double x, double y) {
    const double w = plane.at(x, y);
    return above_floors(plane, x, y) && w * photo.near_z < 1 && w * photo.far_z > 0.999 &&
           -dot(normal_towards_camera(k, plane), normalized(k.ray(x, y))) > kMostSlanted;
  };
  const auto within_reach = [&](size_t c, double x, double y) {
    return length(k.ray(x, y) / choices[c].at(x, y) - reach[c].first) < reach[c].second;
  };
  const auto allowed = [&](size_t c, const InversePlane& plane, double x, double y) {
    if (c == far) return above_floors(end, x, y);
    return possible(plane, x, y) && (c == local || within_reach(c, x, y));
  };
  for (size_t i = 0; i < pixels; ++i) {
    const double x = double(int(i) % map.width) + 0.5, y = double(int(i) / map.width) + 0.5;
    if (map.reliable(i)) {
      for (size_t c = 0; c < choices.size(); ++c)
        cost[c][i] = std::abs(choices[c].at(x, y) * double(map.zdepth[i]) - 1) < kSameDepth ? 0 : kOtherSurface;
      cost[local][i] = 0;
      continue;
    }
    const ReferencePatch patch = reference_patch(photo.luma, int(x), int(y));
    for (size_t c = 0; c < choices.size(); ++c)
      if (allowed(c, choices[c], x, y)) cost[c][i] = witnesses.cost(patch, choices[c], x, y) + (c == far ? kFarHandicap : 0);
    const uint32_t from = nearest.source[i];
    if (!fitted[from]) fitted[from] = fitted_plane(k, map, int(from) % map.width, int(from) / map.width);
    const double stretched = fitted[from]->at(x, y) * double(map.zdepth[from]);
    if (stretched < kMostStretched && stretched > 1 / kMostStretched && possible(*fitted[from], x, y))
      cost[local][i] = witnesses.cost(patch, *fitted[from], x, y) + kLocalHandicap +
                       kUnseen * float(std::min(1.0, nearest.path[i] / kLongestBlind));
  }
  for (std::vector<float>& of : cost) average_alike(photo.luma, of);

  for (size_t i = 0; i < pixels; ++i) {
    if (map.reliable(i)) continue;
    const double x = double(int(i) % map.width) + 0.5, y = double(int(i) / map.width) + 0.5;
    const uint32_t from = nearest.source[i];
    InversePlane chosen = choices[far];
    float least = 1e30f;
    for (size_t c = 0; c < cost.size(); ++c) {
      const InversePlane& plane = c == local ? *fitted[from] : choices[c];
      if (!allowed(c, plane, x, y)) continue;
      if (cost[c][i] < least) least = cost[c][i], chosen = plane;
    }
    map.zdepth[i] = float(std::clamp(1 / chosen.at(x, y), photo.near_z, far_z));
    map.normal[i] = cast<float>(normal_towards_camera(k, chosen));
  }
  return map;
}

}  // namespace vitrine
