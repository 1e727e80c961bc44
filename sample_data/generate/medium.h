// Homogeneous water or haze between the camera and the first surface of a path (glass counts), on exact ray distances z:
//   I = J exp(-b_D z) + B (1 - exp(-b_B z))      per channel; J = radiance in air (Akkaynak and Treibitz 2018)
// Light that reaches the surfaces is that of the scene in air, and reflected rays cross no medium.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "core/foundation/math/vec.h"

namespace vitrine::generate {

struct Medium {
  std::string name;
  Vec3f direct, backscatter;  // b_D, b_B in 1/m
  Vec3f veil;                 // B, linear radiance of the medium at infinite distance
  // `distance` in metres; infinite where the ray meets nothing.
  Vec3f seen(const Vec3f& radiance, float distance) const;
};

// coastal, deep, green: three waters; haze: one grey coefficient.
std::span<const Medium> medium_list();
// Throws Error{Usage} for an unknown name.
Medium medium_named(const std::string& name);

// truth/medium.json: "medium" (name), "direct_per_m", "backscatter_per_m", "veil" (three numbers each).
void write_medium(const std::filesystem::path& path, const Medium& medium);

}  // namespace vitrine::generate
