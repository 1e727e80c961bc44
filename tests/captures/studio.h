// A painted room with boxes in it, photographed from anywhere: albedo with a little shading, no light transport. Enough for
// structure from motion, and a tenth of a second a photo.
#pragma once

#include <functional>
#include <memory>

#include "core/foundation/base/parallel.h"
#include "core/foundation/math/color.h"
#include "core/scene/camera/equirect.h"
#include "core/scene/image/ldr.h"
#include "sample_data/generate/ray_scene.h"

namespace vitrine::test {

struct StudioDesc {
  uint32_t seed = 1;
  bool plain = false;    // everything in one grey
  bool mirrors = false;  // the boxes are replaced by polished bodies that fill the view
};

class Studio {
 public:
  explicit Studio(const StudioDesc& desc) : desc_(desc) {
    using namespace generate;
    constexpr float kHalf = 2, kHeight = 2.5f;
    const Vec3f a{-kHalf, -kHalf, 0}, b{kHalf, -kHalf, 0}, c{kHalf, kHalf, 0}, d{-kHalf, kHalf, 0}, up{0, 0, kHeight};
    add(rectangle(a, b - a, d - a, 1), speckles(0));
    add(rectangle(b, a - b, up, 1), speckles(1));
    add(rectangle(c, b - c, up, 1), speckles(2));
    add(rectangle(d, c - d, up, 1), speckles(3));
    add(rectangle(a, d - a, up, 1), speckles(4));
    if (desc.mirrors) {
      const DistanceFunction blob = [](const Vec3f& p) {
        const float wave = 0.05f * std::sin(9 * p.x) * std::sin(8 * p.y) * std::sin(7 * p.z);
        return ellipsoid_distance(p, {0, 0, 0.6f}, {0.75f, 0.65f, 0.6f}) + wave;
      };
      scene_.parts.push_back({.name = "blob",
                              .shape = meshed(blob, {{-0.95, -0.85, -0.15}, {0.95, 0.85, 1.35}}, 0.03f),
                              .material = {.kind = MaterialKind::Mirror, .reflectance = {0.95f, 0.95f, 0.95f}}});
    } else {
      add(turned_box({-0.3f, 0.1f, 0.2f}, {0.4f, 0.4f, 0.4f}, 0.5f, 1), speckles(5));
      add(turned_box({0.35f, -0.3f, 0.12f}, {0.5f, 0.3f, 0.24f}, -0.3f, 1), speckles(6));
      add(turned_box({0.2f, 0.4f, 0.3f}, {0.25f, 0.25f, 0.6f}, 0.1f, 1), speckles(7));
    }
    rays_ = std::make_unique<RayScene>(scene_);
  }

  ImageF linear(const View& view) const {
    const Intrinsics& k = view.intrinsics;
    return picture(k.width, k.height, inverse(view.cam_from_world), [&](double x, double y) { return normalized(k.ray(x, y)); });
  }
  // All directions; the middle of the picture looks along the camera's +z.
  ImageF panorama(const Rigid& cam_from_world, int width) const {
    return picture(width, width / 2, inverse(cam_from_world),
                   [&](double x, double y) { return equirect_direction(x, y, width, width / 2); });
  }

 private:
  template <class Ray>
  ImageF picture(int width, int height, const Rigid& world_from_cam, Ray&& ray) const {
    constexpr int kSamples = 2;
    ImageF image(width, height, 3, 0.0f);
    parallel_for(size_t(image.height()), 4, [&](size_t row) {
      for (int x = 0; x < image.width(); ++x)
        for (int s = 0; s < kSamples * kSamples; ++s) {
          const double px = x + (s % kSamples + 0.5) / kSamples, py = double(row) + (s / kSamples + 0.5) / kSamples;
          const Vec3f c = seen(cast<float>(world_from_cam.translation), cast<float>(world_from_cam.rotation * ray(px, py)));
          for (int k = 0; k < 3; ++k) image.at(x, int(row), k) += c[size_t(k)] / (kSamples * kSamples);
        }
    });
    return image;
  }
  generate::Texture speckles(uint32_t n) const {
    if (desc_.plain) return grey();
    return [seed = desc_.seed * 16 + n](const generate::SurfacePoint& s) {
      const generate::CellNoise cell = generate::cell_noise(16.0f * s.position, seed);
      const float v = generate::unit_float(cell.cell), w = generate::unit_float(cell.cell * 0x9e3779b1u);
      return cell.second - cell.nearest < 0.06f ? Vec3f{0.05f, 0.05f, 0.05f} : Vec3f{0.1f + 0.8f * v, 0.1f + 0.8f * w, 0.5f};
    };
  }
  static generate::Texture grey() {
    return [](const generate::SurfacePoint&) { return Vec3f{0.4f, 0.4f, 0.4f}; };
  }
  void add(generate::Shape shape, generate::Texture albedo) {
    scene_.parts.push_back({.name = "part", .shape = std::move(shape), .material = {.albedo = std::move(albedo)}});
  }
  Vec3f seen(Vec3f origin, Vec3f direction) const {
    const Vec3f light = normalized(Vec3f{0.3f, 0.5f, 0.8f});
    Vec3f weight{1, 1, 1};
    for (int bounce = 0; bounce < 4; ++bounce) {
      const auto hit = rays_->first_hit(origin, direction);
      if (!hit) return weight.x * Vec3f{0.5f, 0.55f, 0.6f};
      if (hit->part->material.kind != generate::MaterialKind::Mirror) {
        const float shade = 0.6f + 0.4f * std::max(0.0f, dot(hit->normal, light));
        return weight.x * shade * hit->part->material.albedo({hit->position, hit->normal, hit->uv});
      }
      direction = direction - 2 * dot(direction, hit->normal) * hit->normal;
      origin = generate::offset_origin(*hit, direction);
      weight = hit->part->material.reflectance.x * weight;
    }
    return {};
  }

  StudioDesc desc_;
  generate::Scene scene_;
  std::unique_ptr<generate::RayScene> rays_;
};

}  // namespace vitrine::test
