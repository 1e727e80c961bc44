// What colours the numbers of a photo stand for, by what its file says. This is the one place that decides it. The first of these
// that can be used:
//   JPEG   ICC profile (APP2); EXIF ColorSpace and InteroperabilityIndex
//   PNG    cICP, iCCP, sRGB, gAMA with cHRM; EXIF
//   TIFF   ICC profile (tag 34675); floating-point samples are linear; EXIF
//   EXR    linear; chromaticities
// else sRGB. The difference between "sRGB, as the file says" and "sRGB, since it says nothing" stays in `source`.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/image/color_profile.h"
#include "core/scene/image/probe.h"
#include "core/intake/photos/exif.h"

namespace vitrine {

struct PhotoColor {
  ColorProfilePtr profile = srgb_profile();
  std::string source = "assumed sRGB";  // "icc", "exif ColorSpace", "png cICP", "chromaticities", "float linear", ...
  std::string problem;                  // why what the file says could not be used, or what it leaves open; sRGB is assumed then
  std::string refusal;                  // why the photo cannot be used: colours of print
};

// `bytes` is the whole file.
PhotoColor color_of(std::string_view bytes, const Probe& probe, const Exif& exif);
// Whether a file of this format says that it has an alpha channel.
bool has_alpha(std::string_view bytes, PhotoFormat format);

// What a person should know of the colours of a set of photos.
struct ColorNote {
  std::string finding;       // of inspect: "mixed_profiles"
  std::string warning_code;  // of ingest: "PHOTO_PROFILES_DIFFER"; empty: nothing to warn of
  std::string what, why, hint;
  std::vector<size_t> photos;  // indices
};
struct ColorFacts {
  std::string profile, source, problem;  // of PhotoColor; the profile by its name
  bool rec709_primaries = true;
  bool alpha = false;  // an alpha channel that is not the same everywhere
};
ColorFacts color_facts(const PhotoColor& color, bool varying_alpha);
// Photos that were left out are nullptr.
std::vector<ColorNote> color_notes(std::span<const ColorFacts* const> photos);
// "12 photos Display P3 -> linear Rec. 709"; empty when all are sRGB.
std::string colors_text(std::span<const ColorFacts* const> photos);

}  // namespace vitrine
