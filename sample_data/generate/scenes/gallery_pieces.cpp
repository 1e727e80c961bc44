#include "sample_data/generate/scenes/gallery_pieces.h"

#include <algorithm>
#include <cmath>

#include "sample_data/generate/content.h"
#include "sample_data/generate/revolve.h"

namespace vitrine::generate {
namespace {

constexpr PieceKind kKinds[] = {
    {"box_case", PieceGroup::Glass, false, box_case},
    {"dome", PieceGroup::Glass, false, dome},
    {"bottle", PieceGroup::Glass, false, bottle},
    {"jar", PieceGroup::Glass, false, jar},
    {"wine_glass", PieceGroup::Glass, false, wine_glass},
    {"glazed_picture", PieceGroup::Glass, true, glazed_picture},
    {"glass_ball", PieceGroup::Glass, false, glass_ball},
    {"paperweight", PieceGroup::Glass, false, flat_paperweight},
    {"polished_sphere", PieceGroup::Metal, false, polished_sphere},
    {"spoon", PieceGroup::Metal, false, spoon},
    {"statue", PieceGroup::Metal, false, statue},
    {"vase", PieceGroup::Metal, false, metal_vase},
    {"kettle", PieceGroup::Metal, false, metal_kettle},
    {"wall_mirror", PieceGroup::Metal, true, wall_mirror},
    {"glazed_pot", PieceGroup::Coat, false, glazed_pot},
    {"car", PieceGroup::Coat, false, toy_car},
    {"lacquered_box", PieceGroup::Coat, false, lacquered_box},
};

}  // namespace

std::span<const PieceKind> glossy_kinds() { return kKinds; }

void add_part(Piece& piece, const char* name, Shape shape, Material material) {
  piece.parts.push_back(
      {.name = name, .shape = std::move(shape), .material = std::move(material), .object = true, .measured = true});
}

void add_content(Piece& piece, Piece content, float lift) {
  shift(content, {0, 0, lift});
  for (Part& part : content.parts) piece.parts.push_back(std::move(part));
  piece.matt_things += content.matt_things;
}

void shift(Piece& piece, const Vec3f& by, float turn, float scale) {
  const float c = std::cos(turn), s = std::sin(turn);
  const auto turned_by = [c, s](const Vec3f& v) { return Vec3f{c * v.x - s * v.y, s * v.x + c * v.y, v.z}; };
  const auto turned_back = [c, s](const Vec3f& v) { return Vec3f{c * v.x + s * v.y, c * v.y - s * v.x, v.z}; };
  for (Part& part : piece.parts) {
    for (Vec3f& p : part.shape.mesh.positions) p = scale * turned_by(p) + by;
    for (Vec3f& n : part.shape.mesh.normals) n = turned_by(n);
    if (part.material.content)
      part.material.content = std::make_shared<const GlassContent>(part.material.content->moved(by, turn, scale));
    if (part.material.albedo)
      part.material.albedo = [=, pattern = std::move(part.material.albedo)](const SurfacePoint& at) {
        return pattern({turned_back((1.0f / scale) * (at.position - by)), turned_back(at.normal), at.uv});
      };
  }
}

Shape vessel(std::span<const Vec2f> outer_knots, float thickness, int steps, int around) {
  const Profile outer = smooth_profile(outer_knots, steps);
  Profile whole{{0, outer.front().y}};
  whole.insert(whole.end(), outer.begin(), outer.end());
  const float floor = outer.front().y + thickness, rim = outer.back().y;
  for (size_t i = outer.size(); i-- > 0;)
    if (outer[i].x > thickness)
      whole.push_back({outer[i].x - thickness, std::lerp(floor, rim, (outer[i].y - outer.front().y) / (rim - outer.front().y))});
  whole.push_back({0, floor});
  return revolved(whole, around);
}

Blobs drawn_blobs(Draw& draw, float radius, float height) {
  struct Ball {
    Vec3f centre, radii;
  };
  std::vector<Ball> balls;
  // A trunk of three to four balls, then limbs that start on it.
  const int trunk = draw.whole(3, 4), limbs = draw.whole(2, 5);
  for (int i = 0; i < trunk; ++i) {
    const float level = (static_cast<float>(i) + 0.5f) / static_cast<float>(trunk), slim = 0.72f - 0.25f * level;
    const float across = radius * slim * draw.between(0.75f, 1.0f), up = 0.62f * height / static_cast<float>(trunk);
    const Vec3f off = (0.2f * radius) * Vec3f{draw.between(-1, 1), draw.between(-1, 1), 0};
    balls.push_back({{off.x, off.y, std::max(level * height, 0.8f * up)}, {across, across * draw.between(0.8f, 1.1f), up}});
  }
  for (int i = 0; i < limbs; ++i) {
    const Ball& body = balls[static_cast<size_t>(draw.whole(0, trunk - 1))];
    const float phi = draw.between(0, 2 * kPi), size = radius * draw.between(0.24f, 0.40f);
    const float reach = std::min(0.75f * radius, radius - size);
    balls.push_back({{reach * std::cos(phi), reach * std::sin(phi),
                      std::clamp(body.centre.z + draw.between(-0.1f, 0.12f) * height, size, height - size)},
                     {size, size * draw.between(0.8f, 1), size * draw.between(0.8f, 1)}});
  }
  const float blend = 0.35f * radius;
  const DistanceFunction distance = [balls, blend](const Vec3f& p) {
    float d = ellipsoid_distance(p, balls[0].centre, balls[0].radii);
    for (size_t i = 1; i < balls.size(); ++i) d = smooth_union(d, ellipsoid_distance(p, balls[i].centre, balls[i].radii), blend);
    return -smooth_union(-d, p.z - 0.0005f, 0.01f);
  };
  const double r = 1.25 * static_cast<double>(radius);
  return {distance, {{-r, -r, -0.012}, {r, r, 1.15 * static_cast<double>(height)}}};
}

std::vector<Vec2f> drawn_vase_knots(Draw& draw, float radius, float height) {
  constexpr float kFoot = 0.0005f;
  const float belly = draw.between(0.3f, 0.6f) * height;
  return {{radius * draw.between(0.45f, 0.7f), kFoot},
          {radius * draw.between(0.6f, 0.8f), 0.08f * height},
          {radius, belly},
          {radius * draw.between(0.35f, 0.6f), std::lerp(belly, height, 0.62f)},
          {radius * draw.between(0.32f, 0.5f), 0.90f * height},
          {radius * draw.between(0.5f, 0.75f), height}};
}

}  // namespace vitrine::generate
