#include "stages/optimize/flat_mirrors.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>

#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/scene/camera/projection.h"
#include "core/foundation/math/kd_tree.h"
#include "core/foundation/math/quantile.h"
#include "core/foundation/math/rigid.h"
#include "core/render/model/opened_scene.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {

namespace {

constexpr float kInMirror = 0.9f;        // minimum share of a virtual surfel's pixels in the specular masks
constexpr float kBesideMirror = 0.5f;    // below it, the surfel is in front of the mirror
constexpr float kSurfaceOpacity = 0.5f;  // opacity of surfels that represent a surface
constexpr size_t kMostPairs = 1500;      // surfels that are registered
constexpr float kReaches[] = {0.2f, 0.2f, 0.1f, 0.1f, 0.05f, 0.05f, 0.03f, 0.03f, 0.02f, 0.02f};  // pair distance per round
constexpr float kLikeColor = 0.3f;  // mean difference of diffuse colours of a pair
constexpr size_t kCandidates = 4;   // nearest surfels; the first with a similar colour is the pair
constexpr size_t kFewestPairs = 60;
constexpr double kAgreeing = 0.1;      // of the surfels must have a pair in the last round
constexpr double kFurthestTurn = 0.2;  // largest total rotation of a plane, radians
constexpr double kHalfWeight = 0.3;    // of the reach: the pair distance with weight 1/2
constexpr double kSteady = 1e-6;       // regularisation added to the normal equations

Vec3d place_of(const SplatLayer& layer, size_t i) {
  const float* m = layer.at(Attribute::Mean, i);
  return {m[0], m[1], m[2]};
}

Vec3d reflected(const Vec3d& p, const Facet& mirror) { return p - 2 * (dot(mirror.normal, p) - mirror.offset) * mirror.normal; }

// Mirrors the surfel's position and orientation.
void reflect(const Facet& mirror, SplatLayer& layer, size_t i) {
  const Vec3d place = reflected(place_of(layer, i), mirror);
  const Facet direction{mirror.normal, 0};
  float* q = layer.at(Attribute::Rotation, i);
  const Mat3d turned = rotation_matrix(normalized(Quatd{q[0], q[1], q[2], q[3]}));
  Mat3d rotation;
  rotation.column(0) = reflected(turned.column(0), direction), rotation.column(1) = reflected(turned.column(1), direction);
  rotation.column(2) = cross(rotation.column(0), rotation.column(1));
  const Quatd to = quaternion(rotation);
  const double numbers[] = {to.w, to.x, to.y, to.z};
  for (size_t c = 0; c < 4; ++c) q[c] = static_cast<float>(numbers[c]);
  for (size_t c = 0; c < 3; ++c) layer.at(Attribute::Mean, i)[c] = static_cast<float>(place[c]);
  std::fill_n(layer.at(Attribute::ShRest, i), layer.width(Attribute::ShRest), 0.f);
}

float color_difference(const SplatLayer& layer, size_t a, size_t b) {
  float sum = 0;
  for (size_t c = 0; c < 3; ++c) sum += std::abs(layer.at(Attribute::ShDc, a)[c] - layer.at(Attribute::ShDc, b)[c]);
  return kShDc * sum / 3;
}

// Rotates the plane about its centre by a small rotation, then moves it along the view direction, which keeps its image position.
Plane turned(const Plane& plane, const Vec3d& normal, double offset, const Vec3d& eye) {
  Plane out = plane;
  const Vec3d way = plane.centre - eye;
  const double along = (offset - dot(normal, eye)) / dot(normal, way);
  out.centre = eye + along * way;
  out.half = {along * plane.half.x, along * plane.half.y};
  const Vec3d side = normalized(plane.axes.c0 - dot(plane.axes.c0, normal) * normal);
  out.axes.column(0) = side, out.axes.column(1) = cross(normal, side), out.axes.column(2) = normal;
  return out;
}

// Real surfels that reflected virtual surfels may lie on.
struct Scenery {
  std::vector<uint32_t> surfels;
  std::vector<Vec3f> places;
  std::vector<Vec3d> normals;
};

}  // namespace

FlatMirrors::FlatMirrors(const LayerInitDesc& desc, const MaskEvidence& specular, const SplatLayer& diffuse)
    : desc_(desc), specular_(specular), diffuse_(diffuse) {
  if (!desc.config.shading.shapes) return;
  for (size_t e = 0; e < desc.shapes.entries.size(); ++e)
    if (desc.shapes.entries[e].role == ShapeRole::Mirror && std::holds_alternative<Plane>(desc.shapes.entries[e].shape))
      mirrors_.push_back({e, {}});
  if (mirrors_.empty()) return;
  std::vector<uint32_t> owner(diffuse.size(), UINT32_MAX);
  parallel_for(diffuse.size(), 64, [&](size_t i) {
    if (specular.share(i) < kInMirror) return;
    size_t most = 0;
    for (uint32_t m = 0; m < mirrors_.size(); ++m) {
      const ShapeSet::Entry& entry = desc.shapes.entries[mirrors_[m].entry];
      size_t through = 0;
      if (sees(std::get<Plane>(entry.shape), entry.tolerance, place_of(diffuse, i), through) && through > most)
        most = through, owner[i] = m;
    }
  });
  for (uint32_t i = 0; i < owner.size(); ++i)
    if (owner[i] != UINT32_MAX) mirrors_[owner[i]].behind.push_back(i);
}

// True if most photos that can see a place behind the plane see it through the rectangle; `through`: their number.
bool FlatMirrors::sees(const Plane& plane, double tolerance, const Vec3d& place, size_t& through) const {
  const Facet front = plane.facets().front();
  if (dot(front.normal, place) > front.offset - tolerance) return false;
  size_t past = 0;
  for (const uint32_t photo : desc_.capture.train) {
    const View& view = desc_.capture.photos[photo].levels[0].view;
    if (!image_point(place, view, 1e-6)) continue;
    const Vec3d eye = view.centre_in_world();
    const auto hit = plane.intersect({eye, place - eye});
    ++(hit && hit->t < 1 ? through : past);
  }
  return through > past;
}

Plane FlatMirrors::registered(const Mirror& mirror) const {
  const Plane& start = std::get<Plane>(desc_.shapes.entries[mirror.entry].shape);
  Facet plane = start.facets().front();
  Scenery scenery;
  for (uint32_t i = 0; i < diffuse_.size(); ++i) {
    if (specular_.share(i) > kBesideMirror || is_glass(diffuse_, i) ||
        sigmoid(*diffuse_.at(Attribute::Opacity, i)) < kSurfaceOpacity)
      continue;
    const Vec3d place = place_of(diffuse_, i);
    if (dot(plane.normal, place) < plane.offset) continue;
    const float* q = diffuse_.at(Attribute::Rotation, i);
    scenery.surfels.push_back(i);
    scenery.places.push_back(cast<float>(place));
    scenery.normals.push_back(rotation_matrix(normalized(Quatd{q[0], q[1], q[2], q[3]})).column(2));
  }
  std::vector<uint32_t> sample;
  for (const uint32_t i : mirror.behind)
    if (sigmoid(*diffuse_.at(Attribute::Opacity, i)) > kSurfaceOpacity) sample.push_back(i);
  if (const size_t all = sample.size(); all > kMostPairs) {
    for (size_t k = 0; k < kMostPairs; ++k) sample[k] = sample[k * all / kMostPairs];
    sample.resize(kMostPairs);
  }
  Vec3d eye{};
  for (const uint32_t photo : desc_.capture.train)
    eye += desc_.capture.photos[photo].levels[0].view.centre_in_world() / double(desc_.capture.train.size());
  const KdTreef tree(scenery.places);

  struct Pair {
    bool found = false;
    Vec3d place, normal;  // behind the mirror; normal of the real surface
    double away = 0;      // signed distance of the reflected position along the normal
  };
  std::vector<Pair> pairs(sample.size());
  size_t agreeing = 0;
  double off = 0;  // median
  for (const float reach : kReaches) {
    parallel_for(sample.size(), 32, [&](size_t k) {
      thread_local std::vector<KdTreef::Near> near;
      const Vec3d behind = place_of(diffuse_, sample[k]), before = reflected(behind, plane);
      pairs[k] = {};
      tree.nearest(cast<float>(before), kCandidates, reach, near);
      for (const KdTreef::Near& n : near) {
        if (color_difference(diffuse_, sample[k], scenery.surfels[n.index]) > kLikeColor) continue;
        const Vec3d& normal = scenery.normals[n.index];
        pairs[k] = {true, behind, normal, dot(normal, before - cast<double>(scenery.places[n.index]))};
        break;
      }
    });
    Eigen::Matrix3d a = kSteady * Eigen::Matrix3d::Identity();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    const Vec3d u = normalized(start.axes.c0 - dot(start.axes.c0, plane.normal) * plane.normal), v = cross(plane.normal, u);
    std::vector<double> residuals;
    for (const Pair& p : pairs) {
      if (!p.found) continue;
      residuals.push_back(std::abs(p.away));
      // q(n, d) = p - 2 (n p - d) n. Its component along the surface normal m has the derivatives -2 ((m n) p + (n p - d) m) by n
      // and 2 (m n) by d.
      const double facing = dot(p.normal, plane.normal), depth = dot(plane.normal, p.place) - plane.offset;
      const Vec3d to_normal = -2. * (facing * p.place + depth * p.normal);
      const Eigen::Vector3d row(dot(to_normal, u), dot(to_normal, v), 2 * facing);
      const double outlying = p.away / (kHalfWeight * double(reach)), w = 1 / (1 + outlying * outlying);
      a += w * row * row.transpose();
      b -= w * p.away * row;
    }
    if (residuals.size() < kFewestPairs) return start;
    agreeing = residuals.size(), off = quantile_of(residuals, 0.5);
    const Eigen::Vector3d step = a.ldlt().solve(b);
    plane.normal = normalized(plane.normal + step[0] * u + step[1] * v);
    plane.offset += step[2];
  }
  const double turn = std::acos(std::clamp(dot(plane.normal, start.axes.c2), -1.0, 1.0));
  const bool agrees = double(agreeing) >= kAgreeing * double(sample.size()) && turn < kFurthestTurn;
  log_info(
      "a flat mirror: {} of {} surfels behind it lie on what stands before it, {:.4f} off (median); it turns by {:.2f} degrees{}",
      agreeing, sample.size(), off, turn * 180 / std::numbers::pi, agrees ? "" : ": not taken");
  return agrees ? turned(start, plane.normal, plane.offset, eye) : start;
}

ShapeSet FlatMirrors::registered() const {
  ShapeSet out = desc_.shapes;
  for (const Mirror& m : mirrors_) out.entries[m.entry].shape = registered(m);
  return out;
}

std::vector<uint8_t> FlatMirrors::reflect_into_scene(const ShapeSet& shapes, SplatLayer& diffuse) const {
  std::vector<uint8_t> moved(diffuse.size(), 0);
  for (const Mirror& m : mirrors_) {
    const Facet front = std::get<Plane>(shapes.entries[m.entry].shape).facets().front();
    for (const uint32_t i : m.behind) reflect(front, diffuse, i), moved[i] = 1;
  }
  return moved;
}

}  // namespace vitrine
