// Small scenes that each provoke one thing. Tests are products of these and of renderers.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/foundation/base/rng.h"
#include "core/render/raster/raster_desc.h"
#include "core/scene/surfels/activation.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

struct TinyScene {
  std::string name;
  SplatLayer layer{LayerKind::Diffuse, 3, 0};
  RasterDesc desc;
};

struct TinySurfel {
  Vec3d mean;                       // in the camera's frame
  double angle_x = 0, angle_y = 0;  // tilt away from facing the camera, radians
  double su = 0.2, sv = 0.2, opacity = 0.6;
};

// Random colours, materials and twist, from `seed`.
inline void add_surfel(TinyScene& scene, const TinySurfel& s, uint64_t seed) {
  Rng rng(seed, 77);
  const size_t i = scene.layer.size();
  scene.layer.resize(i + 1);
  const Rigid world_from_cam = inverse(scene.desc.cam_from_world);
  const Vec3d mean = world_from_cam * s.mean;
  const double twist = rng.uniform_double() * 3, cx = std::cos(s.angle_x), sx = std::sin(s.angle_x), cy = std::cos(s.angle_y),
               sy = std::sin(s.angle_y), ct = std::cos(twist), st = std::sin(twist);
  const Mat3d around_x{{1, 0, 0}, {0, cx, sx}, {0, -sx, cx}}, around_y{{cy, 0, -sy}, {0, 1, 0}, {sy, 0, cy}},
      around_z{{ct, st, 0}, {-st, ct, 0}, {0, 0, 1}};
  const Quatd q = quaternion(world_from_cam.rotation * (around_y * (around_x * around_z)));
  for (size_t c = 0; c < 3; ++c) scene.layer.at(Attribute::Mean, i)[c] = static_cast<float>(mean[c]);
  const double length = 0.7 + rng.uniform_double();  // raw quaternions are not unit
  const double quat[] = {q.w, q.x, q.y, q.z};
  for (size_t c = 0; c < 4; ++c) scene.layer.at(Attribute::Rotation, i)[c] = static_cast<float>(length * quat[c]);
  scene.layer.at(Attribute::LogScale, i)[0] = static_cast<float>(std::log(s.su));
  scene.layer.at(Attribute::LogScale, i)[1] = static_cast<float>(std::log(s.sv));
  scene.layer.at(Attribute::Opacity, i)[0] = static_cast<float>(logit(s.opacity));
  for (size_t c = 0; c < 3; ++c) scene.layer.at(Attribute::ShDc, i)[c] = rng.normal();
  for (size_t c = 0; c < scene.layer.width(Attribute::ShRest); ++c) scene.layer.at(Attribute::ShRest, i)[c] = 0.2f * rng.normal();
  for (Attribute a : {Attribute::F0, Attribute::Roughness, Attribute::SpecularWeight, Attribute::Transmission})
    for (size_t c = 0; c < scene.layer.width(a); ++c) scene.layer.at(a, i)[c] = rng.normal();
}

inline TinyScene empty_scene(const std::string& name, int width = 37, int height = 29) {
  TinyScene s;
  s.name = name;
  const double angle = 0.3;
  s.desc.intrinsics = {width, height, 40, 42, 0.5 * width, 0.5 * height};
  s.desc.cam_from_world = {Mat3d{{std::cos(angle), 0, -std::sin(angle)}, {0, 1, 0}, {std::sin(angle), 0, std::cos(angle)}},
                           {0.1, -0.2, 0.3}};
  s.desc.features = FeatureSet::Material;
  s.desc.background = {0.2f, 0.5f, 0.1f};
  s.desc.near_z = 0.2f;
  s.desc.distortion = true;
  return s;
}

// `count` surfels at random before the camera.
inline TinyScene cloud_scene(const std::string& name, size_t count, int width, int height, double size, double opacity,
                             uint64_t seed) {
  TinyScene s = empty_scene(name, width, height);
  Rng rng(seed);
  const Intrinsics& k = s.desc.intrinsics;
  for (size_t i = 0; i < count; ++i) {
    const double z = 1.5 + 2 * rng.uniform_double();
    const double x = (rng.uniform_double() * width - k.cx) / k.fx * z, y = (rng.uniform_double() * height - k.cy) / k.fy * z;
    add_surfel(s,
               {.mean = {x, y, z},
                .angle_x = 1.2 * (rng.uniform_double() - 0.5) * 2,
                .angle_y = 1.2 * (rng.uniform_double() - 0.5) * 2,
                .su = size * (0.3 + rng.uniform_double()),
                .sv = size * (0.3 + rng.uniform_double()),
                .opacity = opacity * (0.4 + 0.6 * rng.uniform_double())},
               seed + i);
  }
  return s;
}

inline std::vector<TinyScene> tiny_scenes() {
  std::vector<TinyScene> all;
  const auto scene = [&](const std::string& name, const std::vector<TinySurfel>& surfels) -> TinyScene& {
    all.push_back(empty_scene(name));
    for (size_t i = 0; i < surfels.size(); ++i) add_surfel(all.back(), surfels[i], i + 1);
    return all.back();
  };
  scene("one", {{.mean = {0.1, -0.1, 2}, .angle_x = 0.5, .angle_y = -0.7, .su = 0.3, .sv = 0.15}});
  scene("two_overlapping",
        {{.mean = {0.05, 0, 2.5}, .angle_x = 0.3, .su = 0.3}, {.mean = {-0.1, 0.05, 2}, .angle_y = -0.4, .sv = 0.35}});
  scene("intersecting", {{.mean = {0, 0, 2}, .angle_y = 0.9, .su = 0.4, .sv = 0.4},
                         {.mean = {0.02, 0.01, 2.01}, .angle_y = -0.8, .su = 0.4, .sv = 0.35}});
  scene("edge_on", {{.mean = {0.013, 0.007, 2}, .angle_y = 1.56, .su = 0.3, .sv = 0.3}, {.mean = {0.1, 0.1, 2.3}, .su = 0.3}});
  scene("exactly_edge_on",
        {{.mean = {0.013, 0.007, 2}, .angle_y = 1.5707963267948966, .su = 0.3}, {.mean = {0.1, 0.1, 2.3}, .su = 0.3}});
  scene("behind_camera", {{.mean = {0, 0, -2}}, {.mean = {0, 0.1, 2.2}, .angle_x = 0.2}});
  scene("near_clipped", {{.mean = {0.05, 0.1, 0.5}, .angle_y = 1.1, .su = 0.6, .sv = 0.5, .opacity = 0.7},
                         {.mean = {0, 0, 2}, .su = 0.4, .sv = 0.4}});
  scene("tiny", {{.mean = {0.012, 0.03, 2}, .angle_x = 0.4, .su = 0.004, .sv = 0.006, .opacity = 0.8},
                 {.mean = {-0.2, 0.1, 2.4}, .su = 0.01, .sv = 0.2}});
  {
    all.push_back(empty_scene("opaque_stack"));
    for (uint64_t i = 0; i < 12; ++i) {
      const double x = double(i);
      add_surfel(all.back(),
                 {.mean = {0.03 * x - 0.15, 0.1 - 0.02 * x, 2 + 0.05 * x},
                  .angle_x = 0.1 * x - 0.5,
                  .su = 0.4,
                  .sv = 0.5,
                  .opacity = 0.97},
                 i);
    }
  }
  {
    TinyScene& s =
        scene("clamped", {{.mean = {0, 0, 2}, .su = 0.3, .sv = 0.3, .opacity = 0.9995}, {.mean = {0.1, 0, 2.4}, .su = 0.4}});
    s.desc.distortion = false;
  }
  {
    all.push_back(cloud_scene("off_centre", 20, 37, 29, 0.2, 0.8, 5));
    all.back().desc.intrinsics.cx += 11.3;
    all.back().desc.intrinsics.cy -= 7.1;
  }
  all.push_back(cloud_scene("cloud", 60, 45, 38, 0.15, 0.9, 9));
  all.push_back(cloud_scene("no_low_pass", 25, 37, 29, 0.25, 0.9, 11));
  all.back().desc.low_pass = false;
  return all;
}

}  // namespace vitrine
