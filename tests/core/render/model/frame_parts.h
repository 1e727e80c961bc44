// What a part of a frame is, for tests of what passes declare: its values and gradients as bytes, and how a frame forgets it.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "core/render/model/pass.h"

namespace vitrine::test {

inline std::vector<FramePart> all_parts() {
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
    for (const auto* values : {&r.near, &r.mean_distance, &r.alpha, &r.weight, &r.inner_transmittance}) add(*values);
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

inline std::string values_of(const Frame& frame, FramePart part) {
  // All members: a new one must become part of one of the parts below, or an input.
  const auto& [view, options, specular_mask, transparent_mask, seed, step, differentiable, diffuse, shaded, reflection,
               transmission, sheets, panes, silhouette, coats, opened, behind, linear, clear, srgb, layers, grad_diffuse,
               grad_linear, grad_srgb, error_image, statistics] = frame;
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
      b.add(coats.entry), b.add(coats.normal), b.add(coats.z);
      break;
    case FramePart::Sheets:
      b.add(sheets.entry), b.add(sheets.element);
      for (const auto* values : {&sheets.coverage, &sheets.behind_alpha, &sheets.behind_median}) b.add(*values);
      break;
    case FramePart::Surfaces:
      for (const auto* values : {&shaded.pixels, &shaded.begin, &shaded.chosen}) b.add(*values);
      b.add(shaded.rays), b.add(shaded.points);
      break;
    case FramePart::ReflectionRequests:
      for (const LayersPresent& request : shaded.requests) b.number(request.reflection);
      break;
    case FramePart::TransmissionRequests:
      for (const LayersPresent& request : shaded.requests) b.number(request.transmission);
      break;
    case FramePart::OpenedScene:
      b.add(opened.surfels), b.add(opened.opaque);
      break;
    case FramePart::BehindGlass:
      for (const auto* values : {&behind.radiance, &behind.inner_transmittance, &behind.median_z}) b.add(*values);
      b.add(behind.path);
      break;
    case FramePart::Panes:
      b.add(panes.shown), b.add(panes.passes_gradient);
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
    case FramePart::Clear:
      b.add(clear);
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
inline std::string gradients_of(const Frame& frame, FramePart part) {
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
      break;  // no gradient
  }
  return b.take();
}

inline std::string content(const Frame& frame, FramePart part) { return values_of(frame, part) + gradients_of(frame, part); }

// As before any pass.
inline void forget(FramePart part, Frame& frame) {
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
      empty.requests = std::move(frame.shaded.requests);
      frame.shaded = std::move(empty);
      break;
    }
    case FramePart::ReflectionRequests:
      for (LayersPresent& request : frame.shaded.requests) request.reflection = false;
      break;
    case FramePart::TransmissionRequests:
      for (LayersPresent& request : frame.shaded.requests) request.transmission = false;
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
    case FramePart::Clear:
      drop(frame.clear);
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

}  // namespace vitrine::test
