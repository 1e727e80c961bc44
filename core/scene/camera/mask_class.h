// Mask classes: object, glass, specular, ignore.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace vitrine {

enum class MaskClass : unsigned char { Object, Transparent, Specular, Ignore };
inline constexpr size_t kMaskClassCount = 4;
inline constexpr std::array<MaskClass, kMaskClassCount> kMaskClasses{MaskClass::Object, MaskClass::Transparent,
                                                                     MaskClass::Specular, MaskClass::Ignore};

inline constexpr std::array<std::string_view, kMaskClassCount> kMaskClassWords{"object", "transparent", "specular", "ignore"};
inline std::string_view name(MaskClass kind) { return kMaskClassWords[static_cast<size_t>(kind)]; }

// By lower-case name.
inline std::optional<MaskClass> mask_class(std::string_view word) {
  for (MaskClass kind : kMaskClasses)
    if (word == name(kind)) return kind;
  return std::nullopt;
}

}  // namespace vitrine
