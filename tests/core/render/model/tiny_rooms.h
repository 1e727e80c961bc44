// Two scenes in which everything is known: a tilted mirror with things in front of it, and a pane of glass with things behind.
// The surface is a sheet of large surfels that covers the whole picture, so that no pixel lies on an edge of what sends rays.
#pragma once

#include <cmath>

#include "core/foundation/base/rng.h"
#include "core/scene/camera/view.h"
#include "core/scene/surfels/activation.h"
#include "core/scene/surfels/splat_scene.h"

namespace vitrine {

struct LayeredRoom {
  SplatScene scene;
  View view;
  Vec3d point, normal;  // of the surface
};

struct RoomSurfel {
  Vec3d mean, normal{0, 0, 1};
  double size = 0.3, opacity = 0.7;
  Vec3d rgb{0.5, 0.5, 0.5};
};

inline size_t add_surfel(SplatLayer& layer, const RoomSurfel& s, uint64_t seed) {
  Rng rng(seed, 31);
  const size_t i = layer.size();
  layer.resize(i + 1);
  const Vec3d n = normalized(s.normal), helper = std::abs(n.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0};
  const Vec3d u = normalized(cross(helper, n));
  const Quatd q = quaternion(Mat3d{u, cross(n, u), n});
  const double rotation[] = {q.w, q.x, q.y, q.z};
  for (size_t c = 0; c < 4; ++c) layer.at(Attribute::Rotation, i)[c] = float(1.2 * rotation[c]);
  for (size_t c = 0; c < 3; ++c) {
    layer.at(Attribute::Mean, i)[c] = float(s.mean[c]);
    layer.at(Attribute::ShDc, i)[c] = float((s.rgb[c] - 0.5) / double(kShDc));
  }
  for (size_t c = 0; c < 2; ++c) layer.at(Attribute::LogScale, i)[c] = float(std::log(s.size)) + 0.1f * rng.normal();
  *layer.at(Attribute::Opacity, i) = float(logit(s.opacity));
  for (size_t c = 0; c < layer.width(Attribute::ShRest); ++c) layer.at(Attribute::ShRest, i)[c] = 0.1f * rng.normal();
  return i;
}

struct RoomMaterial {
  double f0 = 0.3, roughness = 0.4, specular = 0.5, transmission = 0.5;
};

// A sheet through (0,0,2) in front of a camera at the origin that looks along +z (turned a little), with its materials.
inline LayeredRoom room(const RoomMaterial& m, uint64_t seed, int width = 21, int height = 17) {
  LayeredRoom r;
  const double angle = 0.2, tilt = 0.5;
  r.view.intrinsics = {width, height, 30, 31, 0.5 * width + 0.3, 0.5 * height - 0.2};
  r.view.cam_from_world.rotation =
      Mat3d{{std::cos(angle), 0, -std::sin(angle)}, {0, 1, 0}, {std::sin(angle), 0, std::cos(angle)}};
  r.view.cam_from_world.translation = {0.1, 0.05, -0.1};
  r.view.gain = {0.9, 1.0, 1.1};
  const Rigid world_from_cam = inverse(r.view.cam_from_world);
  r.point = world_from_cam * Vec3d{0, 0, 2};
  r.normal = normalized(world_from_cam.rotation * Vec3d{std::sin(tilt), 0.1, -std::cos(tilt)});
  r.scene.diffuse = SplatLayer(LayerKind::Diffuse, 1, 0);
  r.scene.reflection = SplatLayer(LayerKind::Reflection, 1, 0);
  r.scene.transmittance = SplatLayer(LayerKind::Transmittance, 1, 0);
  Rng rng(seed, 17);
  for (uint64_t i = 0; i < 4; ++i) {
    const Vec3d shift{0.2 * rng.normal(), 0.2 * rng.normal(), 0};
    const size_t s = add_surfel(r.scene.diffuse,
                                {.mean = r.point + shift - (dot(shift, r.normal) + 0.12 * double(i)) * r.normal,
                                 .normal = r.normal + 0.02 * Vec3d{rng.normal(), rng.normal(), rng.normal()},
                                 .size = 3,
                                 .opacity = 0.8,
                                 .rgb = {rng.uniform(), rng.uniform(), rng.uniform()}},
                                seed + i);
    const auto around = [&](double mean) { return float(logit(mean)) + 0.2f * rng.normal(); };
    for (size_t c = 0; c < 3; ++c) r.scene.diffuse.at(Attribute::F0, s)[c] = around(m.f0);
    *r.scene.diffuse.at(Attribute::Roughness, s) = around(m.roughness);
    *r.scene.diffuse.at(Attribute::SpecularWeight, s) = around(m.specular);
    *r.scene.diffuse.at(Attribute::Transmission, s) = around(m.transmission);
  }
  return r;
}

// Surfels about `centre`, one behind the other along `axis`: nowhere do two of them change places, which would be a step in
// every picture.
inline void scatter(SplatLayer& layer, const Vec3d& centre, const Vec3d& axis, size_t count, uint64_t seed) {
  Rng rng(seed, 19);
  const auto gauss = [&] { return Vec3d{rng.normal(), rng.normal(), rng.normal()}; };
  for (size_t i = 0; i < count; ++i) {
    const Vec3d aside = 0.5 * gauss();
    add_surfel(layer,
               {.mean = centre + aside - dot(aside, axis) * axis + 0.3 * double(i) * axis,
                .normal = axis + 0.05 * gauss(),
                .size = 1.0,  // their edges, where they are cut at 1/255, lie outside the picture
                .opacity = 0.4 + 0.5 * rng.uniform_double(),
                .rgb = {rng.uniform(), rng.uniform(), rng.uniform()}},
               seed + i);
  }
}

// `x` seen in the mirror.
inline Vec3d mirrored(const LayeredRoom& r, const Vec3d& x) { return x - 2 * dot(x - r.point, r.normal) * r.normal; }

// Reflection and transmittance surfels on both sides: the former in front of the mirror where the camera sees them in it.
inline LayeredRoom furnished_room(const RoomMaterial& m, uint64_t seed, int width = 21, int height = 17) {
  LayeredRoom r = room(m, seed, width, height);
  const Rigid world_from_cam = inverse(r.view.cam_from_world);
  const Vec3d axis = world_from_cam.rotation * Vec3d{0, 0, 1}, in_mirror = axis - 2 * dot(axis, r.normal) * r.normal;
  scatter(r.scene.reflection, mirrored(r, world_from_cam * Vec3d{0, 0, 4}), in_mirror, 6, seed + 100);
  scatter(r.scene.transmittance, world_from_cam * Vec3d{0, 0, 4}, axis, 6, seed + 200);
  return r;
}

}  // namespace vitrine
