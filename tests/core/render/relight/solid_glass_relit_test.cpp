// A ball of solid glass under new light, against Snell's law in closed form.
#include <numbers>

#include <gtest/gtest.h>

#include "core/foundation/base/parallel.h"
#include "core/render/relight/relit_painter.h"
#include "tests/core/scene/mesh/shapes.h"
#include "tests/core/render/model/snell_ball.h"

namespace vitrine {
namespace {

using test::GlassBallScene;

constexpr float kGlass = float(GlassBallScene::kBall);

// The ball and, if `walled`, its painted room; all of it known to the last digit.
RelitScene ball_scene(const GlassBallScene& ball, bool walled, bool solid) {
  RelitScene s;
  s.trained = {ball.scene, GlassBallScene::image()};
  SplatLayer& diffuse = s.trained.surfels.diffuse;
  const size_t glass = diffuse.size() - ball.wall.size();
  if (!walled) diffuse.resize(glass);
  // The dust on the wall is in nobody's way.
  *s.trained.surfels.transmittance.at(Attribute::Opacity, 0) = -20;
  if (solid)
    s.trained.image.transmission.thick =
        std::make_shared<ThickGlass>(shapes::sphere({}, kGlass, 100, 200), float(GlassBallScene::kIor), 0.02f);
  s.materials.resize(diffuse.size());
  for (size_t i = 0; i < diffuse.size(); ++i) {
    s.materials.roughness[i] = 0.5f;
    s.materials.transmission[i] = i < glass ? 1.f : 0.f;
    for (size_t c = 0; c < 3; ++c) s.materials.albedo[i][c] = i < glass ? 0.1f : 0.5f + kShDc * diffuse.at(Attribute::ShDc, i)[c];
  }
  s.captured = Environment(ImageF(8, 4, 3, 1.f));
  s.mesh = test::sphere_mesh(kGlass, {}, 48, 96);
  if (!walled) return s;
  s.surroundings = test::sphere_mesh(GlassBallScene::kRoom, {}, 48, 96);
  for (auto& f : s.surroundings.faces) std::swap(f[1], f[2]);  // seen from inside
  for (const Vec3f& p : s.surroundings.positions) {
    Vec3f color;
    for (size_t c = 0; c < 3; ++c) color[c] = 0.5f + 0.4f * std::sin(2.5f * p[c] + 1.5f * p[(c + 1) % 3] + float(c));
    s.surroundings.colors.push_back(color);
  }
  return s;
}

Environment striped_sky() {
  ImageF map(64, 32, 3);
  for (int y = 0; y < map.height(); ++y)
    for (int x = 0; x < map.width(); ++x)
      for (int c = 0; c < 3; ++c)
        map.at(x, y, c) = float(0.5 + 0.25 * std::sin(2 * std::numbers::pi * (2 * x + c) / 64.0) + 0.2 * std::cos(0.3 * y));
  return Environment(std::move(map));
}

struct Likeness {  // of pictures whose mean counts as 1/2
  double squared = 0, sum = 0;
  size_t values = 0;
  void add(const Vec3f& ours, const Vec3f& truth) {
    for (size_t c = 0; c < 3; ++c) squared += std::pow(double(ours[c]) - double(truth[c]), 2), sum += double(truth[c]);
    values += 3;
  }
  double db() const { return -10 * std::log10(squared * double(values) / std::pow(2 * sum, 2)); }
};

// Of the pixels of the ball, but for its rim; `truth(where the bent ray leaves the ball, direction)`.
template <class Truth>
double ball_db(const RelitPicture& picture, const View& view, const Truth& truth) {
  Likeness like;
  for (size_t i = 0; i < picture.radiance.pixel_count(); ++i) {
    const auto exact = GlassBallScene::through(view, i);
    if (!exact || exact->offset > 0.9) continue;
    const float* p = &picture.radiance.data()[3 * i];
    like.add({p[0], p[1], p[2]}, truth(cast<float>(exact->exit), cast<float>(exact->direction)));
  }
  EXPECT_GT(like.values, 600u);
  return like.db();
}

TEST(SolidGlassRelit, TheSkyStandsUpsideDownInTheBall) {
  const GlassBallScene ball;
  const View view = GlassBallScene::view(0.3);
  const Environment sky = striped_sky();
  const auto picture = [&](bool solid) {
    RelitPainter painter(ball_scene(ball, false, solid));
    painter.set_lighting({.environment = sky, .points = {}, .directionals = {}, .areas = {}});
    return ball_db(painter.picture(view, {.samples = 1}), view, [&](const Vec3f&, const Vec3f& d) { return sky.radiance(d); });
  };
  const double bent = picture(true), straight = picture(false);
  EXPECT_GT(bent, 60) << straight;  // seen: 82
  EXPECT_LT(straight, 14) << bent;  // 11.6
}

TEST(SolidGlassRelit, TheWallIsLitAnewAndSeenAlongBentRays) {
  const GlassBallScene ball;
  const View view = GlassBallScene::view(0.3);
  const Lighting lamp{.environment = {}, .points = {{{0.5f, -0.9f, 0.9f}, {2, 1, 0.5f}}}, .directionals = {}, .areas = {}};
  const auto picture = [&](bool solid) {
    RelitPainter painter(ball_scene(ball, true, solid));
    painter.set_lighting(lamp);
    const RelitPicture p = painter.picture(view, {.samples = 1});
    return ball_db(p, view, [&](const Vec3f& exit, const Vec3f& d) {
      const Vec3f outside = exit + 0.05f * d;  // of the mesh of the ball, too
      return painter.lit().arriving(outside, d).from_scene;
    });
  };
  const double bent = picture(true), straight = picture(false);
  EXPECT_GT(bent, 37) << straight;  // seen: 40.6
  EXPECT_LT(straight, 18) << bent;  // 15.0
}

TEST(SolidGlassRelit, BytesDoNotDependOnThreadsOrOnWhatWasLitBefore) {
  const GlassBallScene ball;
  const View view = GlassBallScene::view(0.5);
  const auto light = [](float radiance) {
    return Lighting{.environment = Environment(ImageF(16, 8, 3, radiance)), .points = {}, .directionals = {}, .areas = {}};
  };
  const LitSceneDesc coarse{.light_samples = 8, .gather_rays = 4};
  std::vector<std::vector<float>> pictures;
  for (const int threads : {1, 3}) {
    set_thread_limit(threads);
    RelitPainter painter(ball_scene(ball, true, true));
    if (threads > 1) {
      painter.set_lighting(light(0.2f), coarse);
      painter.picture(view, {.samples = 1});
    }
    painter.set_lighting(light(0.7f), coarse);
    const RelitPicture p = painter.picture(view, {.samples = 1});
    pictures.emplace_back(p.radiance.data().begin(), p.radiance.data().end());
  }
  set_thread_limit(0);
  EXPECT_EQ(pictures[0], pictures[1]);
}

}  // namespace
}  // namespace vitrine
