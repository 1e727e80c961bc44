// Says why a capture has no usable model, with the figures that show it and what to try: Error{SfmFailed}, exit code 4.
#pragma once

#include <filesystem>
#include <string>

#include "stages/sfm/reconstruct.h"

namespace vitrine {

struct SfmConfig;

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
