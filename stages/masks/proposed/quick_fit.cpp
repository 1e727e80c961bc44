#include "stages/masks/proposed/quick_fit.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/process.h"
#include "core/base/rng.h"
#include "core/camera/projection.h"
#include "core/image/resample.h"
#include "core/loss/loss_set.h"
#include "core/math/color.h"
#include "core/math/orthonormal_basis.h"
#include "core/math/quantile.h"
#include "core/model/diffuse_pass.h"
#include "core/model/display_pass.h"
#include "core/model/image_model.h"
#include "core/optim/densify.h"
#include "core/optim/rates.h"
#include "core/scene/activation.h"
#include "core/stereo/borrowed_depth.h"

namespace vitrine {

namespace {

enum : uint64_t { kOrderStream = 0x3a01, kPixelStream = 0x3a02 };

constexpr double kInitialShare = 0.75;   // of the cap; the rest grows where the picture needs it
constexpr double kSparseShare = 0.45;    // of the first surfels; the others lie on rays
constexpr double kHalfSizeUntil = 0.45;  // part of the steps at half size
constexpr double kFarFactor = 1.5;       // of the farthest known depth: where rays without a depth begin
constexpr double kReach = 0.12;          // of the picture's diagonal: how far a known depth is borrowed
constexpr float kOpacity = 0.3f;

struct Seed {
  Vec3d position, towards;
  Vec3f linear;
  double spacing;
};

std::vector<Seed> first_surfels(const QuickFitConfig& config, const MaskCapture& capture, const std::vector<SmallPhoto>& photos) {
  const ViewSet& set = capture.set;
  const auto total = static_cast<size_t>(std::max(100.0, kInitialShare * config.surfels));
  const size_t sparse = std::min(set.points.size(), static_cast<size_t>(kSparseShare * double(total)));
  std::vector<Seed> seeds;
  std::vector<std::vector<KnownDepth>> known(set.views.size());
  for (const ScenePoint& point : set.points)
    for (uint32_t v : point.views)
      if (const auto p = projection(point.position, photos[v].view)) known[v].push_back({p->x, p->y, p->z});
  const auto spacing_at = [&](const Intrinsics& k, double z, size_t share) {
    return std::sqrt(double(k.width) * k.height / double(std::max<size_t>(share, 1))) * z / k.fx;
  };
  const size_t per_view = std::max<size_t>(1, total / photos.size());
  for (size_t s = 0; s < sparse; ++s) {
    const ScenePoint& point = set.points[s * set.points.size() / sparse];
    if (point.views.empty()) continue;
    const View& view = photos[point.views[0]].view;
    const double z = (view.cam_from_world * point.position).z;
    if (!(z > 0)) continue;
    seeds.push_back({point.position, view.centre_in_world() - point.position, point.linear_rgb,
                     spacing_at(view.intrinsics, z, 3 * per_view)});
  }
  std::vector<double> depths;
  for (const auto& of_view : known)
    for (const KnownDepth& k : of_view) depths.push_back(k.z);
  const double far_everywhere = depths.empty() ? 3.0 : kFarFactor * quantile_of(depths, 0.98);
  const size_t on_rays = total - std::min(total, seeds.size());
  for (size_t v = 0; v < photos.size(); ++v) {
    const SmallPhoto& photo = photos[v];
    const Intrinsics& k = photo.view.intrinsics;
    const Rigid world_from_cam = inverse(photo.view.cam_from_world);
    const size_t share = (v + 1) * on_rays / photos.size() - v * on_rays / photos.size(), pixels = photo.srgb.size() / 3;
    for (size_t s = 0; s < share; ++s) {
      Rng rng(static_cast<uint64_t>(config.seed), mix64(kPixelStream, mix64(v, s)));
      const double x = rng.uniform_double() * k.width, y = rng.uniform_double() * k.height;
      const auto borrowed = borrowed_depth(known[v], x, y, kReach * std::hypot(k.width, k.height));
      const double z = borrowed ? borrowed->z : far_everywhere;
      const size_t pixel = std::min(size_t(y), size_t(k.height) - 1) * size_t(k.width) + std::min(size_t(x), size_t(k.width) - 1);
      Seed seed{.position = world_from_cam * (z * k.ray(x, y)), .towards = {}, .linear = {}, .spacing = spacing_at(k, z, share)};
      seed.towards = world_from_cam.translation - seed.position;
      for (size_t c = 0; c < 3; ++c)
        seed.linear[c] = linear_from_srgb(photo.srgb[c * pixels + pixel]) / float(photo.view.gain[c]);
      seeds.push_back(seed);
    }
  }
  return seeds;
}

SplatLayer layer_of(const std::vector<Seed>& seeds) {
  SplatLayer layer(LayerKind::Diffuse, 0, seeds.size());
  for (size_t i = 0; i < seeds.size(); ++i) {
    const Vec3d n = normalized(seeds[i].towards);
    const auto [u, v] = orthonormal_basis(n);
    const Quatd q = quaternion(Mat3d{u, v, n});
    const double rotation[] = {q.w, q.x, q.y, q.z};
    for (size_t c = 0; c < 4; ++c) layer.at(Attribute::Rotation, i)[c] = float(rotation[c]);
    for (size_t c = 0; c < 3; ++c) {
      layer.at(Attribute::Mean, i)[c] = float(seeds[i].position[c]);
      layer.at(Attribute::ShDc, i)[c] = (seeds[i].linear[c] - 0.5f) / kShDc;
    }
    for (size_t c = 0; c < 2; ++c) layer.at(Attribute::LogScale, i)[c] = float(std::log(0.5 * seeds[i].spacing));
    *layer.at(Attribute::Opacity, i) = logit(kOpacity);
    for (Attribute a : {Attribute::F0, Attribute::Roughness, Attribute::SpecularWeight, Attribute::Transmission})
      std::fill_n(layer.at(a, i), layer.width(a), raw_value(row(a).activation, row(a).initial));
  }
  return layer;
}

SmallPhoto halved(const SmallPhoto& photo) {
  SmallPhoto half;
  const Intrinsics& k = photo.view.intrinsics;
  half.view = photo.view;
  half.view.intrinsics = k.scaled_to(std::max(1, k.width / 2), std::max(1, k.height / 2));
  const int w = half.view.intrinsics.width, h = half.view.intrinsics.height;
  for (size_t c = 0; c < 3; ++c) {
    ImageF plane(k.width, k.height, 1);
    std::copy_n(&photo.srgb[c * plane.pixel_count()], plane.pixel_count(), plane.data().data());
    const ImageF small = resized(plane, w, h);
    half.srgb.insert(half.srgb.end(), small.data().begin(), small.data().end());
  }
  return half;
}

}  // namespace

void describe(Describer& d, QuickFitConfig& c) {
  d.option("steps", c.steps, "Steps of the fit, one photo each.").range(1, 100000);
  d.option("max_side", c.max_side, "Longest side of the photos it looks at.").range(32, 4096);
  d.option("surfels", c.surfels, "Most surfels.").range(100, 1000000);
  d.option("seed", c.seed, "Seed of every random choice.").range(0, 2147483647);
}

QuickFit quick_fit(const QuickFitConfig& config, const MaskCapture& capture, const std::vector<SmallPhoto>& photos,
                   const std::function<void(double)>& progress) {
  const size_t count = photos.size();
  std::vector<SmallPhoto> small(count);
  parallel_for(count, 1, [&](size_t v) { small[v] = halved(photos[v]); });

  ImageModel model({.diffuse = {.sh_degree = 0}});
  model.emplace<DiffusePass>();
  model.emplace<DisplayPass>();
  SplatScene scene{.diffuse = layer_of(first_surfels(config, capture, photos))};
  SplatScene grad = scene.zeros_like();
  Adam adam(scene.diffuse);
  SurfelAccumulator accumulator;
  accumulator.reset(scene.diffuse.size());
  const LossSet losses;
  const RatesConfig rates;
  DensifyConfig densification;
  densification.every = std::max(20, config.steps / 12);
  densification.from = 0.15;
  densification.until = 0.75;
  const DensifyRhythm rhythm = densify_rhythm(densification, count, (densification.until - densification.from) * config.steps);

  Frame frame;
  std::vector<uint8_t> active;
  std::vector<uint32_t> order(count);
  for (int step = 0; step < config.steps; ++step) {
    throw_if_interrupted();
    const double fraction = double(step) / config.steps;
    if (size_t(step) % count == 0) {
      std::iota(order.begin(), order.end(), 0u);
      Rng rng(static_cast<uint64_t>(config.seed), mix64(kOrderStream, size_t(step) / count));
      for (size_t i = count - 1; i > 0; --i) std::swap(order[i], order[rng.below(static_cast<uint32_t>(i + 1))]);
    }
    const uint32_t v = order[size_t(step) % count];
    const SmallPhoto& photo = fraction < kHalfSizeUntil ? small[v] : photos[v];
    model.forward(scene, photo.view, frame);
    const size_t pixels = frame.pixel_count();
    frame.error_image.resize(pixels);
    for (size_t i = 0; i < pixels; ++i) {
      float sum = 0;
      for (size_t c = 0; c < 3; ++c) sum += std::abs(frame.srgb[c * pixels + i] - photo.srgb[c * pixels + i]);
      frame.error_image[i] = sum / 3;
    }
    grad.diffuse.fill(0.f);
    const LossInput input{.view = &photo.view,
                          .raster = &frame.diffuse,
                          .prediction_srgb = frame.srgb,
                          .target_srgb = photo.srgb,
                          .diffuse = &scene.diffuse};
    LossGradient gradient{.raster = &frame.grad_diffuse, .prediction_srgb = frame.grad_srgb, .diffuse = &grad.diffuse};
    losses.evaluate(fraction, input, gradient);
    model.backward(scene, frame, grad);
    active.resize(scene.diffuse.size());
    for (size_t i = 0; i < active.size(); ++i) active[i] = frame.statistics.weight[i] > 0;
    adam.step(grad.diffuse, rates_at(rates, fraction, 1.0), active, scene.diffuse);
    accumulator.add(frame.statistics);
    if (uint64_t(step + 1) % rhythm.interval == 0 && fraction >= densification.from && fraction <= densification.until) {
      densify(densification,
              {.seed = static_cast<uint64_t>(config.seed),
               .step = static_cast<uint64_t>(step),
               .cap = static_cast<size_t>(config.surfels),
               .times = rhythm.times,
               .scene_radius = 1},
              {scene.diffuse, adam, accumulator});
      grad.diffuse.resize(scene.diffuse.size());
    }
    if (progress) progress(fraction);
  }

  QuickFit fit;
  fit.views.resize(count);
  constexpr float kCovered = 0.5f;
  for (size_t v = 0; v < count; ++v) {
    model.forward(scene, photos[v].view, frame);
    FittedView& out = fit.views[v];
    out.srgb = frame.srgb;
    const auto alpha = frame.diffuse.plane(Aov::Alpha), z = frame.diffuse.plane(Aov::ZDepth);
    out.zdepth.assign(frame.pixel_count(), 0.f);
    for (size_t i = 0; i < out.zdepth.size(); ++i)
      if (alpha[i] >= kCovered) out.zdepth[i] = z[i] / alpha[i];
    double sum = 0;
    for (size_t i = 0; i < out.srgb.size(); ++i) sum += std::abs(out.srgb[i] - photos[v].srgb[i]);
    fit.l1 += sum / double(out.srgb.size()) / double(count);
  }
  return fit;
}

}  // namespace vitrine
