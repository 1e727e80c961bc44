// Lighting of a scene: an environment map and lamps, in the frame and units of the scene.
//
//   lights:                              # a YAML file; rgb may also be one number
//     - {type: point, position: [0, 0, 2], intensity: [4, 4, 3]}            irradiance at distance 1
//     - {type: directional, from: [1, 1, 2], irradiance: 2}                 of a surface that faces it
//     - {type: rectangle, center: [1, 0, 2], facing: [-1, 0, -2], size: [0.5, 0.3], radiance: 20}
//     - {type: disc, center: [0, 0, 2], facing: [0, 0, -1], radius: 0.2, radiance: [20, 18, 15]}
//
// Rectangles and discs emit from their front side only; the height axis of a rectangle points upwards as far as possible.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/light/environment.h"

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
  Vec3f half_u{}, half_v{};  // half edges; radii of a disc
  Vec3f radiance{};
  bool disc = false;

  float area() const;
  Vec3f point(const Vec2f& uniform) const;  // uniform over the area
  // Distance along the ray to the front side.
  std::optional<float> hit(const Vec3f& origin, const Vec3f& direction) const;
};

// Sample of the light of one lamp at a point. Contribution to the irradiance of a surface: radiance x cosine / pdf.
struct LampSample {
  Vec3f direction{};  // unit, towards the lamp
  float distance = 0;
  Vec3f radiance{};
  float pdf = 0;  // per steradian; 0: no light; 1 for point and directional lamps
};

struct Lighting {
  Environment environment;
  std::vector<PointLight> points;
  std::vector<DirectionalLight> directionals;
  std::vector<AreaLight> areas;

  std::vector<std::string> places = {};  // of each lamp in its file: "lamps.yaml:3:5"; empty for lamps that no file gives

  // Order: points, directionals, areas. The first sharp_lamps() cast hard shadows: one sample is exact.
  size_t lamps() const { return points.size() + directionals.size() + areas.size(); }
  size_t sharp_lamps() const { return points.size() + directionals.size(); }
  LampSample sample_lamp(size_t lamp, const Vec3f& point, const Vec2f& uniform) const;

  // Reason why the lamp lights none of the points: it is black, or they all lie behind it. Empty: it lights some of them, unless
  // they are in shadow.
  std::string idle_reason(size_t lamp, std::span<const Vec3f> points) const;

  static constexpr float kFar = 1e30f;
};

// Adds the lamps of a file. Throws Error{Usage} with line and column, also for a file without lamps; Error{Input} if the file
// does not exist.
void read_lamps(const std::filesystem::path& path, Lighting& lighting);
void parse_lamps(std::string_view text, const std::string& name, Lighting& lighting);

}  // namespace vitrine
