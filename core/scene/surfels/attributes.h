// Table of per-surfel attributes, one row each. Storage, gradients, optimiser groups, densification, file input and output,
// raster channels and export are derived from the row. To add an attribute, add a row and use it in the pass that reads it. All
// three layers share the table; `layers` lists the layers that own the attribute.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace vitrine {

enum class LayerKind : unsigned char { Diffuse, Reflection, Transmittance };
inline constexpr std::array<LayerKind, 3> kAllLayers{LayerKind::Diffuse, LayerKind::Reflection, LayerKind::Transmittance};
constexpr std::string_view name(LayerKind kind) {
  constexpr std::string_view names[] = {"diffuse", "reflection", "transmittance"};
  return names[static_cast<size_t>(kind)];
}

enum class Activation : unsigned char { Identity, Exp, Sigmoid, Normalize };

enum class Attribute : unsigned char {
  Mean,
  Rotation,
  LogScale,
  Opacity,
  ShDc,
  ShRest,
  F0,
  Roughness,
  SpecularWeight,
  Transmission
};

struct AttributeRow {
  Attribute id;
  std::string_view name;  // also the prefix of its PLY properties
  int width;              // floats per surfel; ShRest: at degree 3, fewer for lower degrees
  unsigned layers;        // bit 0 diffuse, 1 reflection, 2 transmittance
  Activation activation;
  float initial;  // activated value of a new surfel without a better estimate
  float rate;     // Adam learning rate of the raw value (mean: times the scene radius)
};

inline constexpr unsigned kInAll = 0b111, kInDiffuse = 0b001;
inline constexpr size_t kAttributeCount = 10;
// Rates are two to ten times those of Kerbl et al. 2023 ("3D Gaussian Splatting"; opacity: the same), because runs are five
// times shorter (2k-6k steps). Initial materials: a diffuse dielectric (f0 .04).
inline constexpr std::array<AttributeRow, kAttributeCount> kAttributes{{
    {Attribute::Mean, "mean", 3, kInAll, Activation::Identity, 0.f, 1.6e-3f},
    {Attribute::Rotation, "rotation", 4, kInAll, Activation::Normalize, 0.f, 4e-3f},
    {Attribute::LogScale, "log_scale", 2, kInAll, Activation::Exp, 0.01f, 1e-2f},
    {Attribute::Opacity, "opacity", 1, kInAll, Activation::Sigmoid, 0.1f, 5e-2f},
    {Attribute::ShDc, "sh_dc", 3, kInAll, Activation::Identity, 0.f, 1e-2f},
    {Attribute::ShRest, "sh_rest", 45, kInAll, Activation::Identity, 0.f, 2.5e-4f},
    {Attribute::F0, "f0", 3, kInDiffuse, Activation::Sigmoid, 0.04f, 2e-2f},
    {Attribute::Roughness, "roughness", 1, kInDiffuse, Activation::Sigmoid, 0.3f, 1e-2f},
    {Attribute::SpecularWeight, "specular_weight", 1, kInDiffuse, Activation::Sigmoid, 0.02f, 2e-2f},
    {Attribute::Transmission, "transmission", 1, kInDiffuse, Activation::Sigmoid, 0.02f, 2e-2f},
}};
static_assert(
    [] {
      for (size_t i = 0; i < kAttributeCount; ++i)
        if (static_cast<size_t>(kAttributes[i].id) != i) return false;
      return true;
    }(),
    "rows stand in the order of the enum");

constexpr const AttributeRow& row(Attribute a) { return kAttributes[static_cast<size_t>(a)]; }
constexpr bool has_attribute(LayerKind layer, Attribute a) { return (row(a).layers >> static_cast<unsigned>(layer)) & 1u; }

}  // namespace vitrine
