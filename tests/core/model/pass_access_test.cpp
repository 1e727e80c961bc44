// What passes say that they read and change of a frame, against what they do.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "core/model/layered_model.h"
#include "tests/core/model/showcase.h"

namespace vitrine {
namespace {

std::vector<FramePart> all_parts() {
  std::vector<FramePart> out;
  for (size_t i = 0; i < kFrameParts; ++i) out.push_back(static_cast<FramePart>(i));
  return out;
}

// The bytes of numbers, vectors of numbers and structures without padding.
class Bytes {
 public:
  template <class T>
  void add(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    number(values.size());
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  template <class T>
  void number(T value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void add(const RasterImages& images) {
    number(images.width), number(images.height);
    for (const auto& plane : images.planes) add(plane);
  }
  void add(const RayValues& v) {
    add(v.color);
    for (const auto* values : {&v.transmittance, &v.distance, &v.first_hit}) add(*values);
  }
  void add(const SecondaryRays& r) {  // but for picture_weight, and what the reverse leaves
    for (const SecondaryRay& ray : r.rays) number(ray.group), number(ray.share), number(ray.lobe);
    for (const auto* values : {&r.origins, &r.directions, &r.radiance}) add(*values);
    for (const auto* values : {&r.near, &r.spread, &r.mean_distance, &r.alpha, &r.weight, &r.inner_transmittance}) add(*values);
    add(r.begin), add(r.values);
  }
  void add(const SplatLayer& layer) {
    number(layer.size());
    if (layer.size() == 0) return;
    number(layer.kind()), number(layer.sh_degree());
    for (const AttributeRow& r : kAttributes)
      for (const float v : layer.values(r.id)) number(v);
  }
  void add(const SilhouettePixel& p) {
    number(p.pixel), number(p.entry), number(p.covered), number(p.z), number(p.away), number(p.normal), number(p.crossed);
    number(p.place), number(p.grows);
  }
  void add(const SurfelStatistics& s) {
    for (const auto* values : {&s.screen_gradient, &s.weight, &s.error}) add(*values);
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

std::string values_of(const Frame& frame, FramePart part) {
  // All members: a new one must become part of one of the parts below, or an input.
  const auto& [view, options, specular_mask, transparent_mask, seed, step, differentiable, diffuse, shaded, reflection,
               transmission, sheets, panes, silhouette, coats, opened, behind, linear, srgb, layers, grad_diffuse, grad_linear,
               grad_srgb, error_image, statistics] = frame;
  Bytes b;
  switch (part) {
    case FramePart::DiffuseChannels:
      b.add(diffuse);
      break;
    case FramePart::Linear:
      b.add(linear);
      break;
    case FramePart::ShownShapes:
      b.add(silhouette.shapes);
      break;
    case FramePart::Silhouettes:
      for (const SilhouettePixel& p : silhouette.pixels) b.add(p);
      b.add(silhouette.rest), b.add(silhouette.solid);
      break;
    case FramePart::Coats:
      b.add(coats.shown), b.add(coats.normal), b.add(coats.z);
      break;
    case FramePart::Sheets:
      b.add(sheets.entry), b.add(sheets.element);
      for (const auto* values : {&sheets.coverage, &sheets.behind_alpha, &sheets.behind_median}) b.add(*values);
      break;
    case FramePart::Surfaces:
      for (const auto* values : {&shaded.pixels, &shaded.begin, &shaded.chosen}) b.add(*values);
      b.add(shaded.rays), b.add(shaded.points);
      break;
    case FramePart::ReflectionAskers:
      for (const LayersPresent& asks : shaded.asks) b.number(asks.reflection);
      break;
    case FramePart::TransmissionAskers:
      for (const LayersPresent& asks : shaded.asks) b.number(asks.transmission);
      break;
    case FramePart::OpenedScene:
      b.add(opened.surfels), b.add(opened.opaque);
      break;
    case FramePart::BehindGlass:
      for (const auto* values : {&behind.radiance, &behind.inner_transmittance, &behind.median_z}) b.add(*values);
      b.add(behind.path);
      break;
    case FramePart::Panes:
      b.add(panes.shown), b.add(panes.teaches);
      for (const auto* values :
           {&panes.near_color, &panes.far_color, &panes.near_open, &panes.far_open, &panes.far_share, &panes.far_cosine})
        b.add(*values);
      break;
    case FramePart::ReflectedRadiance:
      b.add(reflection);
      break;
    case FramePart::TransmittedRadiance:
      b.add(transmission);
      break;
    case FramePart::PictureWeights:
      for (const auto* values : {&reflection.picture_weight, &transmission.picture_weight, &behind.picture_weight})
        b.add(*values);
      break;
    case FramePart::LayerImages:
      for (const auto* values : {&layers.diffuse, &layers.reflection, &layers.transmission, &layers.reflected,
                                 &layers.transmitted, &layers.fresnel, &layers.inner_transmittance})
        b.add(*values);
      break;
    case FramePart::Srgb:
      b.add(srgb);
      break;
    case FramePart::ErrorImage:
    case FramePart::DiffuseStatistics:
    case FramePart::ReflectionStatistics:
    case FramePart::TransmittanceStatistics:
      break;
  }
  return b.take();
}

// What the reverse takes and leaves; passes that go forward size it and set it to zero.
std::string gradients_of(const Frame& frame, FramePart part) {
  Bytes b;
  const auto add_rays = [&](const SecondaryRays& r) {
    b.add(r.grad_radiance), b.add(r.gradients.color), b.add(r.gradients.first_hit);
  };
  switch (part) {
    case FramePart::DiffuseChannels:
      b.add(frame.grad_diffuse);
      break;
    case FramePart::Linear:
      b.add(frame.grad_linear);
      break;
    case FramePart::Silhouettes:
      b.add(frame.silhouette.grad_rest), b.add(frame.silhouette.grad_covered);
      break;
    case FramePart::Surfaces:
      b.add(frame.shaded.grad_points);
      break;
    case FramePart::BehindGlass:
      b.add(frame.behind.grad_radiance);
      break;
    case FramePart::Panes:
      for (const auto* values : {&frame.panes.grad_near, &frame.panes.grad_open, &frame.panes.picture_weight}) b.add(*values);
      break;
    case FramePart::ReflectedRadiance:
      add_rays(frame.reflection);
      break;
    case FramePart::TransmittedRadiance:
      add_rays(frame.transmission);
      break;
    case FramePart::Srgb:
      b.add(frame.grad_srgb);
      break;
    case FramePart::ErrorImage:
      b.add(frame.error_image);
      break;
    case FramePart::DiffuseStatistics:
      b.add(frame.statistics);
      break;
    case FramePart::ReflectionStatistics:
      b.add(frame.reflection.statistics), b.number(frame.reflection.took_part);
      break;
    case FramePart::TransmittanceStatistics:
      b.add(frame.transmission.statistics), b.number(frame.transmission.took_part);
      break;
    default:
      break;  // teaches nothing
  }
  return b.take();
}

std::string content(const Frame& frame, FramePart part) { return values_of(frame, part) + gradients_of(frame, part); }

// As before any pass.
void forget(FramePart part, Frame& frame) {
  const auto drop = [](std::vector<float>& values) {  // who reads on, reads no numbers
    std::ranges::fill(values, NAN), values.clear();
  };
  const auto poison = [](SurfelStatistics& statistics) {
    for (auto* values : {&statistics.screen_gradient, &statistics.weight, &statistics.error}) std::ranges::fill(*values, NAN);
  };
  const auto new_rays = [](SecondaryRays& rays) {
    SecondaryRays empty;
    empty.picture_weight = std::move(rays.picture_weight);
    empty.statistics = std::move(rays.statistics);
    empty.took_part = rays.took_part;
    rays = std::move(empty);
  };
  switch (part) {
    case FramePart::DiffuseChannels:
      frame.diffuse = {}, frame.grad_diffuse = {};
      break;
    case FramePart::Linear:
      drop(frame.linear), drop(frame.grad_linear);
      break;
    case FramePart::ShownShapes:
      frame.silhouette.shapes.clear();
      break;
    case FramePart::Silhouettes: {
      SilhouetteImages empty;
      empty.shapes = std::move(frame.silhouette.shapes);
      frame.silhouette = std::move(empty);
      break;
    }
    case FramePart::Coats:
      frame.coats = {};
      break;
    case FramePart::Sheets:
      frame.sheets = {};
      break;
    case FramePart::Surfaces: {
      ShadedPixels empty;
      empty.asks = std::move(frame.shaded.asks);
      frame.shaded = std::move(empty);
      break;
    }
    case FramePart::ReflectionAskers:
      for (LayersPresent& asks : frame.shaded.asks) asks.reflection = false;
      break;
    case FramePart::TransmissionAskers:
      for (LayersPresent& asks : frame.shaded.asks) asks.transmission = false;
      break;
    case FramePart::OpenedScene:
      frame.opened = {};
      break;
    case FramePart::BehindGlass: {
      BehindGlass empty;
      empty.picture_weight = std::move(frame.behind.picture_weight);
      frame.behind = std::move(empty);
      break;
    }
    case FramePart::Panes:
      frame.panes = {};
      break;
    case FramePart::ReflectedRadiance:
      new_rays(frame.reflection);
      break;
    case FramePart::TransmittedRadiance:
      new_rays(frame.transmission);
      break;
    case FramePart::PictureWeights:
      for (auto* values : {&frame.reflection.picture_weight, &frame.transmission.picture_weight, &frame.behind.picture_weight})
        drop(*values);
      break;
    case FramePart::LayerImages:
      frame.layers = {};
      break;
    case FramePart::Srgb:
      drop(frame.srgb), drop(frame.grad_srgb);
      break;
    case FramePart::ErrorImage:
      std::ranges::fill(frame.error_image, NAN);
      break;
    case FramePart::DiffuseStatistics:
      poison(frame.statistics);
      break;
    case FramePart::ReflectionStatistics:
      poison(frame.reflection.statistics);
      break;
    case FramePart::TransmittanceStatistics:
      poison(frame.transmission.statistics);
      break;
  }
}

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

  test::Showcase glass_case, dome, mirror;
  show("a case of glass", glass_case.options(), glass_case.scene, glass_case.view);
  const SurfaceOfRevolution ball{{0, 0, -0.5}, {0, 0, 1}, {{0, 0}, {0.35, 0.15}, {0.5, 0.5}, {0.35, 0.85}, {0, 1}}};
  dome.set->entries = {{ball, ShapeRole::Sheet, test::kSheetTolerance, -1, {}}};
  show("a dome of glass", dome.options(), dome.scene, dome.view);
  hang_mirror_on_coat(mirror);
  ImageOptions with_layers = mirror.options();
  with_layers.composite.layer_images = true;
  show("a mirror on a coat", with_layers, mirror.scene, mirror.view);
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
