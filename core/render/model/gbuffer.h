// Per-pixel access to the channels of the diffuse pass, as inputs of the shading kernels.
#pragma once

#include "core/render/model/frame.h"
#include "core/render/model/kernels/layer_blend.h"
#include "core/render/model/kernels/surface_point.h"

namespace vitrine {

class GBuffer {
 public:
  int width, height;
  size_t pixels;
  std::span<const float> color, normal, f0, roughness, specular, transmission, zdepth, alpha;

  explicit GBuffer(const Frame& frame)
      : width(frame.view->intrinsics.width),
        height(frame.view->intrinsics.height),
        pixels(frame.pixel_count()),
        color(frame.diffuse.plane(Aov::Color)),
        normal(frame.diffuse.plane(Aov::Normal)),
        f0(frame.diffuse.plane(Aov::F0)),
        roughness(frame.diffuse.plane(Aov::Roughness)),
        specular(frame.diffuse.plane(Aov::SpecularWeight)),
        transmission(frame.diffuse.plane(Aov::Transmission)),
        zdepth(frame.diffuse.plane(Aov::ZDepth)),
        alpha(frame.diffuse.plane(Aov::Alpha)),
        coats_(frame.coats),
        sheets_(frame.sheets) {
    const Intrinsics& k = frame.view->intrinsics;
    const Mat3d& r = frame.view->cam_from_world.rotation;
    eye_ = cast<float>(frame.view->centre_in_world());
    per_x_ = cast<float>(transposed_times(r, Vec3d{1 / k.fx, 0, 0}));
    per_y_ = cast<float>(transposed_times(r, Vec3d{0, 1 / k.fy, 0}));
    corner_ = cast<float>(transposed_times(r, k.ray(0.5, 0.5)));
  }

  Vec3f rgb(std::span<const float> plane, uint32_t pixel) const {
    return {plane[pixel], plane[pixels + pixel], plane[2 * pixels + pixel]};
  }
  PixelRay<float> ray(uint32_t pixel) const {
    const auto w = static_cast<uint32_t>(width);
    const Vec3f d = corner_ + float(pixel % w) * per_x_ + float(pixel / w) * per_y_;
    return {eye_, d, -normalized(d)};
  }
  // Ray with an offset from the pixel centre, in pixels to the right and down.
  PixelRay<float> ray(uint32_t pixel, float across, float down) const {
    const Vec3f d = ray(pixel).direction_per_z + across * per_x_ + down * per_y_;
    return {eye_, d, -normalized(d)};
  }
  // Normal of the reflecting surface, times alpha: on a coat the normal of its shape.
  Vec3f surface_normal(uint32_t pixel) const {
    return coats_.of_shape(pixel) ? alpha[pixel] * rgb(coats_.normal, pixel) : rgb(normal, pixel);
  }
  PixelSums<float> sums(uint32_t pixel) const {
    const float z = coats_.of_shape(pixel) ? alpha[pixel] * coats_.z[pixel] : zdepth[pixel];
    return {surface_normal(pixel), rgb(f0, pixel), roughness[pixel], z, alpha[pixel]};
  }
  // The normal must face the camera: otherwise neither reflection nor transmission is defined.
  bool has_surface(uint32_t pixel) const {
    const Vec3f n = surface_normal(pixel);
    const float l = length(n);
    return l > kShortestNormal && dot(n, ray(pixel).view) > float(kMinCosine) * l;
  }
  // Blend inputs of any pixel.
  BlendMaterial<float> material(uint32_t pixel) const {
    const Vec3f n = surface_normal(pixel);
    return {(1.f / alpha[pixel]) * rgb(f0, pixel),
            specular[pixel],
            transmission[pixel],
            dot(normalized(n), ray(pixel).view),
            normal_agreement(n, alpha[pixel]),
            coats_.shows(pixel),
            sheets_.shows_solid(pixel)};
  }

 private:
  static constexpr float kShortestNormal = 0.05f;  // opposite normals that cancel leave no direction
  const CoatImages& coats_;
  const SheetImages& sheets_;
  Vec3f eye_, per_x_, per_y_, corner_;
};

}  // namespace vitrine
