// Raw and projected values of one surfel in a wide scalar (double, or Dual in the gradient tests).
#pragma once

#include <array>

#include "core/render/raster/kernels/project.h"
#include "core/render/raster/kernels/shade.h"
#include "core/render/raster/kernels/splat_weight.h"
#include "core/render/raster/raster_desc.h"
#include "core/scene/surfels/activation.h"
#include "core/scene/surfels/layers.h"

namespace vitrine::reference {

template <class T>
struct SurfelValues {  // raw values, or their gradients
  SurfelGeometry<T> geometry{};
  T opacity{};
  std::array<T, 3 * kMaxShCoefficients> sh{};
  std::array<T, kMaterialWidth> material{};  // f0 rgb, roughness, specular weight, transmission
};

inline constexpr std::array<Attribute, 4> kMaterialAttributes{Attribute::F0, Attribute::Roughness, Attribute::SpecularWeight,
                                                              Attribute::Transmission};

// Calls visit(scalar of `values`, attribute, component) for every raw value that `layer` stores per surfel.
template <class T, class Visit>
void visit_values(const SplatLayer& layer, SurfelValues<T>& values, Visit visit) {
  SurfelGeometry<T>& g = values.geometry;
  for (size_t c = 0; c < 3; ++c) visit(g.mean[c], Attribute::Mean, c);
  T* quaternion[] = {&g.rotation.w, &g.rotation.x, &g.rotation.y, &g.rotation.z};
  for (size_t c = 0; c < 4; ++c) visit(*quaternion[c], Attribute::Rotation, c);
  visit(g.log_su, Attribute::LogScale, size_t{0});
  visit(g.log_sv, Attribute::LogScale, size_t{1});
  visit(values.opacity, Attribute::Opacity, size_t{0});
  for (size_t c = 0; c < 3; ++c) visit(values.sh[c], Attribute::ShDc, c);
  for (size_t c = 0; c < layer.width(Attribute::ShRest); ++c) visit(values.sh[3 + c], Attribute::ShRest, c);
  size_t m = 0;
  for (Attribute a : kMaterialAttributes)
    for (size_t c = 0; c < layer.width(a); ++c) visit(values.material[m++], a, c);
}

template <class T>
struct ScreenSurfel {
  Projection<T> projection{};
  SplatConstants<T> constants{};
  ShColour<T> colour{};
  std::array<T, kMaxFeatures> features{};
  bool visible = false;
};

template <class T>
struct SceneCamera {
  Camera<T> camera{};
  T near_z{}, far_z{};
  T low_pass{};
  int sh_degree = 0;
  size_t features = 0;
};

template <class T>
SceneCamera<T> scene_camera(const RasterDesc& desc, const SplatLayer& layer) {
  const Intrinsics& k = desc.intrinsics;
  const Vec3d eye = inverse(desc.cam_from_world).translation;
  SceneCamera<T> s;
  s.camera = {
      T(k.fx),     T(k.fy), T(k.cx), T(k.cy), cast<T>(desc.cam_from_world.rotation), cast<T>(desc.cam_from_world.translation),
      cast<T>(eye)};
  s.near_z = T(desc.near_z);
  s.far_z = T(desc.far_z);
  s.low_pass = T(desc.low_pass ? kLowPassInvVariance : kNoLowPass);
  s.sh_degree = std::min(desc.sh_degree, layer.sh_degree());
  s.features = feature_count(desc.features);
  return s;
}

template <class T>
ScreenSurfel<T> screen_surfel(const SurfelValues<T>& s, const SceneCamera<T>& view) {
  ScreenSurfel<T> out;
  out.projection = project(s.geometry, view.camera);
  const T opacity = sigmoid(s.opacity);
  out.constants = {out.projection.map, opacity, view.near_z / out.projection.map.z0, view.low_pass};
  out.visible = is_visible(out.projection, opacity, view.near_z);
  out.colour = sh_colour(view.sh_degree, s.geometry.mean, view.camera.eye, s.sh.data());
  for (size_t c = 0; c < 3; ++c) {
    out.features[kColourAt + c] = out.colour.value[c];
    out.features[kNormalAt + c] = out.projection.normal[c];
  }
  for (size_t c = 0; c < kMaterialWidth; ++c) out.features[kMaterialAt + c] = sigmoid(s.material[c]);
  return out;
}

// Reverse of screen_surfel for the sums over pixels. Returns the gradient of the raw values.
template <class T>
SurfelValues<T> screen_surfel_vjp(const SurfelValues<T>& s, const SceneCamera<T>& view, const ScreenSurfel<T>& screen,
                                  const SplatMoments<T>& moments, const std::array<T, kMaxFeatures>& grad_features,
                                  Vec2<T>& screen_gradient) {
  SurfelValues<T> g;
  const SplatGrad<T> splat = splat_grad(moments, screen.projection.map, screen.constants.opacity);
  const Vec3<T> grad_colour{grad_features[0], grad_features[1], grad_features[2]};
  const Vec3<T> grad_normal{grad_features[3], grad_features[4], grad_features[5]};
  const ProjectionGrad<T> p = project_vjp(s.geometry, view.camera, screen.projection, splat.map, grad_normal);
  g.geometry = p.surfel;
  g.geometry.mean += sh_colour_vjp(view.sh_degree, screen.colour, s.sh.data(), grad_colour, g.sh.data());
  g.opacity = splat.raw_opacity;
  for (size_t c = 0; c < kMaterialWidth; ++c) {
    const T a = screen.features[kMaterialAt + c];
    g.material[c] = grad_features[kMaterialAt + c] * a * (T(1) - a);
  }
  screen_gradient = {p.screen_x, p.screen_y};
  return g;
}

}  // namespace vitrine::reference
