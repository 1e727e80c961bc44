#include "sample_data/generate/capture.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/scene/image/ldr.h"

namespace vitrine::generate {
namespace {

constexpr int kMetalFactor = 4;
constexpr float kContentSeen = 0.95f;

float tent(float u) { return u < 0.5f ? std::sqrt(2.0f * u) - 1.0f : 1.0f - std::sqrt(2.0f - 2.0f * u); }

struct Ray {
  Vec3f origin, direction;
  double per_zdepth;  // ray distance over z-depth
};

Ray camera_ray(const View& view, const Rigid& world_from_cam, double px, double py) {
  const Vec3d in_cam = view.intrinsics.ray(px, py);
  return {cast<float>(world_from_cam.translation), cast<float>(normalized(world_from_cam.rotation * in_cam)), length(in_cam)};
}

}  // namespace

ImageF rendered(const Integrator& integrator, const IrradianceCache* cache, int width, int height, int samples, uint64_t key,
                const RayOfPixel& ray_of) {
  ImageF picture(width, height, 3);
  parallel_for(picture.pixel_count(), 64, [&](size_t index) {
    const int x = static_cast<int>(index % static_cast<size_t>(picture.width()));
    const int y = static_cast<int>(index / static_cast<size_t>(picture.width()));
    // Blurred reflections of the sun are what is left of the noise: metal gets more samples.
    const CameraRay middle = ray_of(x + 0.5, y + 0.5);
    const std::optional<Hit> hit = integrator.rays().first_hit(middle.origin, middle.direction, false);
    const int count = hit && hit->part->material.kind == MaterialKind::Metal ? kMetalFactor * samples : samples;
    Vec3f sum{};
    for (int s = 0; s < count; ++s) {
      Sampler sampler(mix64(key, index), static_cast<uint32_t>(s));
      const Vec2f u = sampler.pair();
      const CameraRay ray = ray_of(x + 0.5 + static_cast<double>(tent(u.x)), y + 0.5 + static_cast<double>(tent(u.y)));
      sum += integrator.radiance(ray.origin, ray.direction, cache, sampler);
    }
    for (int c = 0; c < 3; ++c) picture.at(x, y, c) = sum[static_cast<size_t>(c)] / static_cast<float>(count);
  });
  return picture;
}

ImageF rendered(const Integrator& integrator, const IrradianceCache* cache, const View& view, int samples, uint64_t key) {
  const Rigid world_from_cam = inverse(view.cam_from_world);
  return rendered(integrator, cache, view.intrinsics.width, view.intrinsics.height, samples, key, [&](double x, double y) {
    const Ray ray = camera_ray(view, world_from_cam, x, y);
    return CameraRay{ray.origin, ray.direction};
  });
}

SurfacePictures first_surface(const RayScene& rays, const View& view) {
  const int w = view.intrinsics.width, h = view.intrinsics.height;
  const Rigid world_from_cam = inverse(view.cam_from_world);
  SurfacePictures out{ImageF(w, h, 1), ImageF(w, h, 3), ImageF(w, h, 3), Image8(w, h, 1),
                      Image8(w, h, 1), Image8(w, h, 1), Image8(w, h, 1), Image8(w, h, 1)};
  parallel_for(static_cast<size_t>(h), 4, [&](size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < w; ++x) {
      const Ray ray = camera_ray(view, world_from_cam, x + 0.5, y + 0.5);
      const std::optional<Hit> first = rays.first_hit(ray.origin, ray.direction);
      out.content.at(x, y) = rays.content_transmittance(ray.origin, ray.direction) < kContentSeen ? 255 : 0;
      if (!first) continue;
      out.zdepth.at(x, y) = static_cast<float>(static_cast<double>(first->distance) / ray.per_zdepth);
      const Vec3f n = dot(first->normal, ray.direction) > 0 ? -first->normal : first->normal;
      for (int c = 0; c < 3; ++c) out.normal.at(x, y, c) = n[static_cast<size_t>(c)];
      const Material& material = first->part->material;
      out.object.at(x, y) = first->part->object ? 255 : 0;
      out.transparent.at(x, y) = first->glass() ? 255 : 0;
      out.specular.at(x, y) = material.glossy() ? 255 : 0;
      out.coated.at(x, y) = material.kind == MaterialKind::Coat ? 255 : 0;
      const std::optional<Hit> solid = first->glass() ? rays.first_hit(ray.origin, ray.direction, false) : first;
      if (!solid || !solid->part->material.painted()) continue;
      const Vec3f albedo = solid->part->material.albedo({solid->position, solid->normal, solid->uv});
      for (int c = 0; c < 3; ++c) out.albedo.at(x, y, c) = albedo[static_cast<size_t>(c)];
    }
  });
  return out;
}

Image8 developed(const ImageF& radiance, const Vec3d& gain, const SensorDesc& sensor, uint64_t key) {
  ImageF noisy = radiance;
  const Vec3f factor = cast<float>(gain);
  parallel_for(noisy.data().size(), 4096, [&](size_t i) {
    Rng rng(key, i);
    const float signal = std::clamp(factor[i % 3] * noisy.data()[i], 0.0f, 1.0f);
    noisy.data()[i] = signal + std::sqrt(sensor.shot_noise * signal + sensor.read_noise * sensor.read_noise) * rng.normal();
  });
  return srgb8_from_linear(noisy);
}

}  // namespace vitrine::generate
