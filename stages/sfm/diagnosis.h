// Says why a capture has no usable model, with the figures that show it and what to try: Error{SfmFailed}, exit code 4.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "stages/sfm/reconstruct.h"

namespace vitrine {

struct SfmConfig;

// Did the camera only turn? Two photos from one place are related by H = K R K^-1, whatever they show. A plane seen from two
// places has a homography, too, but K^-1 H K is then no rotation.
//
// Of the verified pairs, the share that one focal length explains as rotations (the best one of a range is taken). Photos that
// show the same without a turn do not count. Principal point in the middle; all photos of one size.
double rotation_share(std::span<const VerifiedPair> pairs, int width, int height);

// Why this photo is not in the model: "few features (37)", "no photo matches it", ...; empty when it is registered.
std::string reason_left_out(const PhotoReport& photo);
// The same in a word: too_few_features, motion_blur, mixed_exposure, split_models, reflections_dominate, no_overlap; empty when
// it is registered, or when poses were given.
std::string cause_left_out(const PhotoReport& photo, const Reconstruction& r);
struct Diagnosis {
  std::string code, message, why, hint;
};
// An empty `code`: the model is good enough.
Diagnosis diagnosed(const Reconstruction& r, const SfmConfig& config);
// `where`: the report that was left for the reader.
[[noreturn]] void throw_diagnosis(const Diagnosis& d, const std::filesystem::path& where);

}  // namespace vitrine
