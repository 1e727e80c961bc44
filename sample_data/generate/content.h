// What a body of glass is filled with: cloudy liquid, jelly or smoke that absorbs and emits, without scattering. Density is that
// of the body plus a sum of 3D Gaussians (core/render/volume/gaussian3.h); light along a ray within the body is
//   the integral of colour(t) density(t) exp(-optical depth before t) dt, with the mean colour by density.
// Glow of the content lights the scene by way of diffuse bounces, and shadow rays are weakened.
#pragma once

#include <filesystem>
#include <vector>

#include "core/render/volume/kernels/profile.h"

namespace vitrine::generate {

struct Scene;

class GlassContent {
 public:
  struct Cloud {
    Gaussian3f gaussian;  // metres, 1/m
    Vec3f color;          // linear radiance where it is opaque
  };
  GlassContent(float density, const Vec3f& color, std::vector<Cloud> clouds);

  float density() const { return density_; }  // everywhere, 1/m
  const Vec3f& color() const { return color_; }
  const std::vector<Cloud>& clouds() const { return clouds_; }

  // After p -> scale turned(p) + by; `turn` (radians) about the vertical axis. Optical depths stay.
  GlassContent moved(const Vec3f& by, float turn, float scale) const;

  // Over `distance` metres from `origin`; `direction` has unit length.
  VolumeLightf light(const Vec3f& origin, const Vec3f& direction, float distance) const;
  float transmittance(const Vec3f& origin, const Vec3f& direction, float distance) const;

 private:
  float density_;
  Vec3f color_;
  std::vector<Cloud> clouds_;
  std::vector<Whitened<float>> whitened_;
};

// truth/content.json: a list of the filled parts: "part", "bounds" (its lowest and highest corner), "index_of_refraction" (1:
// rays go straight through a thin wall), "density_per_m", "color" and "clouds" ("mean", "deviations" in metres, "rotation" w x y
// z, "density_per_m" at the mean, "color"). Nothing where no part is filled.
void write_content(const std::filesystem::path& path, const Scene& scene);

}  // namespace vitrine::generate
