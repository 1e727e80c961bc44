// The painted things of the gallery: what is seen through the glass, in the mirrors and beside them.
#include <algorithm>
#include <cmath>

#include "sample_data/generate/revolve.h"
#include "sample_data/generate/scenes/gallery_paint.h"
#include "sample_data/generate/scenes/gallery_pieces.h"

namespace vitrine::generate {
namespace {

constexpr float kStand = 0.0005f;  // metres over what carries it
float matt_cell(float radius) { return std::clamp(0.075f * radius, 0.004f, 0.010f); }

Material painted(Draw& draw, float radius) {
  return {.albedo = solid_pattern(draw, drawn_palette(draw, 7), std::max(0.03f, radius * draw.between(0.45f, 0.8f)))};
}

Piece matt_ball(Draw& draw, float radius, float height) {
  Piece piece{.name = "ball"};
  const float r = std::min(radius, 0.5f * height);
  Profile wall;
  for (int i = 0; i <= 36; ++i) {
    const float a = kPi * (static_cast<float>(i) / 36.0f - 0.5f);
    wall.push_back({i % 36 ? r * std::cos(a) : 0.0f, kStand + r + r * std::sin(a)});
  }
  add_part(piece, "paint", revolved(wall, 72), painted(draw, r));
  return piece;
}

// One to three boxes on each other, each turned.
Piece matt_boxes(Draw& draw, float radius, float height) {
  Piece piece{.name = "boxes"};
  const int count = height > radius ? draw.whole(1, 3) : 1;
  float low = kStand, shrink = 1;
  for (int i = 0; i < count; ++i) {
    const float flat = draw.between(0.35f, 0.75f), w = 1.35f * radius * shrink,
                h = height / static_cast<float>(count) * draw.between(0.75f, 0.97f);
    const float turn = draw.between(0, kPi);
    Shape block = turned_box({0, 0, low + 0.5f * h}, {w, w * (flat + 0.2f), h}, turn, 2.0f * matt_cell(radius));
    add_part(piece, "paint", std::move(block),
             {.albedo = flat_pattern(draw, drawn_palette(draw, 7), std::max(0.025f, radius * draw.between(0.4f, 0.7f)))});
    low += h + kStand;
    shrink *= 0.85f;
  }
  return piece;
}

Piece matt_vase(Draw& draw, float radius, float height) {
  Piece piece{.name = "pot"};
  const std::vector<Vec2f> knots = drawn_vase_knots(draw, std::min(radius, 0.6f * height), height);
  add_part(piece, "paint", vessel(knots, 0.006f, 6, 72), painted(draw, radius));
  return piece;
}

Piece matt_statue(Draw& draw, float radius, float height) {
  Piece piece{.name = "figure"};
  const float r = std::min(radius, 0.6f * height);
  const Blobs blobs = drawn_blobs(draw, r / 1.15f, height / 1.1f);
  add_part(piece, "paint", meshed(blobs.distance, blobs.bounds, matt_cell(r)), painted(draw, r));
  return piece;
}

// A standing ring on a foot.
Piece matt_ring(Draw& draw, float radius, float height) {
  Piece piece{.name = "ring"};
  const float outer = std::min(radius, 0.5f * height), tube = outer * draw.between(0.22f, 0.34f), ring = outer - tube;
  const float lift = 0.9f * outer + 0.06f * outer;
  const DistanceFunction shape = [=](const Vec3f& p) {
    float d = torus_distance(p, {0, 0, lift}, {0, 1, 0}, ring, tube);
    d = smooth_union(d, ellipsoid_distance(p, {0, 0, 0.1f * outer}, {0.7f * outer, 1.3f * tube, 0.16f * outer}), 0.3f * tube);
    return -smooth_union(-d, p.z - kStand, 0.006f);
  };
  const double o = 1.05 * static_cast<double>(outer);
  add_part(piece, "paint", meshed(shape, {{-o, -o, -0.012}, {o, o, 2.1 * static_cast<double>(outer)}}, matt_cell(outer)),
           painted(draw, outer));
  return piece;
}

Piece matt_cone(Draw& draw, float radius, float height) {
  Piece piece{.name = "spire"};
  const float r = std::min(radius, 0.6f * height), tip = 0.12f * r;
  const std::vector<Vec2f> knots = {{r, kStand},
                                    {r * draw.between(0.7f, 0.95f), 0.25f * height},
                                    {r * draw.between(0.35f, 0.75f), 0.6f * height},
                                    {tip, 0.95f * height}};
  Profile wall{{0, kStand}};
  const Profile side = smooth_profile(knots, 10);
  wall.insert(wall.end(), side.begin(), side.end());
  wall.push_back({0, height});
  add_part(piece, "paint", revolved(wall, 72), painted(draw, r));
  return piece;
}

}  // namespace

Piece matt_thing(Draw& draw, float radius, float height) {
  using Build = Piece (*)(Draw&, float, float);
  static const std::vector<Build> builds = {matt_ball, matt_boxes, matt_vase, matt_statue, matt_ring, matt_cone};
  Piece piece = draw.pick(builds)(draw, radius, height);
  piece.matt_things = 1;
  return piece;
}

}  // namespace vitrine::generate
