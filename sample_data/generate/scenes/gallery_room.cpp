#include "sample_data/generate/scenes/gallery_room.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "sample_data/generate/scenes/gallery_paint.h"

namespace vitrine::generate {
namespace {

constexpr uint64_t kRoomPurpose = 6, kLightPurpose = 7, kPlainPurpose = 8;
constexpr float kGround = -0.72f, kTop = 1.6f;  // floor and upper edge of the walls; the table top is z = 0
constexpr float kBroadCell = 0.12f, kNearCell = 0.05f, kTableCell = 0.014f;

void add_room_part(Scene& scene, std::string name, Shape shape, Texture albedo, bool measured = false) {
  scene.parts.push_back(
      {.name = std::move(name), .shape = std::move(shape), .material = {.albedo = std::move(albedo)}, .measured = measured});
}

Palette toned(Palette palette, const Vec3f& tone, float share) {
  for (Vec3f& colour : palette) colour = mixed(colour, tone, share);
  return palette;
}

// A solid texture as a painting of a flat part: an upright or level sheet through the origin.
Painting sheet_of(Texture solid, bool upright) {
  return [solid = std::move(solid), upright](float x, float y) {
    return solid({upright ? Vec3f{x, 0.3f * x, y} : Vec3f{x, y, 0}, {0, 0, 1}, {}});
  };
}

Texture floor_texture(Draw& draw, float width, float depth) {
  const Vec3f light = draw.pick(Palette{from_srgb8(198, 150, 100), from_srgb8(150, 120, 96), from_srgb8(120, 82, 60)});
  const Painting painting =
      draw.chance(0.6f) ? planks(draw.between(0.11f, 0.18f), light, 0.4f * light, draw.texture_seed())
                        : glyph_tiles(draw.between(0.2f, 0.32f), toned(drawn_palette(draw, 7), light, 0.4f), draw.texture_seed());
  return baked(painting, width, depth, 0.010f);
}

Texture table_texture(Draw& draw, float width, float depth) {
  const uint32_t seed = draw.texture_seed();
  const Palette palette = drawn_palette(draw, 8);
  switch (draw.whole(0, 2)) {
    case 0:
      return baked(glyph_tiles(draw.between(0.07f, 0.12f), palette, seed), width, depth, 0.0025f);
    case 1:
      return baked(planks(draw.between(0.06f, 0.1f), from_srgb8(186, 140, 92), from_srgb8(84, 52, 34), seed), width, depth,
                   0.0025f);
    default:
      return baked(sheet_of(marbled(toned(palette, {0.45f, 0.42f, 0.38f}, 0.35f), draw.between(0.10f, 0.16f), seed), false),
                   width, depth, 0.0025f);
  }
}

Texture wall_texture(Draw& draw, float width, float height) {
  const Palette palette = drawn_palette(draw, 8);
  const Vec3f base = mixed(palette[1], {0.55f, 0.52f, 0.46f}, 0.5f), stain = mixed(palette[2], base, 0.35f);
  if (draw.chance(0.65f)) return baked(sheet_of(plaster(base, stain, draw.texture_seed()), true), width, height, 0.010f);
  return baked(glyph_tiles(draw.between(0.18f, 0.3f), toned(palette, base, 0.5f), draw.texture_seed()), width, height, 0.010f);
}

Texture one_colour(const Vec3f& colour) {
  return [colour](const SurfacePoint&) { return colour; };
}

struct RoomWall {
  const char* name;
  Vec3f corner, along;  // the corner on the floor, unit direction
  float length;
};

// Pictures side by side, away from the stretch [keep_low, keep_high] of the wall.
void add_pictures(Scene& scene, const RoomWall& wall, Draw& draw, float keep_low, float keep_high) {
  const int slots = draw.whole(3, 4);
  const float slot = wall.length / static_cast<float>(slots);
  const Vec3f inwards = cross(wall.along, Vec3f{0, 0, 1});
  for (int i = 0; i < slots; ++i) {
    constexpr float kBar = 0.04f, kDepth = 0.03f;
    const float width = slot * draw.between(0.45f, 0.8f), height = draw.between(0.6f, 1.15f), low = draw.between(-0.25f, 0.2f);
    const float along = slot * static_cast<float>(i) + 0.5f * (slot - width);
    const uint32_t seed = draw.texture_seed();
    const Texture wood = wooden(draw, 2);
    if (along - kBar < keep_high && along + width + kBar > keep_low) continue;
    const Vec3f corner = wall.corner + along * wall.along + Vec3f{0, 0, low - kGround};
    Bounds3 frame;
    frame.extend(cast<double>(corner - kBar * wall.along - Vec3f{0, 0, kBar}));
    frame.extend(cast<double>(corner + (width + kBar) * wall.along + Vec3f{0, 0, height + kBar} + kDepth * inwards));
    add_room_part(scene, fmt::format("frame_{}{}", wall.name, i), box(cast<float>(frame.low), cast<float>(frame.high), 0.3f),
                  wood);
    add_room_part(scene, fmt::format("picture_{}{}", wall.name, i),
                  rectangle(corner + (kDepth + 0.002f) * inwards, width * wall.along, {0, 0, height}, 0.2f),
                  baked(abstract_picture(width, height, seed), width, height, 0.006f));
  }
}

void add_gallery_table(Scene& scene, const GalleryPlan& plan, Draw& draw) {
  const float half = plan.extent + draw.between(0.05f, 0.12f), back = plan.wall_y ? *plan.wall_y - 0.002f : half;
  const float thick = 0.035f, leg = 0.06f;
  add_room_part(scene, "table_top", rectangle({-half, -half, 0}, {2 * half, 0, 0}, {0, half + back, 0}, kTableCell),
                table_texture(draw, 2 * half, half + back), true);
  const Texture wood = wooden(draw, 0), leg_wood = wooden(draw, 2);
  add_room_part(scene, "table_board", box({-half, -half, -thick}, {half, back, -0.0005f}, 0.05f), wood, true);
  for (const float x : {-half + 0.03f, half - 0.03f - leg})
    for (const float y : {-half + 0.03f, back - 0.03f - leg})
      add_room_part(scene, fmt::format("leg_{}{}", x > 0, y > 0), box({x, y, kGround}, {x + leg, y + leg, -thick}, 0.12f),
                    leg_wood);
}

// A sky turned about the vertical.
std::function<Vec3f(const Vec3f&)> turned_sky(Vec3f (*sky)(const Vec3f&), float turn) {
  const float c = std::cos(turn), s = std::sin(turn);
  return [=](const Vec3f& d) { return sky({c * d.x + s * d.y, c * d.y - s * d.x, d.z}); };
}

}  // namespace

void add_gallery_room(Scene& scene, const GalleryPlan& plan, uint64_t seed, RoomPaint paint) {
  Draw draw(seed, kRoomPurpose), plain(seed, kPlainPurpose);
  const auto painted = [&](Texture pattern) {
    if (paint == RoomPaint::Patterned) return pattern;
    return one_colour(mixed(drawn_palette(plain, 2)[1], {0.62f, 0.60f, 0.56f}, 0.6f));
  };
  const float x = draw.between(1.8f, 2.3f), south = -draw.between(1.8f, 2.3f),
              north = plan.wall_y.value_or(draw.between(1.8f, 2.3f));
  const Vec3f a{-x, south, kGround}, b{x, south, kGround}, c{x, north, kGround}, d{-x, north, kGround};
  add_room_part(scene, "floor", rectangle(a, b - a, d - a, kBroadCell), painted(floor_texture(draw, 2 * x, north - south)));
  const RoomWall walls[] = {{"south", b, {-1, 0, 0}, 2 * x},
                            {"east", c, {0, -1, 0}, north - south},
                            {"north", d, {1, 0, 0}, 2 * x},
                            {"west", a, {0, 1, 0}, north - south}};
  const float height = kTop - kGround;
  for (const RoomWall& wall : walls) {
    const bool used = plan.wall_y && wall.along.x > 0;
    add_room_part(scene, fmt::format("wall_{}", wall.name),
                  rectangle(wall.corner, wall.length * wall.along, {0, 0, height}, used ? kNearCell : kBroadCell),
                  painted(wall_texture(draw, wall.length, height)));
    if (paint == RoomPaint::Patterned) add_pictures(scene, wall, draw, used ? x - 0.7f : 1e3f, used ? x + 0.7f : -1e3f);
  }
  add_gallery_table(scene, plan, draw);
  // Points around the table and before each wall, from which the skies are seen.
  const float e = plan.extent, y = 0.5f * (north + south);
  scene.probes = {{0, 0, 0.5f},
                  {0.8f * e, 0.8f * e, 0.02f},
                  {-0.8f * e, 0.8f * e, 0.02f},
                  {0.8f * e, -0.8f * e, 0.02f},
                  {-0.8f * e, -0.8f * e, 0.02f},
                  {0, south + 0.4f, -0.6f},
                  {x - 0.05f, y, 0.6f},
                  {0.05f - x, y, 0.6f},
                  {0, north - 0.05f, 0.7f},
                  {0, south + 0.05f, 0.6f}};
}

void add_gallery_lights(Scene& scene, const GalleryPlan& plan, uint64_t seed) {
  Draw draw(seed, kLightPurpose);
  const int lamps = draw.whole(1, 2);
  for (int i = 0; i < lamps; ++i) {
    const float u = draw.between(0.3f, 0.7f), v = draw.between(0.2f, 0.4f),
                power = draw.between(1.3f, 2.0f) / (u * v * static_cast<float>(lamps));
    const float phi = draw.between(plan.wall_y ? -kPi : 0.0f, plan.wall_y ? 0.0f : 2 * kPi), off = draw.between(0.2f, 0.7f);
    const Vec3f middle{off * std::cos(phi), off * std::sin(phi), draw.between(1.45f, 1.58f)};
    const Vec3f colour{1, draw.between(0.75f, 0.95f), draw.between(0.5f, 0.9f)};
    // cross(edge_u, edge_v) looks down.
    add_lamp(scene, {middle - 0.5f * Vec3f{u, v, 0}, {0, v, 0}, {u, 0, 0}, power * colour});
  }
  struct Sky {
    const char* name;
    Vec3f (*radiance)(const Vec3f&);
    float radiosity;
  };
  std::array<Sky, 3> skies = {{{"noon", noon_sky, 1.4f}, {"sunset", sunset_sky, 1.6f}, {"studio", studio_lights, 1.6f}}};
  draw.shuffle(std::span<Sky>(skies));
  for (size_t i = 0; i < skies.size(); ++i) {
    Environment sky = painted_environment(256, turned_sky(skies[i].radiance, draw.between(0, 2 * kPi)), skies[i].radiosity);
    if (i == 0)
      scene.environment = std::move(sky);
    else
      scene.others.push_back({skies[i].name, std::move(sky)});
  }
}

}  // namespace vitrine::generate
