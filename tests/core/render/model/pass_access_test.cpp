// What passes say that they read and change of a frame, against what they do.
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "core/render/model/layered_model.h"
#include "tests/core/render/model/frame_parts.h"
#include "tests/core/render/model/showcase.h"

namespace vitrine {
namespace {

using test::all_parts, test::content, test::forget, test::gradients_of, test::values_of;

using Changes = std::set<std::pair<std::string_view, std::string_view>>;  // pass, part

std::set<FramePart> parts(std::initializer_list<std::vector<FramePart>> lists) {
  std::set<FramePart> out;
  for (const auto& list : lists) out.insert(list.begin(), list.end());
  return out;
}
std::set<FramePart> changed_by(const PassAccess& access) { return parts({access.writes, access.adds}); }

void forget_all_but(const std::set<FramePart>& kept, Frame& frame) {
  for (const FramePart part : all_parts())
    if (!kept.contains(part)) forget(part, frame);
}

// One picture, pass by pass. `frame` has what pictures before left.
void expect_true_access(const ImageOptions& options, const SplatScene& scene, const View& view, Frame& frame, Changes& seen) {
  const LayeredModel model(options);
  frame.view = &view;
  frame.options = options;
  for (const auto& pass : model.passes()) {
    SCOPED_TRACE(pass->name());
    const PassAccess access = pass->access();
    const std::set<FramePart> changed = changed_by(access);
    Frame alone = frame;
    forget_all_but(parts({access.reads, access.adds}), alone);
    pass->forward(scene, alone);
    std::map<FramePart, std::string> before;
    for (const FramePart part : all_parts()) before[part] = content(frame, part);
    pass->forward(scene, frame);
    for (const FramePart part : all_parts()) {
      const std::string after = content(frame, part);
      if (!changed.contains(part)) {
        EXPECT_TRUE(after == before[part]) << "changes '" << name(part) << "', which it does not say";
        continue;
      }
      EXPECT_TRUE(after == content(alone, part)) << "reads for '" << name(part) << "' what it does not say";
      if (after != before[part]) seen.emplace(pass->name(), name(part));
    }
  }
}

// The reverse of one picture, pass by pass: `other` takes each step with what its pass declares alone.
void expect_true_reverse(const ImageOptions& options, const SplatScene& scene, const View& view, Changes& seen) {
  const LayeredModel model(options), other(options);
  Frame frame, of_other;
  model.forward(scene, view, frame), other.forward(scene, view, of_other);
  start_statistics(scene, frame);
  frame.error_image.resize(frame.pixel_count());
  for (auto* values : {&frame.grad_srgb, &frame.error_image})
    for (size_t i = 0; i < values->size(); ++i) (*values)[i] = float(1 + i % 7);
  SplatScene grad = scene.zeros_like();
  for (size_t i = model.passes().size(); i-- > 0;) {
    Pass& pass = *model.passes()[i];
    SCOPED_TRACE(pass.name());
    const PassAccess access = pass.access();
    const std::set<FramePart> had = parts({access.reads, access.writes, access.adds, access.reverse_adds});
    Frame alone = frame;
    SplatScene grad_alone = grad;
    forget_all_but(parts({{had.begin(), had.end()}, access.reverse_reads}), alone);
    other.passes()[i]->backward(scene, alone, grad_alone);
    std::map<FramePart, std::pair<std::string, std::string>> before;
    for (const FramePart part : all_parts()) before[part] = {values_of(frame, part), gradients_of(frame, part)};
    pass.backward(scene, frame, grad);
    for (const FramePart part : all_parts()) {
      EXPECT_TRUE(values_of(frame, part) == before[part].first) << "changes '" << name(part) << "' in reverse";
      const std::string after = gradients_of(frame, part);
      const bool changes = after != before[part].second;
      if (changes) seen.emplace(pass.name(), name(part));
      EXPECT_TRUE(!changes || had.contains(part)) << "changes '" << name(part) << "' in reverse, which it does not say";
      EXPECT_TRUE(!changes || after == gradients_of(alone, part)) << "reads for '" << name(part) << "' what it does not say";
    }
    for (LayerKind kind : kAllLayers)
      EXPECT_TRUE(grad.layer(kind) == grad_alone.layer(kind)) << "reads for the " << name(kind) << " layer what it does not say";
    EXPECT_EQ(model.shape().gradients(), other.shape().gradients()) << "reads for the shapes what it does not say";
  }
}

// Specular surfels on a square, or paint.
void cover(SplatLayer& layer, const Vec3d& middle, const Vec3d& u, const Vec3d& v, float specular) {
  for (double a = -0.9; a < 1; a += 0.2)
    for (double b = -0.9; b < 1; b += 0.2) {
      const size_t i = add_surfel(layer, {middle + a * u + b * v, cross(u, v), 0.15 * length(u), 0.97, {0.2, 0.3, 0.4}}, 1);
      *layer.at(Attribute::SpecularWeight, i) = logit(specular);
      *layer.at(Attribute::Transmission, i) = logit(1e-4f);
    }
}

// A flat mirror before a painted wall with a clear coat.
void hang_mirror_on_coat(test::Showcase& s) {
  const Vec3d x{1, 0, 0}, z{0, 0, 1};
  const Plane mirror{{0, -0.5, 0}, {x, z, {0, -1, 0}}, {0.4, 0.4}}, wall{{0, 0.2, 0}, {x, z, {0, -1, 0}}, {1.6, 1.6}};
  s.set->entries = {{mirror, ShapeRole::Mirror, 0.05, -1, {}}, {wall, ShapeRole::Coat, 0.05, -1, {}}};
  s.set->entries[1].exact = true;
  s.scene.diffuse.resize(0);  // no glass before the mirror
  s.dull(s.scene.diffuse, {.mean = {-1.7, -2.8, -1}, .normal = {1.7, 2.8, 1}, .size = 1.2, .opacity = 0.8});
  cover(s.scene.diffuse, mirror.centre, 0.4 * x, 0.4 * z, 0.9f);
  cover(s.scene.diffuse, wall.centre, 1.6 * x, 1.6 * z, 1e-4f);
}

TEST(PassAccess, CoversWhatPassesDo) {
  Changes seen, seen_in_reverse;
  Frame frame;
  const auto show = [&](const char* what, const ImageOptions& options, const SplatScene& scene, const View& view) {
    SCOPED_TRACE(what);
    expect_true_access(options, scene, view, frame, seen);
    expect_true_reverse(options, scene, view, seen_in_reverse);
  };
  const LayeredRoom room = furnished_room({}, 3);
  ImageOptions options = exact_options();
  options.composite.layer_images = true;
  show("traced glass", options, room.scene, room.view);
  options.transmission.glass = Glass::Thin;
  show("thin glass", options, room.scene, room.view);
  options.medium = {{0.1, 0.2, 0.3}, {0.2, 0.2, 0.1}, {0.05, 0.2, 0.3}};
  show("thin glass under water", options, room.scene, room.view);

  test::Showcase glass_case, dome, mirror;
  show("a case of glass", glass_case.options(), glass_case.scene, glass_case.view);
  const SurfaceOfRevolution ball{{0, 0, -0.5}, {0, 0, 1}, {{0, 0}, {0.35, 0.15}, {0.5, 0.5}, {0.35, 0.85}, {0, 1}}};
  dome.set->entries = {{ball, ShapeRole::Sheet, test::kSheetTolerance, -1, {}}};
  show("a dome of glass", dome.options(), dome.scene, dome.view);
  hang_mirror_on_coat(mirror);
  ImageOptions with_layers = mirror.options();
  with_layers.composite.layer_images = true;
  show("a mirror on a coat", with_layers, mirror.scene, mirror.view);
  // An opaque twin is seen in pictures that nobody learns from.
  mirror.scene.opaque = mirror.scene.diffuse;
  with_layers.opaque.layered = 0.5f;
  frame.differentiable = false;
  expect_true_access(with_layers, mirror.scene, mirror.view, frame, seen);
  frame.differentiable = true;
  with_layers.shape.silhouettes = false;
  with_layers.transmission.glass = Glass::Traced;
  show("the same without silhouettes and thin glass", with_layers, mirror.scene, mirror.view);
  show("a case of glass again", glass_case.options(), glass_case.scene, glass_case.view);
  show("traced glass again", exact_options(), room.scene, room.view);

  // The scenes above have something for every pass to do.
  const LayeredModel all(exact_options());
  for (const auto& pass : all.passes()) {
    for (const FramePart part : changed_by(pass->access()))
      EXPECT_TRUE(seen.contains({pass->name(), name(part)})) << pass->name() << " never changes '" << name(part) << "'";
    for (const FramePart part : pass->access().reverse_adds)
      EXPECT_TRUE(seen_in_reverse.contains({pass->name(), name(part)})) << pass->name() << ", reverse: '" << name(part) << "'";
  }
}

}  // namespace
}  // namespace vitrine
