// Per-photo training targets from earlier stages, at the sizes of the training pyramid: pixels of glass, mirrors and coats
// (labels of objects), the object mask and ignore mask, and normals. Layouts: stages/objects, masks, normals.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/camera/mask_class.h"
#include "core/learn/loss/loss.h"
#include "core/scene/objects/object_labels.h"
#include "core/learn/trainer/capture.h"

namespace vitrine {

// Empty vectors: no data for this photo. Transparent: glass. Specular: glass and mirrors of known shape.
struct TargetLevel {
  std::array<std::vector<uint8_t>, kMaskClassCount> masks;  // [h,w], 255 = belongs to the class
  std::vector<uint8_t> coat;                                // [h,w] paint under a coat; mirrors without a known shape
  std::vector<int16_t> normals;                             // [3,h,w], 32767 = 1; 0 0 0 = unknown
  std::vector<uint8_t> confidence;                          // [h,w]
  bool operator==(const TargetLevel&) const = default;
};

struct TargetProblem {
  std::string code, text;
};

struct Targets {
  std::vector<std::array<TargetLevel, kLevels>> photos;  // in the order of Capture::photos
  std::array<bool, kMaskClassCount> has{};               // at least one photo contains the class
  bool has_normals = false;
  size_t memory_bytes = 0;
  std::vector<TargetProblem> warnings;

  void forget(MaskClass mask);
  // Sets the weight outside the object masks of `trained` to zero. Photos without such a mask are unchanged.
  void ignore_outside(const Targets& trained);
  bool any(MaskClass mask) const { return has[static_cast<size_t>(mask)]; }
};

// `masks`: of the classes object and ignore. Throws Error{Input} if masks match no photo or have the wrong size, or normals are
// invalid.
Targets load_targets(const Capture& capture, const std::optional<std::filesystem::path>& masks, const LabelledObjects& objects,
                     const std::optional<std::filesystem::path>& normals);

// One level, converted for the losses.
struct TargetImages {
  std::array<std::vector<float>, kMaskClassCount> masks;  // [h,w]
  std::vector<float> coat, normals, confidence;
  LossTargets spans() const;
  std::span<const float> mask(MaskClass m) const { return masks[static_cast<size_t>(m)]; }
};
void decode(const TargetLevel& level, TargetImages& images);

}  // namespace vitrine
