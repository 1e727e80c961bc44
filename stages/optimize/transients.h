// Transient content: what one photo shows and the other photos contradict, such as a visitor who walks through a photo. A short
// training with one opaque layer gives a picture and a depth of every photo. Pixels are transient if
//   - the photo differs from the picture, and also from what the other photos show at the same surface points,
//   - the other photos agree with their own pictures there: reflections, thin parts and occlusion edges differ in every photo,
//   - they form a solid region.
// They become ignore masks of the training. (Residuals as evidence: Martin-Brualla et al., NeRF in the Wild, CVPR 2021; Sabour et
// al., RobustNeRF, CVPR 2023.)
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "core/learn/trainer/targets.h"
#include "stages/optimize/trainer.h"

namespace vitrine {

inline constexpr size_t kFewestForTransients = 8;  // training photos

// One photo with its picture by the short training, both [3,h,w] display-referred with the gain of the photo.
struct TransientPhoto {
  View view;
  std::vector<float> photo, picture;
  std::vector<float> zdepth;      // [h,w] of the picture; 0: unknown
  std::vector<uint8_t> excluded;  // [h,w] 1: glass, mirrors, coats; empty: none
};

// [h,w] Residuals of one photo, display-referred, means over the channels and over 3x3 pixels.
struct TransientEvidence {
  std::vector<float> residual;  // the smaller of those against the picture and against the other photos; 0: too few see the pixel
  std::vector<float> elsewhere;  // median residual of the other photos at the same surface points
};
std::vector<TransientEvidence> transient_evidence(std::span<const TransientPhoto> photos);

// [h,w] 255: transient. Empty: no pixel is. `excluded` pixels are no evidence, but belong to a region that reaches into them.
std::vector<uint8_t> transient_regions(const TransientEvidence& evidence, std::span<const uint8_t> excluded, int width,
                                       int height);

// Settings of the short training; `scout` has the defaults.
void configure_scout(const OptimizeConfig& config, const Capture& capture, OptimizeConfig& scout);

struct Transients {
  size_t level = 0;                         // of the photos' pyramids
  std::vector<std::vector<uint8_t>> masks;  // [capture.photos][h,w]; empty: nothing found
  size_t photos = 0;                        // with a mask
  double share = 0;                         // of the pixels of these photos
};
Transients found_transients(const Trainer& scout, const Capture& capture, const Targets& targets);

// Adds the masks to the ignore masks of the training.
void ignore_transients(const Transients& transients, Targets& targets, const Capture& capture);
// masks/ignore/*.png at photo size and contact_sheet.png in `folder`, of the photos with a mask.
void write_transients(const std::filesystem::path& folder, const Transients& transients, const Capture& capture);

}  // namespace vitrine
