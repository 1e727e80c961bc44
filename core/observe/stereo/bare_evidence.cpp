#include "core/observe/stereo/bare_evidence.h"

#include <algorithm>
#include <cmath>

#include "core/scene/camera/projection.h"
#include "core/scene/image/resample.h"
#include "core/foundation/math/connected_components.h"

namespace vitrine {

namespace {

constexpr size_t kMostSampled = 48;                     // photos, evenly spaced: more add no information about a wall
constexpr size_t kOthers = 12;                          // photos to which a sample is compared
constexpr int kTile = 32;                               // pixels: maximum region size
constexpr float kRegionEdge = 0.02f;                    // brightness step between regions
constexpr float kMostDifference = 0.1f;                 // clamp of the brightness difference
constexpr float kNobodySees = 0.06f, kInTheWay = 0.6f;  // unseen, occluding: as for unreliable pixels (extend_planes.cpp)
constexpr double kInFront = 0.06;                       // relative depth
constexpr double kGrazing = 0.1;                        // cosine between ray and normal

// Mean over 3x3 pixels.
ImageF blurred(const ImageF& luma) {
  ImageF out(luma.width(), luma.height(), 1);
  for (int y = 0; y < luma.height(); ++y)
    for (int x = 0; x < luma.width(); ++x) {
      float sum = 0;
      for (int v = y - 1; v <= y + 1; ++v)
        for (int u = x - 1; u <= x + 1; ++u)
          sum += luma.at(std::clamp(u, 0, luma.width() - 1), std::clamp(v, 0, luma.height() - 1));
      out.at(x, y) = sum / 9;
    }
  return out;
}

}  // namespace

BareEvidence::BareEvidence(std::span<const StereoPhoto> photos, std::span<const DepthMap> maps, int step)
    : photos_(photos), maps_(maps), centres_(photos.size()), blurred_(photos.size()) {
  for (uint32_t v = 0; v < photos.size(); ++v) {
    if (maps[v].zdepth.empty()) continue;
    centres_[v] = photos[v].view.centre_in_world();
    blurred_[v] = blurred(photos[v].luma);
    used_.push_back(v);
  }
  const size_t stride = (used_.size() + kMostSampled - 1) / kMostSampled;
  for (size_t i = 0; i < used_.size(); i += stride) add_samples(used_[i], step);
}

// Connected regions of unreliable pixels without an edge, within a tile. [h*w]
std::vector<uint32_t> BareEvidence::regions_of(uint32_t photo) {
  const DepthMap& map = maps_[photo];
  const ImageF& luma = blurred_[photo];
  const auto unreliable = [&](size_t i) { return !map.reliable(i); };
  const auto for_neighbours = [&](size_t i, const auto& visit) {
    const int x = int(i) % map.width, y = int(i) / map.width;
    for (const auto& [u, v] : {std::pair{x + 1, y}, {x - 1, y}, {x, y + 1}, {x, y - 1}}) {
      if (u < 0 || v < 0 || u >= map.width || v >= map.height || u / kTile != x / kTile || v / kTile != y / kTile) continue;
      if (std::abs(luma.at(u, v) - luma.at(x, y)) <= kRegionEdge) visit(map.index(u, v));
    }
  };
  ConnectedComponents regions = connected_components(map.zdepth.size(), unreliable, for_neighbours);
  for (uint32_t& label : regions.label)
    if (label != ConnectedComponents::kNone) label += regions_;
  regions_ += uint32_t(regions.members.size());
  return std::move(regions.label);
}

void BareEvidence::add_samples(uint32_t photo, int step) {
  const std::vector<uint32_t> region = regions_of(photo);
  const DepthMap& map = maps_[photo];
  const View& view = photos_[photo].view;
  for (int y = step / 2; y < map.height; y += step)
    for (int x = step / 2; x < map.width; x += step)
      if (const size_t i = map.index(x, y); !map.reliable(i))
        samples_.push_back({photo, region[i], blurred_[photo].at(x, y), view.ray(x + 0.5, y + 0.5)});
}

std::vector<float> BareEvidence::by_region(const std::vector<float>& values) const {
  std::vector<float> mean(regions_), count(regions_);
  for (size_t i = 0; i < samples_.size(); ++i) mean[samples_[i].region] += values[i], count[samples_[i].region] += 1;
  for (size_t r = 0; r < regions_; ++r) mean[r] /= std::max(count[r], 1.f);
  return mean;
}

// Cost of a sample at `point`, or at infinity in the direction of `point`.
float BareEvidence::cost_at(const Sample& s, const Vec3d& point, bool far) const {
  double difference = 0, seen = 0, in_the_way = 0;
  const size_t stride = std::max<size_t>(1, used_.size() / kOthers);
  for (size_t o = s.photo % stride; o < used_.size(); o += stride) {
    const uint32_t v = used_[o];
    if (v == s.photo) continue;
    const View& view = photos_[v].view;
    const Vec3d p = far ? view.cam_from_world.rotation * point : view.cam_from_world * point;
    const auto at = image_point(p, view.intrinsics, 0, 1);
    if (!at) continue;
    const DepthMap& map = maps_[v];
    if (const size_t i = map.index(int(at->x), int(at->y)); map.reliable(i)) {
      if (far || p.z > (1 + kInFront) * double(map.zdepth[i])) continue;  // occluded there
      if (p.z < (1 - kInFront) * double(map.zdepth[i])) {
        in_the_way += 1;
        continue;
      }
    }
    float value = 0;
    sample_bilinear(blurred_[v], at->x, at->y, &value);
    difference += double(std::min(std::abs(value - s.value), kMostDifference));
    seen += 1;
  }
  return (seen > 0 ? float(difference / seen) : kNobodySees) + kInTheWay * float(in_the_way / (in_the_way + seen + 0.5));
}

// z-depth of the plane; negative where the sample's ray misses it or grazes it.
double BareEvidence::depth(const ScenePlane& plane, const Sample& s) const {
  const double facing = dot(plane.normal, s.along), z = (plane.offset - dot(plane.normal, centres_[s.photo])) / facing;
  return z > photos_[s.photo].near_z && std::abs(facing) > kGrazing * length(s.along) ? z : -1;
}

float BareEvidence::cost(const ScenePlane& plane, const Sample& s) const {
  const double z = depth(plane, s);
  const Vec3d point = centres_[s.photo] + z * s.along;
  if (z < 0 || (plane.extent > 0 && length(point - plane.centre) > plane.reach())) return kInTheWay;
  return cost_at(s, point, false);
}

std::vector<float> BareEvidence::costs(const ScenePlane& plane) const {
  std::vector<float> values(samples_.size());
  for (size_t i = 0; i < values.size(); ++i) values[i] = cost(plane, samples_[i]);
  return by_region(values);
}

std::vector<float> BareEvidence::far_costs() const {
  std::vector<float> values(samples_.size());
  for (size_t i = 0; i < values.size(); ++i) values[i] = cost_at(samples_[i], samples_[i].along, true);
  return by_region(values);
}

double BareEvidence::gain(const ScenePlane& plane, std::span<const float> least) const {
  const std::vector<float> own = costs(plane);
  double sum = 0;
  for (const Sample& s : samples_) sum += std::max(0.0, double(least[s.region] - own[s.region]));
  return sum;
}

double BareEvidence::refuted(std::span<const ScenePlane> others, const ScenePlane& plane, std::span<const float> least) const {
  const std::vector<float> own = costs(plane);
  std::vector<double> sums(others.size());
  for (const Sample& s : samples_) {
    if (!(own[s.region] < least[s.region])) continue;
    const float ours = cost(plane, s);
    for (size_t o = 0; o < others.size() && ours != kNobodySees; ++o)
      if (const float theirs = cost(others[o], s); theirs != kNobodySees)
        sums[o] += double(std::min(theirs, kNobodySees) - std::min(ours, kNobodySees));
  }
  return *std::ranges::min_element(sums);
}

void BareEvidence::measure(ScenePlane& plane, std::span<const float> least) const {
  const std::vector<float> own = costs(plane);
  std::vector<Vec3d> points;
  Vec3d sum{};
  for (const Sample& s : samples_) {
    const double z = depth(plane, s);
    if (z < 0 || !(own[s.region] < least[s.region])) continue;
    points.push_back(centres_[s.photo] + z * s.along);
    sum += points.back();
  }
  if (points.empty()) return;
  plane.centre = sum / double(points.size());
  double squares = 0;
  for (const Vec3d& p : points) squares += dot(p - plane.centre, p - plane.centre);
  plane.extent = std::sqrt(squares / double(points.size()));
  plane.share = double(points.size()) / double(samples_.size());
}

}  // namespace vitrine
