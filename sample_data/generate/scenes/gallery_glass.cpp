// The glass of the gallery. Cases, domes, bottles, jars and bowls are sheets without thickness; balls, paperweights and stems are
// solid.
#include <cmath>

#include "sample_data/generate/revolve.h"
#include "sample_data/generate/scenes/gallery_paint.h"
#include "sample_data/generate/scenes/gallery_pieces.h"

namespace vitrine::generate {
namespace {

constexpr int kGlassAround = 96;
constexpr float kGap = 0.0005f;  // between a thing and what it stands on, metres
const Material kSheet{.kind = MaterialKind::ThinGlass}, kSolid{.kind = MaterialKind::SolidGlass};

Shape round_plinth(float radius, float height) {
  return revolved(
      Profile{
          {0, kGap}, {radius, kGap}, {radius, 0.7f * height}, {0.93f * radius, height}, {0.45f * radius, height}, {0, height}},
      64);
}

}  // namespace

void close_above(Profile& profile, float radius, float low, float rise, int steps) {
  for (int i = 1; i <= steps; ++i) {
    const float a = 0.5f * kPi * static_cast<float>(i) / static_cast<float>(steps);
    profile.push_back({i == steps ? 0.0f : radius * std::cos(a), low + rise * std::sin(a)});
  }
}

Piece box_case(Draw& draw) {
  Piece piece;
  const float w = draw.between(0.11f, 0.15f), d = w * draw.between(0.75f, 1), high = draw.between(0.26f, 0.36f),
              foot = draw.between(0.02f, 0.05f);
  add_part(piece, "plinth", box({-w - 0.02f, -d - 0.02f, 0}, {w + 0.02f, d + 0.02f, foot}, 0.02f), {.albedo = wooden(draw, 1)});
  const Vec3f sw{-w, -d, foot}, se{w, -d, foot}, ne{w, d, foot}, nw{-w, d, foot}, up{0, 0, high};
  Shape panes = rectangle(sw, se - sw, up, 0.1f);
  append(panes, rectangle(se, ne - se, up, 0.1f));
  append(panes, rectangle(ne, nw - ne, up, 0.1f));
  append(panes, rectangle(nw, sw - nw, up, 0.1f));
  append(panes, rectangle(sw + up, se - sw, nw - sw, 0.1f));
  add_part(piece, "glass", panes, kSheet);
  if (draw.chance(0.5f)) {  // painted edges
    constexpr float kEdge = 0.003f;
    const float top = foot + high;
    Shape edges;
    for (const Vec3f& corner : {sw, se, ne, nw})
      append(edges, box({corner.x - kEdge, corner.y - kEdge, foot}, {corner.x + kEdge, corner.y + kEdge, top + kEdge}, 0.04f));
    for (const float y : {-d, d}) append(edges, box({-w, y - kEdge, top - kEdge}, {w, y + kEdge, top + kEdge}, 0.04f));
    for (const float x : {-w, w}) append(edges, box({x - kEdge, -d, top - kEdge}, {x + kEdge, d, top + kEdge}, 0.04f));
    const Vec3f colour = draw.between(0.05f, 0.35f) * Vec3f{1, draw.between(0.7f, 1), draw.between(0.5f, 1)};
    add_part(piece, "edges", edges, {.albedo = [colour](const SurfacePoint&) { return colour; }});
  }
  add_content(piece, matt_thing(draw, 0.8f * d, 0.85f * high), foot + kGap);
  return piece;
}

Piece dome(Draw& draw) {
  Piece piece;
  const float r = draw.between(0.095f, 0.135f), foot = draw.between(0.015f, 0.035f);
  const float straight = draw.between(0.10f, 0.20f), rise = r * draw.between(0.85f, 1.1f);
  add_part(piece, "plinth", round_plinth(1.18f * r, foot), {.albedo = wooden(draw, 2)});
  Profile wall{{r, foot}, {r, foot + 0.5f * straight}, {r, foot + straight}};
  close_above(wall, r, foot + straight, rise, 24);
  add_part(piece, "glass", revolved(wall, kGlassAround), kSheet);
  add_content(piece, matt_thing(draw, 0.74f * r, straight + 0.45f * rise), foot + kGap);
  return piece;
}

Piece bottle(Draw& draw) {
  Piece piece;
  const float r = draw.between(0.055f, 0.08f), high = draw.between(0.30f, 0.40f), neck = r * draw.between(0.26f, 0.42f);
  const float shoulder = draw.between(0.5f, 0.65f) * high;
  Profile wall{{0, kGap}, {0.55f * r, kGap}};
  const std::vector<Vec2f> knots = {{0.88f * r, 0.0015f},
                                    {r, 0.014f},
                                    {r * draw.between(0.94f, 1.02f), 0.5f * shoulder},
                                    {r, shoulder},
                                    {0.5f * (r + neck), std::lerp(shoulder, high, 0.33f)},
                                    {neck, std::lerp(shoulder, high, 0.55f)},
                                    {neck, 0.97f * high},
                                    {1.12f * neck, high}};
  const Profile side = smooth_profile(knots, 10);
  wall.insert(wall.end(), side.begin(), side.end());
  add_part(piece, "glass", revolved(wall, kGlassAround), kSheet);
  if (draw.chance(0.5f)) {
    const float inside = 0.92f * neck, low = 0.90f * high, top = high + 0.03f;
    add_part(piece, "cork", revolved(Profile{{0, low}, {inside, low}, {inside, 0.98f * high}, {inside, top}, {0, top}}, 32),
             {.albedo = speckled(drawn_palette(draw, 4), 0.02f, draw.texture_seed())});
  }
  return piece;
}

Piece jar(Draw& draw) {
  Piece piece;
  const float r = draw.between(0.075f, 0.105f), high = draw.between(0.17f, 0.26f), waist = draw.between(0.85f, 1.08f);
  const std::vector<Vec2f> knots = {
      {0.9f * r, 0.0015f}, {r, 0.016f}, {r * std::lerp(1.0f, waist, 0.6f), 0.5f * high}, {waist * r, high}};
  Profile wall{{0, kGap}, {0.5f * r, kGap}};
  const Profile side = smooth_profile(knots, 10);
  wall.insert(wall.end(), side.begin(), side.end());
  add_part(piece, "glass", revolved(wall, kGlassAround), kSheet);
  add_content(piece, matt_thing(draw, 0.72f * r, draw.between(0.55f, 0.9f) * high), 0.003f);
  return piece;
}

Piece wine_glass(Draw& draw) {
  Piece piece;
  const float r = draw.between(0.062f, 0.085f), high = draw.between(0.28f, 0.36f), bowl = draw.between(0.42f, 0.55f) * high;
  const float stem = draw.between(0.005f, 0.008f), foot = r * draw.between(0.75f, 0.95f), low = high - bowl;
  const std::vector<Vec2f> knots = {{0.004f, low},
                                    {0.55f * r, low + 0.10f * bowl},
                                    {r, low + 0.42f * bowl},
                                    {0.95f * r, low + 0.7f * bowl},
                                    {r * draw.between(0.70f, 0.9f), high}};
  Profile wall{{0, low}};
  const Profile side = smooth_profile(knots, 12);
  wall.insert(wall.end(), side.begin(), side.end());
  add_part(piece, "bowl", revolved(wall, kGlassAround), kSheet);
  const std::vector<Vec2f> leg = {{foot, 0.0025f},     {0.55f * foot, 0.006f}, {1.6f * stem, 0.02f},
                                  {stem, 0.25f * low}, {stem, 0.8f * low},     {1.5f * stem, low - 0.001f}};
  Profile whole{{0, kGap}, {foot, kGap}};
  const Profile leg_side = smooth_profile(leg, 8);
  whole.insert(whole.end(), leg_side.begin(), leg_side.end());
  whole.push_back({0, low - kGap});
  add_part(piece, "stem", revolved(whole, 64), kSolid);
  return piece;
}

// A picture on the wall, in a frame that holds a pane a little or a lot in front of it.
Piece glazed_picture(Draw& draw) {
  Piece piece{.hangs = true};
  const float width = draw.between(0.5f, 0.75f), height = draw.between(0.34f, 0.46f), low = draw.between(0.11f, 0.15f);
  const float depth = draw.chance(0.5f) ? draw.between(0.006f, 0.02f) : draw.between(0.04f, 0.09f);
  const Vec3f corner{-0.5f * width, -0.006f, low}, along{width, 0, 0}, up{0, 0, height};
  const Painting painting = abstract_picture(width, height, draw.texture_seed());
  add_part(piece, "picture", rectangle(corner, along, up, 0.03f), {.albedo = baked(painting, width, height, 0.003f)});
  add_part(piece, "glass", rectangle(corner - Vec3f{0, depth, 0}, along, up, 0.2f), kSheet);
  const float x = 0.5f * width, bar = draw.between(0.015f, 0.03f), front = -0.006f - depth - 0.006f;
  Shape frame = box({-x - bar, front, low - bar}, {x + bar, 0, low}, 0.04f);
  append(frame, box({-x - bar, front, low + height}, {x + bar, 0, low + height + bar}, 0.04f));
  append(frame, box({-x - bar, front, low}, {-x, 0, low + height}, 0.04f));
  append(frame, box({x, front, low}, {x + bar, 0, low + height}, 0.04f));
  add_part(piece, "frame", frame, {.albedo = wooden(draw, 0)});
  piece.matt_things = 1;
  return piece;
}

Piece glass_ball(Draw& draw) {
  Piece piece;
  const float r = draw.between(0.085f, 0.12f);
  Profile wall{{0, kGap}};
  for (int i = 1; i < 32; ++i) {
    const float a = kPi * (static_cast<float>(i) / 64.0f - 0.5f);
    wall.push_back({r * std::cos(a), kGap + r + r * std::sin(a)});
  }
  wall.push_back({r, kGap + r});
  close_above(wall, r, kGap + r, r, 32);
  add_part(piece, "glass", revolved(wall, 128), kSolid);
  return piece;
}

Piece flat_paperweight(Draw& draw) {
  Piece piece;
  const float r = draw.between(0.10f, 0.14f), rise = r * draw.between(0.6f, 0.95f), side = draw.between(0.01f, 0.025f);
  Profile wall{{0, kGap}, {0.9f * r, kGap}, {0.98f * r, 0.003f}, {r, 0.008f}, {r, side}};
  close_above(wall, r, side, rise, 32);
  add_part(piece, "glass", revolved(wall, 128), kSolid);
  // Most hold a painted disc near their foot; without one the foot mirrors, as glass on air does.
  if (draw.chance(0.75f)) {
    const float low = 0.004f;
    add_part(
        piece, "disc",
        revolved(Profile{{0, low}, {0.93f * r, low}, {0.93f * r, low + 0.001f}, {0.45f * r, low + 0.001f}, {0, low + 0.001f}},
                 64),
        {.albedo = solid_pattern(draw, drawn_palette(draw, 7), 0.4f * r)});
    piece.matt_things = 1;
  }
  if (draw.chance(0.4f)) add_content(piece, matt_thing(draw, 0.5f * r, 0.6f * rise), 0.007f);
  return piece;
}

}  // namespace vitrine::generate
