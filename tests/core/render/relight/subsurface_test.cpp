// The filter against random walks of light below flat, thin and round surfaces.
#include "core/render/relight/subsurface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "tests/core/render/relight/relit_ball.h"

namespace vitrine {
namespace {

constexpr double kHalfTurn = std::numbers::pi;

// Uniform numbers in (0, 1).
class Dice {
 public:
  double roll() { return (double(mix64(7, ++count_) >> 11) + 0.5) * 0x1p-53; }
  Vec3d direction() {
    const double z = 1 - 2 * roll(), r = std::sqrt(1 - z * z), phi = 2 * kHalfTurn * roll();
    return {r * std::cos(phi), r * std::sin(phi), z};
  }
  // Cosine-weighted around n.
  Vec3d diffuse(const Vec3d& n) {
    const Vec3d d = n + direction();
    return d / length(d);
  }

 private:
  uint64_t count_ = 0;
};

// Where a walk leaves the body: isotropic scattering with mean free path 1, matched index of refraction. nullopt: absorbed.
// `exit`: where the step from `in` to `out` crosses the surface.
struct Body {
  std::function<bool(const Vec3d&)> contains;
  std::function<Vec3d(const Vec3d& in, const Vec3d& out)> exit;
};
std::optional<Vec3d> walk(Dice& dice, const Body& body, double albedo, Vec3d at, Vec3d direction) {
  for (int step = 0; step < 10000; ++step) {
    const Vec3d next = at - std::log(dice.roll()) * direction;
    if (!body.contains(next)) return body.exit(at, next);
    at = next;
    if (dice.roll() > albedo) return std::nullopt;
    direction = dice.direction();
  }
  return std::nullopt;
}

Body slab(double thickness) {
  return {.contains = [=](const Vec3d& p) { return p.z < 0 && p.z > -thickness; },
          .exit =
              [=](const Vec3d& in, const Vec3d& out) {
                const double z = out.z >= 0 ? 0 : -thickness;
                return in + (z - in.z) / (out.z - in.z) * (out - in);
              }};
}

// A square grid at height z with its normals up or down.
TriMesh grid(double side, int cells, double z) {
  TriMesh m;
  for (int y = 0; y <= cells; ++y)
    for (int x = 0; x <= cells; ++x)
      m.positions.push_back(cast<float>(Vec3d{side * (double(x) / cells - 0.5), side * (double(y) / cells - 0.5), z}));
  const auto at = [&](int x, int y) { return uint32_t(y * (cells + 1) + x); };
  for (int y = 0; y < cells; ++y)
    for (int x = 0; x < cells; ++x) {
      m.faces.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      m.faces.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  return m;
}

SubsurfaceFilter filter_of(const TriMesh& mesh, float length, float albedo) {
  const std::vector<Vec3f> lengths(mesh.positions.size(), {length, length, length});
  const std::vector<Vec3f> albedos(mesh.positions.size(), {albedo, albedo, albedo});
  return {mesh, lengths, albedos, 0.01f};
}

TEST(Subsurface, ConstantLightStaysConstantAndOpaquePartsKeepTheirs) {
  TriMesh mesh = test::sphere_mesh(0.4, {}, 24, 48);
  std::vector<Vec3f> lengths(mesh.positions.size(), {0.1f, 0.05f, 0.02f}), values(mesh.positions.size(), {2, 3, 4});
  const std::vector<Vec3f> albedos(mesh.positions.size(), {0.8f, 0.7f, 0.5f});
  lengths[5] = {}, values[5] = {9, 9, 9};
  const SubsurfaceFilter filter(mesh, lengths, albedos, 0.02f);
  filter.apply(values);
  for (size_t v = 0; v < values.size(); ++v)
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(values[v][c], v == 5 ? 9.f : float(c + 2), 1e-4) << v;
  EXPECT_GT(filter.share()[0].x, filter.share()[0].z);
  EXPECT_EQ(filter.share()[5], Vec3f{});
}

TEST(Subsurface, LittleScatteringChangesNothing) {
  const TriMesh mesh = test::sphere_mesh(0.4, {}, 24, 48);
  std::vector<Vec3f> values(mesh.positions.size());
  for (size_t v = 0; v < values.size(); ++v) values[v] = (v % 2 == 0) ? Vec3f{1, 1, 1} : Vec3f{};
  const std::vector<Vec3f> before = values;
  filter_of(mesh, 1e-4f, 0.8f).apply(values);
  for (size_t v = 48; v < values.size() - 48; ++v)  // the vertices of a pole lie at one place
    EXPECT_NEAR(values[v].x, before[v].x, 0.02);
}

// A half space: how far from where it entered light leaves.
TEST(Subsurface, ProfileIsThatOfARandomWalk) {
  for (const double single : {0.8, 0.95, 0.995}) {
    Dice dice;
    std::vector<double> distances;
    constexpr int kWalks = 60000;
    for (int i = 0; i < kWalks; ++i)
      if (const auto out = walk(dice, slab(1e9), single, {0, 0, 0}, dice.diffuse({0, 0, -1})))
        distances.push_back(std::hypot(out->x, out->y));
    const double albedo = double(distances.size()) / kWalks;
    const float d = diffusion_length(1, float(albedo));
    for (const double r : {0.25, 0.5, 1.0, 2.0, 4.0}) {
      const double within = double(std::ranges::count_if(distances, [&](double x) { return x < r; })) / double(distances.size());
      EXPECT_NEAR(within, leaves_within(float(r), d), 0.05) << "albedo " << albedo << ", distance " << r;
    }
  }
}

// A plate lit from above through a slit: what leaves both of its sides. The profile is that of a half space, so that the filter
// spreads more light along a thin plate, and less through it, than a walk does.
TEST(Subsurface, APlateGlowsOnItsBack) {
  constexpr double kThick = 1.5, kSide = 16;
  constexpr int kCells = 64;
  TriMesh mesh = grid(kSide, kCells, 0);
  const TriMesh back = grid(kSide, kCells, -kThick);
  const auto first = uint32_t(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), back.positions.begin(), back.positions.end());
  for (const auto& f : back.faces) mesh.faces.push_back({f[0] + first, f[2] + first, f[1] + first});
  std::vector<Vec3f> light(mesh.positions.size());
  for (size_t v = 0; v < first; ++v)
    if (std::abs(mesh.positions[v].x) < 1.01f) light[v] = {1, 1, 1};

  Dice dice;
  constexpr int kWalks = 100000;
  const Body body = slab(kThick);
  double front_near = 0, front_far = 0, behind = 0;
  for (int i = 0; i < kWalks; ++i)
    if (const auto out = walk(dice, body, 0.98, {2.25 * (dice.roll() - 0.5), 0, 0}, dice.diffuse({0, 0, -1}))) {
      const bool top = out->z > -kThick / 2;
      (!top ? behind : std::abs(out->x) < 1.125 ? front_near : front_far) += 1.0 / kWalks;
    }
  filter_of(mesh, 1, 0.75f).apply(light);
  double near = 0, far = 0, through = 0, all = 0;
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    if (std::abs(mesh.positions[v].y) > 2) continue;
    (v >= first ? through : std::abs(mesh.positions[v].x) < 1.125 ? near : far) += light[v].x;
    all += light[v].x;
  }
  const double sum = front_near + front_far + behind;
  EXPECT_NEAR(behind / sum, through / all, 0.15) << "walk " << front_near << " " << front_far << " " << behind;
  EXPECT_NEAR(front_far / sum, far / all, 0.15) << "filter " << near / all << " " << far / all << " " << through / all;
  EXPECT_GT(through / all, 0.15);
}

// A ball in parallel light: the terminator is soft.
TEST(Subsurface, ABallUnderALampGlowsBeyondItsTerminator) {
  constexpr double kRadius = 4;
  Dice dice;
  const Body body{.contains = [](const Vec3d& p) { return squared_length(p) < kRadius * kRadius; },
                  .exit = [](const Vec3d&, const Vec3d& out) { return out * (kRadius / length(out)); }};
  constexpr int kBands = 8, kWalks = 100000;
  std::array<double, kBands> walked{}, filtered{}, area{};
  const auto band = [](double z) { return std::min(int((z / kRadius + 1) / 2 * kBands), kBands - 1); };
  double sum = 0;
  for (int i = 0; i < kWalks; ++i) {
    const double r = kRadius * std::sqrt(dice.roll()), phi = 2 * kHalfTurn * dice.roll();
    const Vec3d at{r * std::cos(phi), r * std::sin(phi), std::sqrt(kRadius * kRadius - r * r)};
    if (const auto out = walk(dice, body, 0.98, 0.999999 * at, dice.diffuse(-at / kRadius)))
      walked[size_t(band(out->z))] += 1, ++sum;
  }
  const TriMesh mesh = test::sphere_mesh(kRadius, {}, 64, 128);
  std::vector<Vec3f> light(mesh.positions.size());
  for (size_t v = 0; v < light.size(); ++v) light[v].x = std::max(mesh.positions[v].z, 0.f);
  filter_of(mesh, 1, 0.75f).apply(light);
  double all = 0;
  for (const auto& f : mesh.faces) {
    const Vec3f centre = (mesh.positions[f[0]] + mesh.positions[f[1]] + mesh.positions[f[2]]) / 3.f;
    const double a = length(cross(mesh.positions[f[1]] - mesh.positions[f[0]], mesh.positions[f[2]] - mesh.positions[f[0]])) / 2;
    const double e = a * (light[f[0]].x + light[f[1]].x + light[f[2]].x) / 3;
    filtered[size_t(band(centre.z))] += e, all += e;
  }
  for (int b = 0; b < kBands; ++b)
    EXPECT_NEAR(walked[size_t(b)] / sum, filtered[size_t(b)] / all, 0.035) << "band " << b << " from the dark pole";
  EXPECT_GT(filtered[kBands / 2 - 1] / all, 0.02) << "light beyond the terminator";
}

TEST(Subsurface, ARelitBallGlowsWhereTheLampDoesNotReach) {
  RelitScene scene = test::relit_ball({0.8f, 0.8f, 0.8f});
  Lighting light;
  light.environment = Environment(ImageF(16, 8, 3, 0.f));
  light.directionals = {{.towards = {0, 0, 1}, .irradiance = {3, 3, 3}}};
  const View view = test::view_from({2, 0, 0});
  const auto below_the_terminator = [&](RelitScene relit) {
    RelitPainter painter(std::move(relit));
    painter.set_lighting(light);
    const ImageF picture = painter.picture(view, {.samples = 4}).radiance;
    return picture.at(view.intrinsics.width / 2, view.intrinsics.height / 2 + 2, 0);
  };
  const float opaque = below_the_terminator(scene);
  scene.materials.scatter.assign(scene.materials.size(), {0.08f, 0.08f, 0.08f});
  const float wax = below_the_terminator(scene);
  EXPECT_LT(opaque, 0.02);
  EXPECT_GT(wax, opaque + 0.03);
}

TEST(Subsurface, SameBytesForAnyNumberOfThreads) {
  const TriMesh mesh = test::sphere_mesh(0.4, {}, 24, 48);
  std::vector<Vec3f> light(mesh.positions.size());
  for (size_t v = 0; v < light.size(); ++v) light[v] = {std::max(mesh.positions[v].z, 0.f), 0.1f, float(v % 7)};
  std::vector<Vec3f> one = light, many = light;
  const SubsurfaceFilter filter = filter_of(mesh, 0.05f, 0.6f);
  set_thread_limit(1);
  filter.apply(one);
  set_thread_limit(3);
  filter.apply(many);
  set_thread_limit(0);
  EXPECT_EQ(one, many);
}

}  // namespace
}  // namespace vitrine
