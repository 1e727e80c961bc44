// A small frame with random content for every input of a loss, and central differences over any of its buffers.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/foundation/base/rng.h"
#include "core/learn/loss/loss.h"

namespace vitrine {

// A frame with smooth random content: a slanted, wavy depth with matching but disturbed normals.
struct TestFrame {
  View view;
  RasterImages raster, grad_raster;
  std::vector<float> prediction, target, weight, grad_prediction;
  std::vector<float> specular, transparent, object, ignore, normals, confidence;
  struct Rays {
    std::vector<float> first_hit, mean_distance, alpha, wall, weight, grad;
  } reflection, transmission;
  SplatLayer layer{LayerKind::Diffuse, 1, 40}, grad_layer{LayerKind::Diffuse, 1, 40};

  TestFrame(int width, int height, bool weighted, uint64_t seed = 1) {
    view.intrinsics = {width, height, 0.9 * width, 0.95 * width, 0.45 * width, 0.55 * height};
    const double angle = 0.4;
    view.cam_from_world.rotation =
        Mat3d{{std::cos(angle), 0, -std::sin(angle)}, {0, 1, 0}, {std::sin(angle), 0, std::cos(angle)}};
    Rng rng(seed);
    const size_t n = size_t(width) * size_t(height);
    for (RasterImages* images : {&raster, &grad_raster}) {
      images->width = width;
      images->height = height;
      for (const AovRow& r : kAovs) images->planes[size_t(r.id)].assign(size_t(r.width) * n, 0.f);
    }
    prediction.resize(3 * n);
    target.resize(3 * n);
    grad_prediction.assign(3 * n, 0.f);
    for (size_t i = 0; i < 3 * n; ++i) {
      prediction[i] = 0.5f + 0.3f * std::sin(0.7f * float(i % n)) + 0.1f * rng.uniform();
      target[i] = 0.5f + 0.3f * std::sin(0.7f * float(i % n) + 0.4f) + 0.1f * rng.uniform();
      // L1 has kinks where an error, or the difference of two neighbouring ones, is zero: errors are multiples of 0.02,
      // shifted by half of that on every second pixel.
      const float error = (prediction[i] - target[i]) / 0.02f;
      const bool even = (i % n % size_t(width) + i % n / size_t(width)) % 2 == 0;
      const float rounded = even ? std::floor(error) + 0.5f : std::round(error) == 0 ? 1.f : std::round(error);
      target[i] = prediction[i] - 0.02f * rounded;
    }
    if (weighted)
      for (size_t i = 0; i < n; ++i) weight.push_back(rng.uniform() < 0.3f ? 0.f : rng.uniform());
    for (size_t i = 0; i < n; ++i) {
      const float x = float(i % size_t(width)), y = float(i / size_t(width)), alpha = 0.6f + 0.39f * rng.uniform();
      const float z = 2 + 0.05f * x + 0.03f * y + 0.02f * std::sin(x + 2 * y);
      raster.plane(Aov::Alpha)[i] = alpha;
      raster.plane(Aov::ZDepth)[i] = alpha * z;
      raster.plane(Aov::MedianZ)[i] = z * 1.01f;
      raster.plane(Aov::Distortion)[i] = rng.uniform();
      for (size_t c = 0; c < 3; ++c)
        raster.plane(Aov::Normal)[c * n + i] = alpha * (0.5f * rng.normal() - (c == 2 ? 1.f : 0.f)) * 0.5f;
    }
    for (const AttributeRow& r : kAttributes)
      for (float& v : layer.values(r.id)) v = rng.normal();
    fill_targets(n, weighted, rng);
  }

  LossInput input() const {
    return {.view = &view,
            .raster = &raster,
            .prediction_srgb = prediction,
            .target_srgb = target,
            .weight = weight,
            .diffuse = &layer,
            .targets = {specular, transparent, object, ignore, normals, confidence},
            .reflection = spans(reflection),
            .transmission = spans(transmission)};
  }
  LossGradient gradient() {
    return {.raster = &grad_raster,
            .prediction_srgb = grad_prediction,
            .diffuse = &grad_layer,
            .reflection_first_hit = reflection.grad,
            .transmission_first_hit = transmission.grad};
  }

 private:
  static LossRays spans(const Rays& r) { return {r.first_hit, r.mean_distance, r.alpha, r.wall, r.weight}; }

  // Masks with hard and soft values; unknown normals; rays that met nothing. Kinks of the losses are kept at a distance.
  void fill_targets(size_t n, bool weighted, Rng& rng) {
    for (auto* mask : {&specular, &transparent, &object})
      for (size_t i = 0; i < n; ++i) mask->push_back(std::clamp(2 * rng.uniform() - 0.5f, 0.f, 1.f));
    for (size_t i = 0; i < n; ++i) {
      const float k = rng.uniform();
      raster.plane(Aov::SpecularWeight)[i] = std::abs(k - 0.3f) < 0.02f ? 0.35f : k;
      raster.plane(Aov::Transmission)[i] = rng.uniform();
    }
    normals.assign(3 * n, 0.f);
    for (size_t i = 0; i < n; ++i) {
      if (rng.uniform() < 0.2f) continue;  // unknown
      Vec3f blended{}, v{};
      for (size_t c = 0; c < 3; ++c) blended[c] = raster.plane(Aov::Normal)[c * n + i];
      const Vec3f seen = normalized(cast<float>(view.cam_from_world.rotation) * blended);
      do v = normalized(Vec3f{0.4f * rng.normal(), 0.4f * rng.normal(), -1.f});
      while (std::min({std::abs(v[0] - seen[0]), std::abs(v[1] - seen[1]), std::abs(v[2] - seen[2])}) < 0.01f);
      for (size_t c = 0; c < 3; ++c) normals[c * n + i] = v[c];
    }
    if (weighted)
      for (size_t i = 0; i < n; ++i) {
        ignore.push_back(rng.uniform() < 0.5f ? 0.f : rng.uniform());
        confidence.push_back(rng.uniform());
      }
    for (Rays* rays : {&reflection, &transmission})
      for (size_t i = 0; i < 60; ++i) {
        const bool hit = rng.uniform() > 0.1f;
        const float wall = rays == &transmission ? 1 + rng.uniform() : 0.f, edge = wall + (wall > 0 ? 0.01f : 0.02f);
        float t = hit ? std::max(0.005f, wall + 0.1f * (rng.uniform() - 0.4f)) : 0.f;
        if (hit && std::abs(t - edge) < 2e-3f) t = edge + 5e-3f;
        rays->first_hit.push_back(t);
        rays->mean_distance.push_back(t + 0.05f * (rng.uniform() + 0.1f));
        rays->alpha.push_back(hit ? rng.uniform() : 0.f);
        if (rays == &transmission) rays->wall.push_back(wall);
        if (weighted) rays->weight.push_back(5 * rng.uniform());
        rays->grad.push_back(0.f);
      }
  }
};

struct Agreement {
  double worst = 0, norm = 0;
};

// Central differences of `loss` with respect to every value of `values`, against `gradient`. `worst` is relative to the
// largest gradient.
inline Agreement check(Loss& loss, TestFrame& frame, std::span<float> values, std::span<const float> gradient, float h) {
  Agreement agreement;
  double largest = 0, difference = 0;
  TestFrame scratch = frame;
  for (size_t i = 0; i < values.size(); ++i) {
    const float kept = values[i];
    LossGradient ignored = scratch.gradient();
    values[i] = kept + h;
    const float high = values[i];
    const double up = loss.evaluate(frame.input(), 0, ignored);
    values[i] = kept - h;
    const double down = loss.evaluate(frame.input(), 0, ignored), step = double(high) - double(values[i]);
    values[i] = kept;
    largest = std::max(largest, std::abs(double(gradient[i])));
    difference = std::max(difference, std::abs((up - down) / step - gradient[i]));
    agreement.norm += double(gradient[i]) * gradient[i];
  }
  agreement.worst = largest > 0 ? difference / largest : difference;
  return agreement;
}

inline std::unique_ptr<Loss> make(std::string_view name) {
  for (const LossFactory& f : loss_registry())
    if (f.name == name) return f.make();
  return nullptr;
}

}  // namespace vitrine
