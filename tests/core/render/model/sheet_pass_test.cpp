// Sheets of glass drawn from their shapes, and reflections in curved ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/render/model/kernels/mirror.h"
#include "core/render/model/layered_model.h"
#include "core/render/model/opened_scene.h"
#include "core/render/model/sheet_pass.h"
#include "core/render/trace/tracer.h"
#include "core/scene/mesh/tri_mesh.h"
#include "tests/core/render/model/exact_model.h"
#include "tests/core/render/model/snell_ball.h"
#include "tests/core/render/model/tiny_rooms.h"
#include "tests/support/gradcheck.h"

namespace vitrine {
namespace {

constexpr double kBall = 0.5, kBallTolerance = 0.02;

SurfaceOfRevolution ball(double radius) {
  SurfaceOfRevolution s{{0, 0, 0}, {0, 0, 1}, {}};
  constexpr int kSegments = 96;
  for (int i = 0; i <= kSegments; ++i) {
    const double a = M_PI * i / kSegments;
    s.profile.push_back({radius * std::sin(a), -radius * std::cos(a)});
  }
  return s;
}

// A hollow ball of glass in front of large opaque surfels on all sides, something small in it, a camera that looks at it.
struct Terrarium {
  SplatScene scene{.diffuse = SplatLayer(LayerKind::Diffuse, 1, 0),
                   .reflection = SplatLayer(LayerKind::Reflection, 1, 0),
                   .transmittance = SplatLayer(LayerKind::Transmittance, 1, 0)};
  View view;
  std::shared_ptr<ShapeSet> set = std::make_shared<ShapeSet>(ShapeSet{{{ball(kBall), ShapeRole::Sheet, kBallTolerance, -1, {}}}});

  explicit Terrarium(bool with_reflection = true) {
    const Vec3d eye{0.4, -1.9, 0.6}, z = normalized(-eye), x = normalized(cross(z, Vec3d{0, 0, 1})), y = cross(z, x);
    view.intrinsics = {32, 28, 46, 45, 16.4, 13.7};
    view.cam_from_world.rotation = {{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}};
    view.cam_from_world.translation = -(view.cam_from_world.rotation * eye);
    Rng rng(4, 4);
    const auto colour = [&] { return Vec3d{rng.uniform_double(), rng.uniform_double(), rng.uniform_double()}; };
    for (const Vec3d& at : {Vec3d{0.3, 2.4, -0.4}, {-1.9, -2.2, -0.5}, {2.2, 0.3, 0.5}, {-2.2, 0.3, 0.1}, {0.6, -2.6, -0.7}})
      add({.mean = at, .normal = -at, .size = 1.1, .opacity = 0.8, .rgb = colour()});
    add({.mean = {-0.1, -0.1, -0.1}, .normal = {0.2, -0.9, 0.2}, .size = 0.12, .opacity = 0.95, .rgb = colour()});
    if (!with_reflection) return;
    const size_t i = add_surfel(scene.reflection, {{0, 0, 6}, {0, 0, -1}, 4, 0.9, {0.9, 0.6, 0.3}}, 3);
    std::fill_n(scene.reflection.at(Attribute::ShRest, i), scene.reflection.width(Attribute::ShRest), 0.f);
  }
  void add(const RoomSurfel& s) {
    SplatLayer& layer = scene.diffuse;
    const size_t i = add_surfel(layer, s, layer.size() + 7);
    for (Attribute a : {Attribute::SpecularWeight, Attribute::Transmission}) *layer.at(a, i) = logit(1e-4f);
    std::fill_n(layer.at(Attribute::ShRest, i), layer.width(Attribute::ShRest), 0.f);
  }
  // Surfels that carry the glass for other programs.
  void carry() {
    for (double a = 0.2; a < 3; a += 0.4)
      for (double b = 0; b < 6.2; b += 0.5) {
        const Vec3d n{std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)};
        add({.mean = kBall * n, .normal = n, .size = 0.1, .opacity = 0.97});
        *scene.diffuse.at(Attribute::Transmission, scene.diffuse.size() - 1) = logit(0.98f);
      }
  }
  ImageOptions options() const {
    ImageOptions o = exact_options();
    o.transmission.glass = Glass::Thin;
    o.shape.set = set;
    return o;
  }
  Frame frame(const ImageOptions& o) const {
    Frame f;
    LayeredModel(o).forward(scene, view, f);
    return f;
  }
  Vec3d ray(size_t pixel) const {
    const auto width = static_cast<size_t>(view.intrinsics.width);
    return normalized(view.ray(double(pixel % width) + 0.5, double(pixel / width) + 0.5));
  }
};

// Ways of a ray from the eye into a ball about the origin and out of it.
std::optional<std::array<double, 2>> through_ball(const Vec3d& eye, const Vec3d& d, double radius) {
  const double b = dot(eye, d), c = dot(eye, eye) - radius * radius, root = b * b - c;
  if (root < 0) return std::nullopt;
  return std::array<double, 2>{-b - std::sqrt(root), -b + std::sqrt(root)};
}

TEST(Sheets, ShowPlaceNormalAndCoverageOfTheShape) {
  const Terrarium t;
  const Frame f = t.frame(t.options());
  ASSERT_FALSE(f.sheets.empty());
  const size_t pixels = f.pixel_count();
  const Vec3d eye = t.view.centre_in_world();
  size_t inside = 0, crossed = 0;
  double covered = 0, exact = 0;
  for (size_t i = 0; i < pixels; ++i) {
    covered += double(f.sheets.coverage[i]);
    constexpr int kFine = 16;  // lines a pixel
    const int x = int(i) % f.view->intrinsics.width, y = int(i) / f.view->intrinsics.width;
    for (int v = 0; v < kFine; ++v)
      for (int u = 0; u < kFine; ++u) {
        const Vec3d d = normalized(t.view.ray(x + (u + 0.5) / kFine, y + (v + 0.5) / kFine));
        exact += through_ball(eye, d, kBall).has_value() / double(kFine * kFine);
      }
    crossed += f.sheets.coverage[i] > 0 && f.sheets.coverage[i] < 1;
    const auto way = through_ball(eye, t.ray(i), 0.97 * kBall);
    if (!way) continue;
    ++inside;
    EXPECT_EQ(f.sheets.coverage[i], 1);
    const Vec3d n = normalized(eye + (*through_ball(eye, t.ray(i), kBall))[0] * t.ray(i));
    const float alpha = f.diffuse.plane(Aov::Alpha)[i];
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(f.diffuse.plane(Aov::Normal)[c * pixels + i], double(alpha) * n[c], 0.02);
    EXPECT_EQ(f.diffuse.plane(Aov::Transmission)[i], 1);
  }
  EXPECT_GT(inside, 200u);
  EXPECT_GT(crossed, 30u);
  EXPECT_NEAR(covered, exact, 0.01 * exact);
}

// What stands before a sheet hides it.
TEST(Sheets, AreHiddenByWhatStandsBeforeThem) {
  Terrarium t;
  t.add({.mean = {0.3, -1.2, 0.4}, .normal = {0.2, -1, 0.2}, .size = 0.12, .opacity = 0.98, .rgb = {1, 0, 0}});
  const Frame f = t.frame(t.options());
  const Vec3d eye = t.view.centre_in_world(), to = normalized(Vec3d{0.3, -1.2, 0.4} - eye);
  size_t hidden = 0;
  for (size_t i = 0; i < f.pixel_count(); ++i)
    if (dot(t.ray(i), to) > 0.9995) {
      EXPECT_EQ(f.sheets.entry[i], 0u);
      ++hidden;
    }
  EXPECT_GT(hidden, 3u);
}

// Surfels of glass change nothing where a sheet stands for them, and neither does it whether what is seen through the glass alone
// is in the transmittance layer.
TEST(Sheets, StandForTheSurfelsThatCarryTheGlass) {
  Terrarium plain, carried;
  carried.carry();
  EXPECT_EQ(plain.frame(plain.options()).srgb, carried.frame(carried.options()).srgb);
  Terrarium moved;
  SplatLayer& behind = moved.scene.transmittance;
  const size_t last = moved.scene.diffuse.size() - 1;
  behind.resize(1);
  for (Attribute a :
       {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity, Attribute::ShDc, Attribute::ShRest})
    std::copy_n(moved.scene.diffuse.at(a, last), behind.width(a), behind.at(a, 0));
  moved.scene.diffuse.resize(last);
  const Frame a = plain.frame(plain.options()), b = moved.frame(moved.options());
  for (size_t i = 0; i < a.srgb.size(); ++i) EXPECT_NEAR(a.srgb[i], b.srgb[i], 2e-4);
}

// Everything around and in the ball has radiance 1: so has the ball, whatever it mirrors.
TEST(Sheets, LoseNoLight) {
  Terrarium t(false);
  for (size_t i = 0; i < t.scene.diffuse.size(); ++i) {
    std::fill_n(t.scene.diffuse.at(Attribute::ShDc, i), 3, float(0.5 / double(kShDc)));
    *t.scene.diffuse.at(Attribute::Opacity, i) = logit(0.98f);
    for (size_t c = 0; c < 2; ++c) t.scene.diffuse.at(Attribute::LogScale, i)[c] += i + 1 < t.scene.diffuse.size() ? 1.2f : 0.f;
  }
  t.add({.mean = {0, 0, 3}, .normal = {0, 0, -1}, .size = 4, .opacity = 0.98, .rgb = {1, 1, 1}});
  t.add({.mean = {0, 0, -3}, .normal = {0, 0, 1}, .size = 4, .opacity = 0.98, .rgb = {1, 1, 1}});
  const Frame f = t.frame(t.options());
  size_t mirrored = 0;
  for (size_t i = 0; i < f.pixel_count(); ++i) {
    if (f.sheets.entry[i] == 0) continue;
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(f.linear[c * f.pixel_count() + i], 1, 0.06);
    mirrored += f.panes.near_open[i] < 0.1f;
  }
  EXPECT_GT(mirrored, 200u);
}

// The near wall mirrors what a ray meets outside of the ball, the far wall what one meets inside and beyond.
TEST(Shells, MirrorWhatRaysWouldMeet) {
  const Terrarium t;
  const Frame f = t.frame(t.options());
  ASSERT_FALSE(f.panes.empty());
  const size_t pixels = f.pixel_count();
  const Vec3d eye = t.view.centre_in_world();
  const auto tracer = make_tracer(TracerBackend::Reference);
  OpenedScene opened;
  without_glass(t.scene, {1, 1}, opened);
  tracer->build(opened.surfels);
  size_t near = 0, far = 0, differ = 0;
  for (size_t i = 0; i < pixels; ++i) {
    const Vec3d d = t.ray(i);
    const auto way = through_ball(eye, d, kBall);
    if (!way || !through_ball(eye, d, 0.9 * kBall)) continue;
    for (const bool of_far : {false, true}) {
      if (of_far && f.panes.far_share[i] == 0) continue;
      const Vec3d at = eye + (*way)[of_far ? 1 : 0] * d, n = normalized(at);
      const std::vector<Vec3f> origin{cast<float>(at)}, direction{cast<float>(d - 2 * dot(d, n) * n)};
      const std::vector<float> start{0.01f};
      RayValues values;
      tracer->forward({.origins = origin, .directions = direction, .near = start, .far = {}},
                      {.sh_degree = 1, .min_transmittance = 0.02f}, values, nullptr);
      const auto& color = of_far ? f.panes.far_color : f.panes.near_color;
      float error = std::abs((of_far ? f.panes.far_open : f.panes.near_open)[i] - values.transmittance[0]);
      for (size_t c = 0; c < 3; ++c) error = std::max(error, std::abs(color[c * pixels + i] - values.color[0][c]));
      differ += error > 0.04f;
      (of_far ? far : near) += 1;
    }
    if (f.panes.far_share[i] > 0) {
      EXPECT_NEAR(f.panes.far_cosine[i], dot(d, normalized(eye + (*way)[1] * d)), 0.02);
    }
  }
  EXPECT_GT(near, 150u);
  EXPECT_GT(far, 100u);
  EXPECT_LT(differ, (near + far) / 25);
}

// Through sheets gradients reach what stands behind them and the reflection layer.
TEST(Sheets, GradientsMatchFiniteDifferences) {
  Terrarium t;
  const LayeredModel model(t.options());
  Frame f;
  const auto loss = [&] {
    model.forward(t.scene, t.view, f);
    return loss_of(f);
  };
  loss();
  start_gradient(f);
  SplatScene grad = t.scene.zeros_like();
  model.backward(t.scene, f, grad);
  // What walls mirror carries no gradient: the small thing in the ball is seen in none of them here.
  const GradTolerance tolerance{.relative_l2 = 3e-2, .bias = 3e-2, .row_floor = 0.05};
  expect_differences(t.scene, grad, LayerKind::Diffuse, Attribute::ShDc, loss, tolerance, t.scene.diffuse.size() - 1);
  expect_differences(t.scene, grad, LayerKind::Reflection, Attribute::ShDc, loss, tolerance);
}

// The same ball, of solid glass.
struct Paperweight : Terrarium {
  explicit Paperweight(bool with_reflection = true) : Terrarium(with_reflection) { set->entries[0].role = ShapeRole::Solid; }
  ImageOptions options() const {
    ImageOptions o = Terrarium::options();
    o.transmission.backend = TracerBackend::Reference;
    o.transmission.thick = solid_glass(*set);
    o.composite.gate = 0;
    return o;
  }
};

TEST(SolidGlass, ShowsWhatBentRaysMeetLessWhatWallsReflect) {
  Paperweight t(false);
  ImageOptions o = t.options();
  o.composite.layer_images = true;
  const Frame f = t.frame(o);
  const auto tracer = make_tracer(TracerBackend::Reference);
  tracer->build(f.opened.surfels);
  const size_t n = f.pixel_count();
  const Vec3f eye = cast<float>(t.view.centre_in_world());
  size_t bent = 0;
  for (size_t i = 0; i < n; ++i) {
    if (!f.sheets.shows_solid(uint32_t(i)) || f.sheets.coverage[i] < 1) continue;
    const auto way = test::through_ball(t.view.centre_in_world(), normalized(t.ray(i)), {}, kBall, kGlassIndex);
    ASSERT_TRUE(way);
    if (way->offset > 0.9) continue;
    ++bent;
    const double inside = std::asin(way->offset / kGlassIndex),
                 passes = 1 - dielectric_reflectance(std::cos(inside), kGlassIndex);
    const BentRay exact = o.transmission.thick->path(eye, cast<float>(normalized(t.ray(i))), float(way->entry_distance));
    ASSERT_EQ(exact.leg_count, 2u);
    EXPECT_NEAR(exact.legs[0].passed, 1, 1e-6);
    EXPECT_NEAR(exact.legs[1].passed, passes, 2e-3);
    RayValues legs;
    const std::vector<Vec3f> origins{exact.legs[0].origin, cast<float>(way->exit)},
        directions{exact.legs[0].direction, cast<float>(way->direction)};
    const std::vector<float> far{exact.legs[0].length, 1e9f};
    tracer->forward({.origins = origins, .directions = directions, .far = far}, {.sh_degree = 1}, legs, nullptr);
    for (size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(f.behind.radiance[c * n + i], legs.color[0][c] + legs.transmittance[0] * float(passes) * legs.color[1][c],
                  0.02);
    EXPECT_NEAR(f.diffuse.plane(Aov::F0)[i] / f.diffuse.plane(Aov::Alpha)[i], kWallReflectance, 1e-6);
  }
  EXPECT_GT(bent, 50u);
}

TEST(SolidGlass, GradientsMatchFiniteDifferences) {
  Paperweight t;
  const LayeredModel model(t.options());
  Frame f;
  const auto loss = [&] {
    model.forward(t.scene, t.view, f);
    return loss_of(f);
  };
  loss();
  EXPECT_GT(std::ranges::count(f.behind.path, GlassPath::Bent), 50);
  start_gradient(f);
  SplatScene grad = t.scene.zeros_like();
  model.backward(t.scene, f, grad);
  // What the walls mirror carries no gradient: the small thing in the ball is seen in none of them here.
  for (const Attribute a : {Attribute::Mean, Attribute::LogScale, Attribute::Opacity, Attribute::ShDc})
    expect_differences(t.scene, grad, LayerKind::Diffuse, a, loss, {.relative_l2 = 5e-2, .bias = 3e-2, .row_floor = 0.05},
                       t.scene.diffuse.size() - 1);
}

TEST(Shells, BytesDoNotDependOnThreads) {
  const Terrarium t;
  ImageOptions o = t.options();
  o.diffuse.backend = Backend::Cpu;
  expect_same_for_threads(o, t.scene, t.view);
}

}  // namespace
}  // namespace vitrine
