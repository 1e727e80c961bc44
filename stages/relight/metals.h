// The colour of polished metal. Training gives a mirror a grey weight k_s, and leaves the metal's tint to the diffuse colours and
// to what the reflection layer shows; under another light the mirror would turn silver. What tells the tint are the photos: a
// metal shows the light of the mirrored direction times its reflectance, per channel,
//   C_c = F0_c L_c     F0_c ~ sum over the metal's pixels of w C_c  /  sum of w L_c,    L: the scene along mirrored rays
// Sums, not ratios of pixels: normals of mirrors are poor, so that a single ray misses what its pixel shows. For the same reason
// only the ratio of the channels is taken; how much is reflected stays as trained. w = (trained reflection)^4: the margins of
// masks and handles reflect little. A metal is a connected part of the specular mask, without glass, that learnt to reflect;
// little evidence: no tint.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "core/camera/view.h"
#include "core/light/environment.h"
#include "core/model/kernels/layer_blend.h"
#include "core/picture/trained_scene.h"

namespace vitrine {

struct MetalsDesc {
  const std::filesystem::path& sfm_folder;
  const TrainedScene& scene;
  const std::vector<View>& views;
  const Environment& environment;  // of the photos: what mirrored rays see beyond all surfels
  // At the given size, above 1/2 on mirrors and metal that are not glass; empty: none there.
  std::function<ImageF(const View&, const Intrinsics&)> mirrors;
  int max_side = 320;   // pixels
  float cell = 0.02f;   // scene units: surfaces this near are connected
  float reach = 0.02f;  // nothing nearer to the metal is seen in it
};

struct Metal {
  Vec3f tint{};        // of the reflection; its luminance is 1
  size_t pixels = 0;   // that told it, over all views
  float reflects = 0;  // mean share of reflection that was trained there
};

struct Metals {
  std::vector<Metal> metals;
  std::vector<int> of_surfel;  // index, or -1
};

Metals find_metals(const MetalsDesc& desc);

// The same luminance of reflection head on, in the colour of the tint. Surfels that hardly reflect stay as they are.
void tint_reflection(LayerBlend blend, const Vec3f& tint, float& specular_weight, Vec3f& f0);

}  // namespace vitrine
