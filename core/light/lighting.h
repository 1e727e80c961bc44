// Everything that shines on a scene: an environment from far away, and lamps in it, in the scene's frame and units.
//
//   lights:                              # a YAML file; rgb may also be one number
//     - {type: point, position: [0, 0, 2], intensity: [4, 4, 3]}            irradiance at distance 1
//     - {type: directional, from: [1, 1, 2], irradiance: 2}                 of a surface that faces it
//     - {type: rectangle, center: [1, 0, 2], facing: [-1, 0, -2], size: [0.5, 0.3], radiance: 20}
//     - {type: disc, center: [0, 0, 2], facing: [0, 0, -1], radius: 0.2, radiance: [20, 18, 15]}
//
// Rectangles and discs shine from their front only; a rectangle's height points upwards as far as it can.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "core/light/environment.h"

namespace vitrine {

struct PointLight {
  Vec3f position{}, intensity{};
};
struct DirectionalLight {
  Vec3f towards{};  // unit, from the surface to the light
  Vec3f irradiance{};
};
struct AreaLight {
  Vec3f center{}, normal{};  // unit
  Vec3f half_u{}, half_v{};  // half edges, or radii of a disc
  Vec3f radiance{};
  bool disc = false;

  float area() const;
  Vec3f point(const Vec2f& uniform) const;  // evenly over the area
  // Distance along a ray that meets the front.
  std::optional<float> hit(const Vec3f& origin, const Vec3f& direction) const;
};

// Light of one lamp at a point. What it adds to the irradiance of a surface: radiance x cosine / pdf.
struct LampSample {
  Vec3f direction{};  // unit, towards the lamp
  float distance = 0;
  Vec3f radiance{};
  float pdf = 0;  // per steradian; 0: no light; of a point or a direction: 1
};

struct Lighting {
  Environment environment;
  std::vector<PointLight> points;
  std::vector<DirectionalLight> directionals;
  std::vector<AreaLight> areas;

  // Points first, then directionals, then areas. The first sharp_lamps() throw sharp shadows: one sample says all.
  size_t lamps() const { return points.size() + directionals.size() + areas.size(); }
  size_t sharp_lamps() const { return points.size() + directionals.size(); }
  LampSample sample_lamp(size_t lamp, const Vec3f& point, const Vec2f& uniform) const;

  static constexpr float kFar = 1e30f;
};

// Adds the lamps of a file. Throws Error{Usage} with line and column, Error{Input} when there is no such file.
void read_lamps(const std::filesystem::path& path, Lighting& lighting);
void parse_lamps(std::string_view text, const std::string& name, Lighting& lighting);

}  // namespace vitrine
