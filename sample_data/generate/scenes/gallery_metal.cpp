// The metal of the gallery: each piece has a colour and a roughness of its own.
#include <algorithm>
#include <cmath>

#include "sample_data/generate/revolve.h"
#include "sample_data/generate/scenes/gallery_paint.h"
#include "sample_data/generate/scenes/gallery_pieces.h"

namespace vitrine::generate {
namespace {

constexpr float kMetalCell = 0.005f;  // of meshed metal, metres

Material drawn_metal(Draw& draw, float most_roughness = 0.35f) {
  const Vec3f colour = drawn_metal_colour(draw);
  const float u = draw.between(0, 1);
  return {.kind = MaterialKind::Metal, .reflectance = colour, .roughness = std::lerp(0.02f, most_roughness, u * u)};
}

}  // namespace

Piece polished_sphere(Draw& draw) {
  Piece piece;
  const float r = draw.between(0.085f, 0.125f);
  Profile wall;
  for (int i = 0; i <= 64; ++i) {
    const float a = kPi * (static_cast<float>(i) / 64.0f - 0.5f);
    wall.push_back({i % 64 ? r * std::cos(a) : 0.0f, 0.0005f + r + r * std::sin(a)});
  }
  add_part(piece, "metal", revolved(wall, 128), drawn_metal(draw, 0.15f));
  return piece;
}

// A serving spoon; lying on the table, or leaning with its handle on a block.
Piece spoon(Draw& draw) {
  const float bowl_x = draw.between(0.11f, 0.13f), bowl_y = bowl_x * draw.between(0.66f, 0.80f),
              deep = draw.between(0.035f, 0.05f);
  const float handle = draw.between(0.22f, 0.28f), thick = draw.between(0.012f, 0.016f);
  const bool leaning = draw.chance(0.6f);
  const float slope = leaning ? draw.between(0.6f, 0.95f) : draw.between(0.03f, 0.06f);
  // Own frame: the rim of the bowl at z = 0, the handle along +x.
  const DistanceFunction own = [=](const Vec3f& p) {
    const float outer = ellipsoid_distance(p, {0, 0, 0}, {bowl_x, bowl_y, deep});
    const float inner = ellipsoid_distance(p, {0, 0, 0.006f}, {bowl_x - 0.004f, bowl_y - 0.004f, deep - 0.002f});
    const float shell = std::max({outer, -inner, p.z - 0.002f});
    const float x = bowl_x + handle;
    float grip = capsule_distance(p, {bowl_x - 0.006f, 0, -0.002f}, {0.5f * (bowl_x + x), 0, 0.018f}, thick, 0.75f * thick);
    grip = smooth_union(grip, capsule_distance(p, {0.5f * (bowl_x + x), 0, 0.018f}, {x, 0, 0.006f}, 0.75f * thick, 1.5f * thick),
                        0.01f);
    return smooth_union(shell, grip, 0.006f);
  };
  const Shape shape = meshed(own,
                             {{-static_cast<double>(bowl_x) - 0.02, -static_cast<double>(bowl_y) - 0.02, -0.06},
                              {static_cast<double>(bowl_x + handle) + 0.03, static_cast<double>(bowl_y) + 0.02, 0.045}},
                             0.0028f);
  // Tipped up by the slope about the y axis, then set down on its lowest point.
  Piece piece;
  add_part(piece, "metal", shape, drawn_metal(draw, 0.2f));
  const float c = std::cos(slope), s = std::sin(slope);
  const auto tipped = [c, s](const Vec3f& v) { return Vec3f{c * v.x - s * v.z, v.y, s * v.x + c * v.z}; };
  float lowest = 1e9f;
  TriMesh& mesh = piece.parts[0].shape.mesh;
  for (Vec3f& p : mesh.positions) {
    p = tipped(p);
    lowest = std::min(lowest, p.z);
  }
  for (Vec3f& n : mesh.normals) n = tipped(n);
  shift(piece, {0, 0, 0.0005f - lowest});
  if (!leaning) return piece;
  // The block ends just under the handle.
  const float at = bowl_x + draw.between(0.6f, 0.75f) * handle;
  const Vec3f edge = tipped({at, 0, 0.010f - 1.6f * thick});
  const float top = edge.z - lowest, wide = draw.between(0.03f, 0.045f);
  add_part(piece, "block", box({edge.x, -wide, 0}, {edge.x + 2 * wide, wide, top}, 0.012f),
           {.albedo = flat_pattern(draw, drawn_palette(draw, 6), 0.04f)});
  piece.matt_things = 1;
  return piece;
}

Piece statue(Draw& draw) {
  Piece piece;
  const Blobs blobs = drawn_blobs(draw, draw.between(0.085f, 0.115f), draw.between(0.27f, 0.36f));
  add_part(piece, "metal", meshed(blobs.distance, blobs.bounds, kMetalCell), drawn_metal(draw));
  return piece;
}

Piece metal_vase(Draw& draw) {
  Piece piece;
  const std::vector<Vec2f> knots = drawn_vase_knots(draw, draw.between(0.08f, 0.11f), draw.between(0.26f, 0.36f));
  add_part(piece, "metal", vessel(knots, 0.005f, 10, 128), drawn_metal(draw));
  return piece;
}

// A body with a lid and a bow over it; with a spout, or a pot with a handle at its side.
Piece metal_kettle(Draw& draw) {
  Piece piece;
  const float r = draw.between(0.105f, 0.13f), high = r * draw.between(1.3f, 1.6f), bend = 0.03f;
  const bool spout = draw.chance(0.6f);
  const DistanceFunction body = [=](const Vec3f& p) {
    float d = ellipsoid_distance(p, {0, 0, 0.46f * high}, {r, r, 0.54f * high});
    d = smooth_union(d, ellipsoid_distance(p, {0, 0, 0.97f * high}, {0.5f * r, 0.5f * r, 0.09f * high}), 0.012f);
    d = smooth_union(d, length(p - Vec3f{0, 0, 1.12f * high}) - 0.13f * r, 0.012f);
    if (spout) {
      d = smooth_union(d, capsule_distance(p, {0.75f * r, 0, 0.4f * high}, {1.3f * r, 0, 0.7f * high}, 0.25f * r, 0.15f * r),
                       bend);
      d = smooth_union(d, capsule_distance(p, {1.3f * r, 0, 0.7f * high}, {1.5f * r, 0, 1.0f * high}, 0.15f * r, 0.11f * r),
                       0.015f);
    } else {
      d = smooth_union(d, torus_distance(p, {-1.0f * r, 0, 0.5f * high}, {0, 1, 0}, 0.38f * r, 0.085f * r), 0.012f);
    }
    return -smooth_union(-d, p.z - 0.002f, 0.012f);
  };
  const double b = 1.7 * static_cast<double>(r);
  add_part(piece, "metal", meshed(body, {{-b, -b, -0.012}, {b, b, 1.35 * static_cast<double>(high)}}, kMetalCell),
           drawn_metal(draw));
  if (spout) {
    const DistanceFunction bow = [=](const Vec3f& p) {
      return std::max(torus_distance(p, {0, 0, 0.85f * high}, {0, 1, 0}, 0.8f * r, 0.085f * r), 0.80f * high - p.z);
    };
    add_part(piece, "handle",
             meshed(bow, {{-b, -0.03, 0.7 * static_cast<double>(high)}, {b, 0.03, 2.0 * static_cast<double>(high)}}, 0.004f),
             {.albedo = wooden(draw, 0)});
  }
  return piece;
}

Piece wall_mirror(Draw& draw) {
  Piece piece{.hangs = true};
  const float width = draw.between(0.5f, 0.75f), height = draw.between(0.34f, 0.46f), low = draw.between(0.11f, 0.15f);
  const float x = 0.5f * width, bar = draw.between(0.015f, 0.03f);
  const float silver = draw.between(0.85f, 0.95f);
  add_part(piece, "metal", rectangle({-x, -0.008f, low}, {width, 0, 0}, {0, 0, height}, 0.2f),
           {.kind = MaterialKind::Mirror, .reflectance = silver * Vec3f{1, 0.995f, 0.985f}});
  Shape frame = box({-x - bar, -0.02f, low - bar}, {x + bar, 0, low}, 0.04f);
  append(frame, box({-x - bar, -0.02f, low + height}, {x + bar, 0, low + height + bar}, 0.04f));
  append(frame, box({-x - bar, -0.02f, low}, {-x, 0, low + height}, 0.04f));
  append(frame, box({x, -0.02f, low}, {x + bar, 0, low + height}, 0.04f));
  add_part(piece, "frame", frame, {.albedo = wooden(draw, 0)});
  return piece;
}

}  // namespace vitrine::generate
