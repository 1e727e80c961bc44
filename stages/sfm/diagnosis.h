// Diagnosis of a capture without a usable model: cause, figures and remedy. Throws Error{SfmFailed}, exit code 4.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "stages/sfm/reconstruct.h"

namespace vitrine {

struct SfmConfig;

// Test for a purely rotating camera. Two photos from one position are related by H = K R K^-1, for any scene. A plane seen from
// two positions also gives a homography, but then K^-1 H K is not a rotation.
//
// Returns the share of the verified pairs that one focal length (the best of a range) explains as rotations. Identical views (no
// rotation) do not count. Assumes a centred principal point and photos of one size.
double rotation_share(std::span<const VerifiedPair> pairs, int width, int height);

// Reason why this photo is not in the model: "few features (37)", "no photo matches it", ...; empty when it is registered.
std::string reason_left_out(const PhotoReport& photo);
// Code of that reason: too_few_features, motion_blur, mixed_exposure, split_models, reflections_dominate, no_overlap; empty when
// the photo is registered, or when poses were given.
std::string cause_left_out(const PhotoReport& photo, const Reconstruction& r);
struct Diagnosis {
  std::string code, message, why, hint;
};
// Empty `code`: the model is good enough.
Diagnosis diagnosed(const Reconstruction& r, const SfmConfig& config);
// `where`: path of the report for the user.
[[noreturn]] void throw_diagnosis(const Diagnosis& d, const std::filesystem::path& where);

}  // namespace vitrine
