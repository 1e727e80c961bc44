// What earlier stages say about the pixels of each photo, at the sizes of its training pyramid: masks of glass, gloss, object
// and of what is to be ignored, and monocular normals. Layouts: stages/masks and stages/normals.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/camera/mask_files.h"
#include "core/loss/loss.h"
#include "core/train/capture.h"

namespace vitrine {

// Empty vectors: nobody said anything about this photo.
struct TargetLevel {
  std::array<std::vector<uint8_t>, kMaskClassCount> masks;  // [h,w], 255 = belongs to the class
  std::vector<uint8_t> coat;                                // [h,w] of the specular mask, from which it was taken
  std::vector<int16_t> normals;                             // [3,h,w], 32767 = 1; 0 0 0 = unknown
  std::vector<uint8_t> confidence;                          // [h,w]
  bool operator==(const TargetLevel&) const = default;
};

struct TargetProblem {
  std::string code, text;
};

struct Targets {
  std::vector<std::array<TargetLevel, kLevels>> photos;  // in the order of Capture::photos
  std::array<bool, kMaskClassCount> has{};               // some photo has some of the class
  std::array<bool, kMaskClassCount> guessed{};           // proposed by the masks stage itself, which is not sure
  std::array<bool, kMaskClassCount> propagated{};        // from few marks or none, edges may be off by pixels
  bool has_normals = false;
  size_t memory_bytes = 0;
  std::vector<TargetProblem> warnings;

  void forget(MaskClass mask);
  // What lies outside the object masks of `trained` weighs nothing from here on. A photo without such a mask stays as it is.
  void ignore_outside(const Targets& trained);
  bool any(MaskClass mask) const { return has[static_cast<size_t>(mask)]; }
  bool vouched(MaskClass mask) const { return any(mask) && !guessed[static_cast<size_t>(mask)]; }
};

// Throws Error{Input} when masks match no photo or have another size than theirs, or normals are no normals.
Targets load_targets(const Capture& capture, const std::optional<std::filesystem::path>& masks,
                     const std::optional<std::filesystem::path>& normals);

// One level as the losses want it.
struct TargetImages {
  std::array<std::vector<float>, kMaskClassCount> masks;  // [h,w]
  std::vector<float> coat, normals, confidence;
  LossTargets spans() const;
  std::span<const float> mask(MaskClass m) const { return masks[static_cast<size_t>(m)]; }
};
void decode(const TargetLevel& level, TargetImages& images);

}  // namespace vitrine
