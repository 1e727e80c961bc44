// What the readers and the writer of transforms.json and of camera paths share. For *.cpp files of this module only.
#pragma once

#include "core/camera/json_file.h"
#include "core/math/rigid.h"

namespace vitrine {

inline constexpr const char* kTransformsFormat = "transforms.json";

// The upper three rows of a 4x4 (or 3x4) matrix. For use inside read_json_file.
Similarity similarity_of(const JsonAt& rows);

}  // namespace vitrine
