// Small sets of surfels and rays that each provoke one thing. Tests are products of these and of tracers.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "core/render/trace/tracer.h"
#include "tests/support/tiny_scenes.h"

namespace vitrine {

struct RayScene {
  std::string name;
  SplatLayer layer{LayerKind::Reflection, 3, 0};
  std::vector<Vec3f> origins, directions;
  std::vector<float> near, far;
  TraceDesc desc;

  RayBatch rays() const { return {origins, directions, near, far}; }
  void add_ray(const Vec3d& origin, const Vec3d& direction) {
    origins.push_back(cast<float>(origin));
    directions.push_back(cast<float>(normalized(direction)));
  }
};

struct RaySceneSurfel {
  Vec3d mean;
  Vec3d normal{0, 0, 1};
  double su = 0.2, sv = 0.2, opacity = 0.6;
};

inline void add_surfel(RayScene& scene, const RaySceneSurfel& s, uint64_t seed) {
  Rng rng(seed, 78);
  const size_t i = scene.layer.size();
  scene.layer.resize(i + 1);
  const Vec3d n = normalized(s.normal), helper{rng.normal(), rng.normal(), rng.normal()};
  const Vec3d u = normalized(helper - dot(helper, n) * n);
  const Quatd q = quaternion(Mat3d{u, cross(n, u), n});
  const double length = 0.7 + rng.uniform_double(), quat[] = {q.w, q.x, q.y, q.z};  // raw quaternions are not unit
  for (size_t c = 0; c < 3; ++c) scene.layer.at(Attribute::Mean, i)[c] = static_cast<float>(s.mean[c]);
  for (size_t c = 0; c < 4; ++c) scene.layer.at(Attribute::Rotation, i)[c] = static_cast<float>(length * quat[c]);
  scene.layer.at(Attribute::LogScale, i)[0] = static_cast<float>(std::log(s.su));
  scene.layer.at(Attribute::LogScale, i)[1] = static_cast<float>(std::log(s.sv));
  *scene.layer.at(Attribute::Opacity, i) = static_cast<float>(logit(s.opacity));
  for (size_t c = 0; c < 3; ++c) scene.layer.at(Attribute::ShDc, i)[c] = rng.normal();
  for (size_t c = 0; c < scene.layer.width(Attribute::ShRest); ++c) scene.layer.at(Attribute::ShRest, i)[c] = 0.2f * rng.normal();
}

inline Vec3d random_vector(Rng& rng) { return {double(rng.normal()), double(rng.normal()), double(rng.normal())}; }
inline Vec3d random_in_cube(Rng& rng) {
  return {2 * rng.uniform_double() - 1, 2 * rng.uniform_double() - 1, 2 * rng.uniform_double() - 1};
}

// Surfels of any orientation in [-1,1]^3, rays of any direction through it.
inline RayScene ray_cloud(const std::string& name, size_t surfels, size_t rays, double size, double opacity, uint64_t seed) {
  RayScene s;
  s.name = name;
  Rng rng(seed);
  for (size_t i = 0; i < surfels; ++i)
    add_surfel(s,
               {.mean = random_in_cube(rng),
                .normal = random_vector(rng),
                .su = size * (0.3 + rng.uniform_double()),
                .sv = size * (0.3 + rng.uniform_double()),
                .opacity = opacity * (0.2 + 0.8 * rng.uniform_double())},
               seed + i);
  for (size_t i = 0; i < rays; ++i) s.add_ray(0.7 * random_in_cube(rng), random_vector(rng));
  return s;
}

inline std::vector<RayScene> ray_scenes() {
  std::vector<RayScene> all;
  const auto rays_along_z = [](RayScene& s, size_t count) {
    Rng rng(5);
    for (size_t i = 0; i < count; ++i)
      s.add_ray({0.15 * rng.normal(), 0.15 * rng.normal(), -1}, {0.1 * rng.normal(), 0.1 * rng.normal(), 1});
  };
  const auto scene = [&](const std::string& name, const std::vector<RaySceneSurfel>& surfels) -> RayScene& {
    all.emplace_back();
    all.back().name = name;
    for (size_t i = 0; i < surfels.size(); ++i) add_surfel(all.back(), surfels[i], i + 1);
    rays_along_z(all.back(), 40);
    return all.back();
  };
  scene("one", {{.mean = {0.05, -0.02, 0.5}, .normal = {0.3, 0.2, 1}, .su = 0.3, .sv = 0.15}});
  scene("two_overlapping", {{.mean = {0.05, 0, 0.8}, .normal = {0.1, 0, -1}}, {.mean = {-0.05, 0, 0.4}, .normal = {0, 0.4, 1}}});
  scene("intersecting", {{.mean = {0, 0, 0.5}, .normal = {0.8, 0, 1}, .su = 0.4, .sv = 0.4},
                         {.mean = {0.01, 0.02, 0.5}, .normal = {-0.7, 0.1, 1}, .su = 0.4}});
  scene("grazing", {{.mean = {0, 0, 0.5}, .normal = {1, 0, 0.02}, .su = 0.5, .sv = 0.5}, {.mean = {0, 0, 0.9}}});
  scene("behind_the_origin", {{.mean = {0, 0, -1.5}}, {.mean = {0, 0, 0.4}}});
  scene("clamped", {{.mean = {0, 0, 0.3}, .su = 0.3, .sv = 0.3, .opacity = 0.9995}, {.mean = {0.05, 0, 0.6}, .su = 0.4}});
  {
    RayScene& s = scene("near_and_far", {{.mean = {0, 0, -0.4}}, {.mean = {0, 0, 0.3}}, {.mean = {0, 0, 0.9}}});
    s.near.assign(s.origins.size(), 0.8f);
    s.far.assign(s.origins.size(), 1.7f);
  }
  {
    all.emplace_back();
    all.back().name = "opaque_stack";
    for (int i = 0; i < 20; ++i)
      add_surfel(
          all.back(),
          {.mean = {0.01 * i - 0.1, 0.05, 0.05 * i}, .normal = {0.1 * i - 0.5, 0.2, 1}, .su = 0.4, .sv = 0.5, .opacity = 0.9},
          uint64_t(i));
    rays_along_z(all.back(), 40);
  }
  all.push_back(ray_cloud("cloud", 80, 60, 0.25, 0.9, 9));
  all.push_back(ray_cloud("sh_degree_one", 40, 40, 0.3, 0.7, 10));
  all.back().desc.sh_degree = 1;
  return all;
}

// Upstream gradients of every output, the same for every tracer.
inline RayValues random_gradients(size_t rays, uint64_t seed) {
  RayValues g;
  g.resize(rays);
  Rng rng(seed);
  for (size_t i = 0; i < rays; ++i) {
    g.color[i] = {rng.normal(), rng.normal(), rng.normal()};
    g.transmittance[i] = rng.normal();
    g.distance[i] = rng.normal();
    g.first_hit[i] = rng.normal();
    g.normal[i] = {rng.normal(), rng.normal(), rng.normal()};
  }
  return g;
}

struct TracePass {
  RayValues values;
  HitLists hits;
  SplatLayer grad;
  RayGradients rays;
  SurfelStatistics statistics;
};

inline TracePass run(Tracer& tracer, const RayScene& scene) {
  TracePass p;
  tracer.build(scene.layer);
  tracer.forward(scene.rays(), scene.desc, p.values, &p.hits);
  const RayValues g = random_gradients(scene.origins.size(), 3);
  std::vector<float> error(scene.origins.size());
  Rng rng(4);
  for (float& v : error) v = rng.uniform();
  p.grad = scene.layer.zeros_like();
  tracer.backward(scene.rays(), scene.desc, p.hits, {.gradients = &g, .error = error}, p.grad, &p.rays, &p.statistics);
  return p;
}

inline std::vector<float> flat(const std::vector<Vec3f>& v) {
  std::vector<float> out;
  for (const Vec3f& p : v) out.insert(out.end(), {p.x, p.y, p.z});
  return out;
}

}  // namespace vitrine
