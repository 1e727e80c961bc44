// The pieces of filled_gallery: closed vessels of glass with a medium in them, and painted things. Liquid and jelly are solid
// glass of their own index of refraction; fog and smoke stand behind a wall without thickness.
#include <algorithm>
#include <cmath>

#include "sample_data/generate/content.h"
#include "sample_data/generate/scenes/gallery_layout.h"

namespace vitrine::generate {
namespace {

constexpr uint64_t kFilledPurpose = 10;

// A bottle with a round closed top.
Piece flask(Draw& draw) {
  Piece piece;
  const float r = draw.between(0.085f, 0.11f), high = draw.between(0.26f, 0.34f), neck = r * draw.between(0.35f, 0.55f);
  const std::vector<Vec2f> knots = {{0.88f * r, 0.002f},
                                    {r, 0.02f},
                                    {r * draw.between(0.92f, 1.05f), 0.3f * high},
                                    {r * draw.between(0.85f, 1.0f), 0.55f * high},
                                    {neck, 0.78f * high},
                                    {neck, 0.95f * high}};
  Profile wall{{0, 0.0005f}, {0.55f * r, 0.0005f}};
  const Profile side = smooth_profile(knots, 10);
  wall.insert(wall.end(), side.begin(), side.end());
  close_above(wall, neck, 0.95f * high, 0.05f * high, 10);
  add_part(piece, "glass", revolved(wall, 96), {.kind = MaterialKind::ThinGlass});
  return piece;
}

struct Room {  // the inside of a vessel
  Vec3f low, high;
  float radius() const { return 0.5f * std::min(high.x - low.x, high.y - low.y); }
  Vec3f at(float x, float y, float up) const {  // x and y in radii from the middle, up in heights
    const Vec3f middle = 0.5f * (low + high);
    return {middle.x + radius() * x, middle.y + radius() * y, std::lerp(low.z, high.z, up)};
  }
};

Vec3f drawn_glow(Draw& draw) {
  const float level = draw.between(0.15f, 0.55f);
  return level * Vec3f{draw.between(0.2f, 1), draw.between(0.2f, 1), draw.between(0.2f, 1)};
}

// One density, so that a ray through the middle has an optical depth of 0.8 to 2.6.
GlassContent drawn_liquid(Draw& draw, const Room& room) {
  const float depth = draw.between(0.8f, 2.6f);
  return {depth / (2 * room.radius()), drawn_glow(draw), {}};
}

// Gaussians along a spiral from foot to top, thinner and wider or the other way round upwards, in a thin fog.
GlassContent drawn_smoke(Draw& draw, const Room& room) {
  const int count = draw.whole(12, 24);
  const float height = room.high.z - room.low.z, turns = draw.between(0, 2), start = draw.between(0, 2 * kPi);
  const float swing = draw.between(0.1f, 0.55f), spread = draw.between(-0.8f, 0.8f), depth = draw.between(0.9f, 2.6f);
  const float across = room.radius() * draw.between(0.16f, 0.32f);
  const Vec3f below = drawn_glow(draw), above = drawn_glow(draw);
  std::vector<GlassContent::Cloud> clouds;
  for (int i = 0; i < count; ++i) {
    const float up = (static_cast<float>(i) + 0.5f) / static_cast<float>(count), phi = start + 2 * kPi * turns * up;
    const float width = across * std::exp(spread * (up - 0.5f));
    Gaussian3f g;
    g.mean = room.at(swing * std::cos(phi) + draw.between(-0.15f, 0.15f), swing * std::sin(phi) + draw.between(-0.15f, 0.15f),
                     std::lerp(0.08f, 0.92f, up));
    for (size_t axis = 0; axis < 3; ++axis) g.log_scale[axis] = std::log(width) + draw.between(-0.35f, 0.35f);
    g.rotation = {draw.between(-1, 1), draw.between(-1, 1), draw.between(-1, 1), 1.1f};
    // All together have about this optical depth on a level ray through the axis.
    g.log_density = std::log(depth * height / (static_cast<float>(count) * 2 * kPi * width * width)) + draw.between(-0.5f, 0.5f);
    clouds.push_back({g, mixed(below, above, up)});
  }
  return {draw.between(0, 0.15f) / room.radius(), mixed(below, above, 0.5f), std::move(clouds)};
}

Piece filled_vessel(Draw& draw, Piece (*build)(Draw&), bool smoke) {
  Piece piece = build(draw);
  const bool liquid = !smoke && draw.chance(0.65f), holds = draw.chance(0.5f);
  if (!holds && piece.matt_things > 0) {
    std::erase_if(piece.parts, [](const Part& part) { return part.name == "paint"; });
    piece.matt_things = 0;
  }
  const auto glass = std::ranges::find(piece.parts, std::string("glass"), &Part::name);
  Bounds3 bounds;
  for (const Vec3f& p : glass->shape.mesh.positions) bounds.extend(cast<double>(p));
  const Room room{cast<float>(bounds.low), cast<float>(bounds.high)};
  glass->material.kind = liquid ? MaterialKind::SolidGlass : MaterialKind::ThinGlass;
  glass->material.index_of_refraction = liquid ? draw.between(1.33f, 1.38f) : 1.5f;
  glass->material.content = std::make_shared<const GlassContent>(smoke ? drawn_smoke(draw, room) : drawn_liquid(draw, room));
  const float height = room.high.z - room.low.z;
  if (holds && piece.matt_things == 0)
    add_content(piece, matt_thing(draw, 0.5f * room.radius(), 0.45f * height), room.low.z + 0.2f * height);
  return piece;
}

}  // namespace

GalleryPlan filled_plan(uint64_t seed) {
  Draw draw(seed, kFilledPurpose);
  std::vector<Piece (*)(Draw&)> kinds{box_case, dome, glass_ball, flat_paperweight, flask};
  draw.shuffle(std::span(kinds));
  kinds.resize(static_cast<size_t>(draw.whole(1, 2)));
  std::vector<Piece> pieces;
  for (const auto build : kinds) {
    pieces.push_back(filled_vessel(draw, build, seed % 2 == 0));
    pieces.back().name = "vessel";
    pieces.back().group = PieceGroup::Glass;
  }
  for (int matt = draw.whole(2, 4); matt > 0; --matt)
    pieces.push_back(matt_thing(draw, draw.between(0.06f, 0.10f), draw.between(0.13f, 0.30f)));
  return placed_pieces(std::move(pieces), seed);
}

}  // namespace vitrine::generate
