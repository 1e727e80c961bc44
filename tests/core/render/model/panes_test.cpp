// Panes of glass: pictures in flat mirrors against rays that are mirrored one by one, and what they add to a pixel.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/foundation/math/dual.h"
#include "core/render/model/gbuffer.h"
#include "core/render/model/kernels/pane_blend.h"
#include "core/render/model/layered_model.h"
#include "core/render/model/opened_scene.h"
#include "core/render/model/pane_pass.h"
#include "core/render/trace/tracer.h"
#include "tests/core/render/model/exact_model.h"
#include "tests/core/render/model/showcase.h"

namespace vitrine {
namespace {

using test::kHalf;
using test::kSheetTolerance;
using test::Showcase;

TEST(MirroredView, SeesThroughTheMirrorWhatTheViewSeesInIt) {
  const Showcase s;
  const Vec3d n = normalized(Vec3d{0.3, -0.8, 0.2});
  const double offset = 0.4;
  const View behind = mirrored_view(s.view, n, offset);
  const Mat3d& r = behind.cam_from_world.rotation;
  EXPECT_NEAR(dot(cross(r * Vec3d{1, 0, 0}, r * Vec3d{0, 1, 0}), r * Vec3d{0, 0, 1}), 1, 1e-12) << "no mirrored camera";
  const auto project = [](const View& view, const Vec3d& p) {
    const Vec3d q = view.cam_from_world * p;
    return Vec3d{view.intrinsics.fx * q.x / q.z + view.intrinsics.cx, view.intrinsics.fy * q.y / q.z + view.intrinsics.cy, q.z};
  };
  for (const Vec3d& p : {Vec3d{1, -2, 0.5}, {0.2, -1.5, -0.3}, {0.7, -0.9, 1}}) {
    const Vec3d image = p - 2 * (dot(p, n) - offset) * n;  // where p seems to be
    const Vec3d seen = project(s.view, image), taken = project(behind, p);
    EXPECT_NEAR(taken.x, s.view.intrinsics.width - seen.x, 1e-9);
    EXPECT_NEAR(taken.y, seen.y, 1e-9);
    EXPECT_NEAR(taken.z, seen.z, 1e-9);
  }
}

// Pixel by pixel: the ray mirrored at a pane, traced through everything on the mirror's side of it. (The rasteriser filters
// what is small in the picture, such as what stands in the case, and rays do not: hence the few pixels that may differ.)
struct Compared {
  size_t pixels = 0, mirror = 0, differ = 0;
  float worst = 0;
};
// `meets(pixel, eye, direction)`: where the ray of a pixel meets that pane as a near or a far one, if it does.
template <class Meets>
Compared compared_with_rays(const Showcase& s, const Frame& frame, const Facet& pane, bool of_far, const Meets& meets) {
  const PaneImages& panes = frame.panes;
  const size_t pixels = frame.pixel_count(), width = size_t(s.view.intrinsics.width);
  const Vec3d &n = pane.normal, eye = s.view.centre_in_world();
  OpenedScene opened;
  without_glass(s.scene, {1, 1}, opened);
  const SplatLayer& room = opened.surfels;
  SplatLayer side(LayerKind::Transmittance, 1, 0);
  for (size_t i = 0; i < room.size(); ++i) {
    const float* m = room.at(Attribute::Mean, i);
    if ((dot(n, Vec3d{m[0], m[1], m[2]}) > pane.offset) == of_far) continue;
    side.resize(side.size() + 1);
    for (Attribute a :
         {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity, Attribute::ShDc, Attribute::ShRest})
      std::copy_n(room.at(a, i), room.width(a), side.at(a, side.size() - 1));
  }
  const auto tracer = make_tracer(TracerBackend::Reference);
  tracer->build(side);
  std::vector<Vec3f> origins, directions;
  std::vector<size_t> of;
  for (size_t i = 0; i < pixels; ++i) {
    if (!panes.shown[i] || (of_far && panes.far_cosine[i] == 0)) continue;
    const Vec3d d = normalized(s.view.ray(double(i % width) + 0.5, double(i / width) + 0.5));
    const std::optional<double> t = meets(i, eye, d);
    if (!t) continue;
    origins.push_back(cast<float>(eye + *t * d));
    directions.push_back(cast<float>(d - 2 * dot(d, n) * n));
    of.push_back(i);
  }
  const std::vector<float> start(of.size(), 1e-3f);
  RayValues values;
  tracer->forward({.origins = origins, .directions = directions, .near = start, .far = {}},
                  {.sh_degree = 1, .min_transmittance = 1e-4f}, values, nullptr);
  Compared out{.pixels = of.size()};
  for (size_t k = 0; k < of.size(); ++k) {
    const auto& color = of_far ? panes.far_color : panes.near_color;
    float error = std::abs((of_far ? panes.far_open : panes.near_open)[of[k]] - values.transmittance[k]);
    for (size_t c = 0; c < 3; ++c) error = std::max(error, std::abs(color[c * pixels + of[k]] - values.color[k][c]));
    out.differ += error > 1e-3f;
    out.worst = std::max(out.worst, error);
    out.mirror += values.transmittance[k] < 0.5f;
  }
  return out;
}

TEST(Panes, MirrorWhatRaysWouldMeet) {
  const Showcase s;
  LayeredModel model(s.options());
  Frame frame;
  model.forward(s.scene, s.view, frame);
  ASSERT_FALSE(frame.panes.empty());
  size_t mirror[2] = {}, differ = 0;
  float worst = 0;
  for (const bool of_far : {false, true})
    for (size_t f = 0; f < Box::kFaces; ++f) {
      const auto meets = [&](size_t, const Vec3d& eye, const Vec3d& d) -> std::optional<double> {
        const auto crossing = s.box.crossing(eye, d);
        EXPECT_TRUE(crossing);
        if (!crossing || !((of_far ? crossing->left : crossing->entered) == Box::face(f))) return std::nullopt;
        return of_far ? crossing->out : crossing->in;
      };
      const Compared c = compared_with_rays(s, frame, s.box.facets()[f], of_far, meets);
      mirror[of_far] += c.mirror, differ += c.differ, worst = std::max(worst, c.worst);
    }
  for (const size_t pixels : mirror) EXPECT_GT(pixels, 50u) << "that mirror something";
  EXPECT_LT(differ, (mirror[0] + mirror[1]) / 20);
  EXPECT_LT(worst, 0.3f);
}

// A single pane, whichever way its front looks: it mirrors what lies before it, and there is no second pane.
TEST(Panes, APlaneMirrorsWhatLiesBeforeIt) {
  Showcase s;
  std::vector<std::vector<float>> pictures;
  for (const double front : {1., -1.}) {
    const Mat3d axes{{1, 0, 0}, {0, 0, front}, {0, -front, 0}};  // the side of the case that looks along -y
    const Plane plane{{0, -kHalf, 0}, axes, {kHalf, kHalf}};
    s.set->entries = {{plane, ShapeRole::Sheet, kSheetTolerance, -1, {}}};
    LayeredModel model(s.options());
    Frame frame;
    model.forward(s.scene, s.view, frame);
    ASSERT_FALSE(frame.panes.empty());
    const Facet before = {{0, -1, 0}, kHalf};
    const Compared c = compared_with_rays(s, frame, before, false, [&](size_t, const Vec3d& eye, const Vec3d& d) {
      const auto hit = plane.intersect({eye, d});
      EXPECT_TRUE(hit) << "pixels that miss it show no pane";
      return hit ? std::optional<double>(hit->t) : std::nullopt;
    });
    EXPECT_GT(c.pixels, 60u);
    EXPECT_GT(c.mirror, 50u);
    EXPECT_LT(c.differ, c.mirror / 20);
    for (float share : frame.panes.far_share) EXPECT_EQ(share, 0);
    pictures.push_back(frame.srgb);
  }
  EXPECT_EQ(pictures[0], pictures[1]);
}

// The nearest sheet counts, whatever its place in the list.
TEST(Panes, OfSheetsThatOverlapAreThoseOfTheNearest) {
  Showcase s;
  const auto picture = [&](double y, bool with_case) {
    const Plane plane{{0, y, 0}, {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}, {2, 2}};
    s.set->entries.clear();
    if (with_case) s.set->entries.push_back({s.box, ShapeRole::Sheet, kSheetTolerance, -1, {}});
    s.set->entries.push_back({plane, ShapeRole::Sheet, kSheetTolerance, -1, {}});
    Frame frame;
    LayeredModel(s.options()).forward(s.scene, s.view, frame);
    return frame;
  };
  Frame of_case;
  LayeredModel(s.options()).forward(s.scene, s.view, of_case);
  const Frame before = picture(-kHalf - 0.1, true), behind = picture(kHalf + 0.1, true);
  size_t in_front = 0, of_the_case = 0;
  for (size_t i = 0; i < before.pixel_count(); ++i) {
    if (before.sheets.entry[i] == 2) {
      EXPECT_EQ(before.panes.far_share[i], 0) << "a plane has no far side, although the case is the first of the list";
      ++in_front;
    }
    if (of_case.sheets.coverage[i] < 1) continue;
    EXPECT_EQ(behind.sheets.entry[i], 1u) << "the case stands before the plane";
    EXPECT_EQ(behind.panes.near_color[i], of_case.panes.near_color[i]);
    ++of_the_case;
  }
  EXPECT_GT(in_front, 100u);
  EXPECT_GT(of_the_case, 100u);
}

TEST(Panes, AddUpToThePixelAsWritten) {
  const Showcase s;
  ImageOptions options = s.options();
  options.composite.layer_images = true;
  LayeredModel model(options);
  Frame frame;
  model.forward(s.scene, s.view, frame);
  const GBuffer g(frame);
  const size_t pixels = frame.pixel_count();
  size_t through = 0, blocked = 0;
  for (size_t group = 0; group < frame.shaded.groups(); ++group) {
    const uint32_t i = frame.shaded.chosen_pixel(group);
    if (!frame.panes.shown[i]) continue;
    const BlendMaterial<float> m = g.material(i);
    const auto at = [&](const std::vector<float>& plane) { return Vec3f{plane[i], plane[pixels + i], plane[2 * pixels + i]}; };
    const Vec3f c_r = frame.reflection.radiance[group], c_t = at(frame.behind.radiance);
    const Vec3f near = at(frame.panes.near_color) + frame.panes.near_open[i] * c_r;
    const Vec3f far = at(frame.panes.far_color) + frame.panes.far_open[i] * c_r;
    const auto crossing = s.box.crossing(s.view.centre_in_world(), cast<double>(g.ray(i).direction_per_z));
    const bool open = frame.behind.inner_transmittance[i] > 0.5f || double(frame.behind.median_z[i]) > crossing->out;
    EXPECT_EQ(frame.panes.far_share[i], open ? 1 : 0);
    const Vec3f p = (open ? 1.f : 0.f) * fresnel(m.f0, frame.panes.far_cosine[i], 1.f).value;
    const LayerWeights<float> w = layer_weights(LayerBlend::Layered, m, {true, true});
    const Vec3f behind = c_t + hadamard(p, far - c_t);
    const Vec3f expected =
        hadamard(w.diffuse, g.rgb(g.color, i)) + hadamard(w.reflection, near) + hadamard(w.transmission, behind);
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(frame.linear[c * pixels + i], expected[c], 1e-5);
    (open ? through : blocked) += 1;
  }
  EXPECT_GT(through, 100u);
  EXPECT_GT(blocked, 2u) << "of what stands in the case";
}

TEST(Panes, TakeNoPartWithoutACaseOrWhereAFaceIsNoPane) {
  Showcase s;
  ImageOptions options = s.options();
  options.shape.set = nullptr;
  LayeredModel plain(options);
  Frame frame;
  plain.forward(s.scene, s.view, frame);
  EXPECT_TRUE(frame.panes.empty());

  s.set->entries[0].clear = {0, 1, 1, 0, 0, 1};  // the faces that the camera sees from outside
  LayeredModel model(s.options());
  model.forward(s.scene, s.view, frame);
  ASSERT_FALSE(frame.panes.empty());
  for (float v : frame.panes.far_color) EXPECT_EQ(v, 0);
  for (float v : frame.panes.far_cosine) EXPECT_EQ(v, 0);

  s.set->entries[0].clear.assign(Box::kFaces, 0);
  model.forward(s.scene, s.view, frame);
  EXPECT_TRUE(frame.sheets.empty());
  EXPECT_TRUE(frame.panes.empty());
}

// What is only guessed of the room, at the end of the diffuse layer, is not mirrored; the reflection layer shows there.
TEST(Panes, MirrorNoGuesses) {
  const Showcase s;
  ImageOptions options = s.options();
  options.panes.mirrored = s.panes;
  LayeredModel model(options);
  Frame frame;
  model.forward(s.scene, s.view, frame);
  ASSERT_FALSE(frame.panes.empty());
  for (size_t i = 0; i < frame.pixel_count(); ++i) EXPECT_EQ(frame.panes.near_open[i], 1);
}

// Pictures in glass count as known: gradients are those of everything else.
TEST(Panes, GradientsMatchFiniteDifferences) {
  Showcase s;
  ImageOptions options = s.options();
  LayeredModel model(options);
  Frame frame;
  const auto loss = [&] {
    model.forward(s.scene, s.view, frame);
    return loss_of(frame);
  };
  loss();
  start_gradient(frame);
  SplatScene grad = s.scene.zeros_like();
  model.backward(s.scene, frame, grad);
  for (const Attribute a : {Attribute::ShDc, Attribute::Opacity})
    expect_differences(s.scene, grad, LayerKind::Reflection, a, loss);
}

TEST(Panes, BytesDoNotDependOnThreads) {
  const Showcase s;
  ImageOptions options = s.options();
  options.diffuse.backend = Backend::Cpu;
  expect_same_for_threads(options, s.scene, s.view);
}

TEST(PaneBlend, MatchesDualNumbers) {
  using N = Dual<double, 9>;
  const auto variable = [](const Vec3d& v, size_t at) {
    return Vec3<N>{N::variable(v.x, at), N::variable(v.y, at + 1), N::variable(v.z, at + 2)};
  };
  const auto constant = [](const Vec3d& v) { return Vec3<N>{N(v.x), N(v.y), N(v.z)}; };
  for (uint64_t seed = 0; seed < 30; ++seed) {
    Rng rng(seed, 3);
    const auto unit = [&] { return rng.uniform_double(); };
    const auto vec = [&] { return Vec3d{unit(), unit(), unit()}; };
    PaneView<double> v{vec(), vec(), unit(), unit(), seed % 4 == 0 ? 0 : unit(), unit()};
    const PaneView<N> dual_v{constant(v.near_color), constant(v.far_color), N(v.near_open),
                             N(v.far_open),          N(v.far_share),        N(v.far_cosine)};
    const Vec3d f0 = vec();
    const PaneRadiances<double> c{vec(), vec()}, g{vec(), vec()};
    const PaneRadiances<N> out = behind_panes(dual_v, variable(f0, 0), {variable(c.reflected, 3), variable(c.transmitted, 6)});
    const N exact = dot(out.reflected, constant(g.reflected)) + dot(out.transmitted, constant(g.transmitted));
    Vec3d grad_f0{};
    const PaneRadiances<double> back = behind_panes_vjp(v, f0, c, g, grad_f0);
    for (size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(grad_f0[i], exact.d[i], 1e-12);
      EXPECT_NEAR(back.reflected[i], exact.d[3 + i], 1e-12);
      EXPECT_NEAR(back.transmitted[i], exact.d[6 + i], 1e-12);
    }
  }
}

}  // namespace
}  // namespace vitrine
