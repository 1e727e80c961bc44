// Determines the colour space of a photo from its file. All other code uses this result. The first usable source:
//   JPEG   ICC profile (APP2); EXIF ColorSpace and InteroperabilityIndex
//   PNG    cICP, iCCP, sRGB, gAMA with cHRM; EXIF
//   TIFF   ICC profile (tag 34675); floating-point samples are linear; EXIF
//   EXR    linear; chromaticities
//   HEIF   ICC profile; code points ('nclx'); EXIF
//   raw    linear Rec. 709, as developed (core/intake/photos/raw_photo.h)
// else sRGB. `source` distinguishes declared sRGB from assumed sRGB.
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
  std::string problem;                  // why the file's colour data is unusable or ambiguous; sRGB is assumed then
  std::string refusal;                  // why the photo cannot be used: CMYK and other print colours
};

// `bytes`: the whole file.
PhotoColor color_of(std::string_view bytes, const Probe& probe, const Exif& exif);
// Whether a file of this format declares an alpha channel.
bool has_alpha(std::string_view bytes, PhotoFormat format);

// Message to the user about the colours of a set of photos.
struct ColorNote {
  std::string finding;       // of inspect: "mixed_profiles"
  std::string warning_code;  // of ingest: "PHOTO_PROFILES_DIFFER"; empty: no warning
  std::string what, why, hint;
  std::vector<size_t> photos;  // indices
};
struct ColorFacts {
  std::string profile, source, problem;  // of PhotoColor; the profile by name
  bool rec709_primaries = true;
  bool alpha = false;  // has an alpha channel that is not constant
};
ColorFacts color_facts(const PhotoColor& color, bool varying_alpha);
// nullptr for photos that were left out.
std::vector<ColorNote> color_notes(std::span<const ColorFacts* const> photos);
// "12 photos Display P3 -> linear Rec. 709"; empty when all are sRGB.
std::string colors_text(std::span<const ColorFacts* const> photos);

}  // namespace vitrine
