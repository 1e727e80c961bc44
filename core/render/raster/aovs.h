// Output channels of a raster pass (arbitrary output variables): one row each; channel offsets are derived from the table.
// Blended features (sum of w_i f_i) come first, geometric channels (computed per fragment) after them.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "core/scene/surfels/attributes.h"

namespace vitrine {

enum class Aov : unsigned char { Color, Normal, F0, Roughness, SpecularWeight, Transmission, ZDepth, Alpha, MedianZ, Distortion };

struct AovRow {
  Aov id;
  std::string_view name;
  int width;
  bool feature;  // constant over a surfel's fragments: blended by the inner loop
};

inline constexpr size_t kAovCount = 10;
inline constexpr std::array<AovRow, kAovCount> kAovs{{
    {Aov::Color, "color", 3, true},    // linear radiance, SH evaluated along the view direction
    {Aov::Normal, "normal", 3, true},  // world space, faces the camera, not normalised
    {Aov::F0, "f0", 3, true},
    {Aov::Roughness, "roughness", 1, true},
    {Aov::SpecularWeight, "specular_weight", 1, true},
    {Aov::Transmission, "transmission", 1, true},
    {Aov::ZDepth, "zdepth", 1, false},          // sum of w_i z_i: divide by alpha for the mean depth
    {Aov::Alpha, "alpha", 1, false},            // 1 - final transmittance
    {Aov::MedianZ, "median_z", 1, false},       // z where the transmittance falls below one half
    {Aov::Distortion, "distortion", 1, false},  // depth distortion (kernels/blend.h), per pixel
}};
constexpr const AovRow& row(Aov a) { return kAovs[static_cast<size_t>(a)]; }

// Channels that a pass produces: the whole table, or only the first features (an opaque scene has no materials to blend).
enum class FeatureSet : unsigned char { ColorOnly = 3, Surface = 6, Material = 12 };  // value = number of feature channels
constexpr size_t feature_count(FeatureSet s) { return static_cast<size_t>(s); }

}  // namespace vitrine
