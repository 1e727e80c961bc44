// The showcase: a painted owl in a display case of five thin panes with brass edges, a polished copper kettle and two books
// beside it, on a table of painted tiles, in a room with pictures on its walls that is open to the sky.
#include <cmath>

#include <fmt/format.h>

#include "sample_data/generate/paint.h"
#include "sample_data/generate/scenes/owl.h"
#include "sample_data/generate/scenes/scenes.h"

namespace vitrine::generate {
namespace {

// Table top at z = 0.
constexpr float kRoomHalf = 2.5f, kFloor = -0.75f, kWallTop = 1.7f;
constexpr Vec3f kCase{-0.20f, 0.02f, 0.05f};  // centre of its floor
constexpr float kCaseHalf = 0.21f, kCaseHeight = 0.55f;
constexpr Vec3f kKettle{0.40f, -0.12f, 0.0f};
constexpr float kKettleTurn = -0.6f;

struct PartFlags {
  bool object = false, measured = false;
};
void add(Scene& scene, std::string name, Shape shape, Material material, PartFlags flags = {}) {
  scene.parts.push_back({.name = std::move(name),
                         .shape = std::move(shape),
                         .material = std::move(material),
                         .object = flags.object,
                         .measured = flags.measured});
}
constexpr PartFlags kObject{true, true}, kTable{false, true};

Texture on_uv(Painting painting) {
  return [painting = std::move(painting)](const SurfacePoint& s) { return painting(s.uv.x, s.uv.y); };
}

Vec3f kettle_frame(const Vec3f& p) {  // the spout looks along +x
  const Vec3f q = p - kKettle;
  const float c = std::cos(kKettleTurn), s = std::sin(kKettleTurn);
  return {c * q.x + s * q.y, c * q.y - s * q.x, q.z};
}

float kettle_distance(const Vec3f& world) {
  const Vec3f p = kettle_frame(world);
  float d = ellipsoid_distance(p, {0, 0, 0.096f}, {0.142f, 0.142f, 0.108f});
  d = smooth_union(d, ellipsoid_distance(p, {0, 0, 0.196f}, {0.070f, 0.070f, 0.018f}), 0.012f);
  const float spout = smooth_union(capsule_distance(p, {0.100f, 0, 0.080f}, {0.185f, 0, 0.135f}, 0.036f, 0.022f),
                                   capsule_distance(p, {0.185f, 0, 0.135f}, {0.215f, 0, 0.195f}, 0.022f, 0.016f), 0.012f);
  d = smooth_union(d, spout, 0.03f);
  const float foot = 0.004f - p.z;  // cut flat, with a rounded rim
  return -smooth_union(-d, -foot, 0.012f);
}

float kettle_handle_distance(const Vec3f& world) {
  const Vec3f p = kettle_frame(world);
  const float bow = torus_distance(p, {0, 0, 0.180f}, {0, 1, 0}, 0.108f, 0.0115f);
  const float knob = smooth_union(length(p - Vec3f{0, 0, 0.236f}) - 0.019f,
                                  capsule_distance(p, {0, 0, 0.205f}, {0, 0, 0.23f}, 0.010f, 0.010f), 0.008f);
  return std::min(std::max(bow, 0.170f - p.z), knob);
}

void add_room(Scene& scene) {
  const float r = kRoomHalf, h = kWallTop - kFloor;
  const Vec3f a{-r, -r, kFloor}, b{r, -r, kFloor}, c{r, r, kFloor}, d{-r, r, kFloor}, up{0, 0, h};
  add(scene, "floor", rectangle(a, b - a, d - a, 0.05f),
      {.albedo = baked(planks(0.14f, from_srgb8(198, 150, 100), from_srgb8(110, 70, 42), 601), 2 * r, 2 * r, 0.005f)});
  Palette rug = ceramic_palette();
  for (Vec3f& colour : rug) colour = mixed(colour, {0.32f, 0.10f, 0.08f}, 0.35f);
  add(scene, "rug", rectangle({-1.7f, -1.4f, kFloor + 0.006f}, {3.4f, 0, 0}, {0, 2.8f, 0}, 0.05f),
      {.albedo = baked(glyph_tiles(0.28f, rug, 611), 3.4f, 2.8f, 0.004f)});
  struct Wall {
    const char* name;
    Vec3f corner, along, base, stain;
  };
  const Wall walls[] = {{"south", b, {-1, 0, 0}, from_srgb8(206, 188, 158), from_srgb8(168, 132, 96)},
                        {"east", c, {0, -1, 0}, from_srgb8(150, 172, 170), from_srgb8(104, 124, 132)},
                        {"north", d, {1, 0, 0}, from_srgb8(214, 196, 150), from_srgb8(172, 120, 88)},
                        {"west", a, {0, 1, 0}, from_srgb8(172, 184, 152), from_srgb8(126, 132, 96)}};
  // Along the wall, height of the lower edge over the table top, width, height.
  constexpr float kPictures[4][4][4] = {
      {{0.45f, 0.02f, 0.80f, 1.05f}, {1.55f, -0.20f, 1.15f, 0.80f}, {1.70f, 0.80f, 0.75f, 0.55f}, {3.05f, -0.05f, 1.50f, 1.00f}},
      {{0.35f, -0.10f, 1.25f, 0.85f}, {1.90f, -0.25f, 0.85f, 1.15f}, {3.05f, 0.10f, 0.60f, 0.60f}, {3.90f, -0.15f, 0.75f, 1.00f}},
      {{0.50f, -0.15f, 0.70f, 0.90f}, {1.45f, 0.00f, 1.40f, 0.95f}, {3.15f, -0.30f, 0.65f, 0.65f}, {3.10f, 0.55f, 1.30f, 0.70f}},
      {{0.30f, -0.25f, 0.95f, 0.70f},
       {1.50f, -0.05f, 1.00f, 1.30f},
       {2.80f, -0.10f, 0.70f, 0.85f},
       {3.75f, -0.20f, 0.95f, 1.15f}}};
  for (uint32_t w = 0; w < 4; ++w) {
    const Wall& wall = walls[w];
    add(scene, fmt::format("wall_{}", wall.name), rectangle(wall.corner, 2 * r * wall.along, up, 0.06f),
        {.albedo = plaster(wall.base, wall.stain, 620 + 10 * w)});
    const Vec3f inwards = cross(wall.along, Vec3f{0, 0, 1});
    for (uint32_t k = 0; k < 4; ++k) {
      const auto& [along, low, width, height] = kPictures[w][k];
      constexpr float kFrame = 0.045f, kDepth = 0.03f;
      const Vec3f corner = wall.corner + along * wall.along + Vec3f{0, 0, low - kFloor};
      const Vec3f frame_low = corner - kFrame * wall.along - Vec3f{0, 0, kFrame};
      const Vec3f frame_high = corner + (width + kFrame) * wall.along + Vec3f{0, 0, height + kFrame} + kDepth * inwards;
      Bounds3 frame;
      frame.extend(cast<double>(frame_low));
      frame.extend(cast<double>(frame_high));
      const uint32_t seed = 700 + 10 * w + k;
      add(scene, fmt::format("frame_{}{}", wall.name, k), box(cast<float>(frame.low), cast<float>(frame.high), 0.2f),
          {.albedo = solid_wood(2, k % 2 ? from_srgb8(190, 150, 80) : from_srgb8(90, 60, 44), from_srgb8(60, 40, 30), seed)});
      add(scene, fmt::format("picture_{}{}", wall.name, k),
          rectangle(corner + (kDepth + 0.002f) * inwards, width * wall.along, {0, 0, height}, 0.15f),
          {.albedo = baked(abstract_picture(width, height, seed), width, height, 0.004f)});
    }
  }
}

void add_table(Scene& scene) {
  constexpr float kX = 0.75f, kY = 0.53f, kThick = 0.04f, kLeg = 0.07f;
  const Material wood{.albedo = solid_wood(0, from_srgb8(150, 98, 60), from_srgb8(82, 48, 30), 640)};
  add(scene, "table_top", rectangle({-kX, -kY, 0}, {2 * kX, 0, 0}, {0, 2 * kY, 0}, 0.01f),
      {.albedo = baked(glyph_tiles(0.105f, ceramic_palette(), 645), 2 * kX, 2 * kY, 0.0015f)}, kTable);
  add(scene, "table_board", box({-kX, -kY, -kThick}, {kX, kY, -0.0005f}, 0.03f), wood, kTable);
  for (const float x : {-kX + 0.03f, kX - 0.03f - kLeg})
    for (const float y : {-kY + 0.03f, kY - 0.03f - kLeg})
      add(scene, fmt::format("leg_{}{}", x > 0, y > 0), box({x, y, kFloor + 0.006f}, {x + kLeg, y + kLeg, -kThick}, 0.08f),
          {.albedo = solid_wood(2, from_srgb8(150, 98, 60), from_srgb8(82, 48, 30), 641)});
}

void add_case(Scene& scene) {
  const Vec3f c = kCase;
  const float w = kCaseHalf, top = c.z + kCaseHeight;
  add(scene, "plinth", box({c.x - 0.25f, c.y - 0.25f, 0}, {c.x + 0.25f, c.y + 0.25f, c.z}, 0.02f),
      {.albedo = solid_wood(1, from_srgb8(136, 82, 48), from_srgb8(58, 30, 20), 650)}, kObject);
  const Vec3f sw{c.x - w, c.y - w, c.z}, se{c.x + w, c.y - w, c.z}, ne{c.x + w, c.y + w, c.z}, nw{c.x - w, c.y + w, c.z};
  const Vec3f up{0, 0, kCaseHeight};
  Shape panes = rectangle(sw, se - sw, up, 0.06f);
  append(panes, rectangle(se, ne - se, up, 0.06f));
  append(panes, rectangle(ne, nw - ne, up, 0.06f));
  append(panes, rectangle(nw, sw - nw, up, 0.06f));
  append(panes, rectangle(sw + up, se - sw, nw - sw, 0.06f));
  add(scene, "panes", panes, {.kind = MaterialKind::ThinGlass}, kObject);
  constexpr float kEdge = 0.003f;  // half width of a brass edge
  Shape edges;
  for (const Vec3f& corner : {sw, se, ne, nw})
    append(edges, box({corner.x - kEdge, corner.y - kEdge, c.z}, {corner.x + kEdge, corner.y + kEdge, top + kEdge}, 0.02f));
  for (const float side : {-w, w}) {
    append(edges, box({c.x - w, c.y + side - kEdge, top - kEdge}, {c.x + w, c.y + side + kEdge, top + kEdge}, 0.02f));
    append(edges, box({c.x + side - kEdge, c.y - w, top - kEdge}, {c.x + side + kEdge, c.y + w, top + kEdge}, 0.02f));
  }
  add(scene, "edges", edges, {.kind = MaterialKind::Metal, .reflectance = {0.80f, 0.58f, 0.27f}, .roughness = 0.45f}, kObject);

  const auto in_owl = [c](const Vec3f& p) { return p - c - Vec3f{0, 0, 0.0005f}; };
  const Bounds3 own = owl_bounds();
  const Vec3d shift = cast<double>(c);
  add(scene, "owl", meshed([=](const Vec3f& p) { return owl_distance(in_owl(p)); }, {own.low + shift, own.high + shift}, 0.004f),
      {.albedo = [=](const SurfacePoint& s) { return owl_colour(in_owl(s.position)); }}, kObject);
}

void add_beside(Scene& scene) {
  const Vec3d k = cast<double>(kKettle);
  add(scene, "kettle", meshed(kettle_distance, {k + Vec3d{-0.26, -0.26, -0.01}, k + Vec3d{0.26, 0.26, 0.24}}, 0.005f),
      {.kind = MaterialKind::Metal, .reflectance = {0.93f, 0.62f, 0.48f}, .roughness = 0.22f}, kObject);
  add(scene, "kettle_handle",
      meshed(kettle_handle_distance, {k + Vec3d{-0.14, -0.14, 0.15}, k + Vec3d{0.14, 0.14, 0.32}}, 0.003f),
      {.albedo = solid_wood(2, from_srgb8(96, 62, 44), from_srgb8(34, 22, 18), 660)}, kObject);
  add(scene, "book_lower", turned_box({0.42f, 0.30f, 0.0225f}, {0.30f, 0.21f, 0.044f}, 0.25f, 0.02f),
      {.albedo = on_uv(glyph_tiles(0.07f, book_palette(), 670))}, kObject);
  add(scene, "book_upper", turned_box({0.44f, 0.31f, 0.0625f}, {0.24f, 0.17f, 0.035f}, -0.35f, 0.02f),
      {.albedo = on_uv(glyph_tiles(0.055f, ceramic_palette(), 675))}, kObject);
}

}  // namespace

Scene cabinet() {
  Scene scene;
  add_room(scene);
  add_table(scene);
  add_case(scene);
  add_beside(scene);
  scene.samples = 16;
  add_lamp(scene, {{-0.35f, 0.55f, 1.66f}, {0, 0.35f, 0}, {0.7f, 0, 0}, {7.0f, 5.6f, 3.8f}});
  scene.environment = painted_environment(256, noon_sky, 1.4f);
  scene.others.push_back({"sunset", painted_environment(256, sunset_sky, 1.6f)});
  scene.others.push_back({"studio", painted_environment(256, studio_lights, 1.6f)});
  scene.probes = {{0, 0, 0.02f},        {0.5f, 0.3f, 0.3f}, {-0.6f, -0.3f, 0.1f}, {1.5f, 1.5f, -0.7f}, {-1.5f, -1.5f, -0.7f},
                  {1.5f, -1.5f, -0.7f}, {2.45f, 0, 0.6f},   {-2.45f, 0, 0.6f},    {0, 2.45f, 0.6f},    {0, -2.45f, 0.6f}};
  const Intrinsics camera{640, 480, 612.5, 612.5, 323.6, 236.9};
  const Vec3d target{0.03, 0.0, 0.17};
  add_ring(scene, {.count = 12, .azimuth_rad = 0.05, .elevation_rad = 0.22, .distance = 1.52}, target, camera);
  add_ring(scene, {.count = 12, .azimuth_rad = 0.30, .elevation_rad = 0.50, .distance = 1.56}, target, camera);
  add_ring(scene, {.count = 12, .azimuth_rad = 0.18, .elevation_rad = 0.82, .distance = 1.60}, target, camera);
  return scene;
}

}  // namespace vitrine::generate
