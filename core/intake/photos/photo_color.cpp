#include "core/intake/photos/photo_color.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <fmt/format.h>
#include <zlib.h>

#include "core/scene/image/color_profile.h"
#include "core/scene/image/heif_file.h"
#include "core/scene/image/segments.h"
#include "core/scene/image/tiff_pages.h"
#include "core/foundation/math/color.h"

namespace vitrine {

namespace {

constexpr size_t kLargestProfile = size_t(32) << 20;

// Bytes of an ICC profile, or why they are incomplete; both empty: no profile.
struct Embedded {
  std::string bytes, problem;
  bool grey_picture = false;
};

// Each segment of at most 64 kB stores its number, from 1, and the total count. Segments may be in any order.
Embedded jpeg_profile(std::string_view file, bool& four_channels) {
  constexpr std::string_view kName("ICC_PROFILE\0", 12);
  std::map<unsigned, std::string_view> parts;
  unsigned count = 0;
  Embedded out;
  jpeg_segments(file, [&](unsigned marker, std::string_view payload) {
    if (is_start_of_frame(marker)) {
      const uint64_t channels = number_at(payload, 5, 1, true);
      four_channels = channels == 4;
      out.grey_picture = channels == 1;
    }
    if (marker == 0xe2 && payload.starts_with(kName) && payload.size() >= kName.size() + 2) {
      parts.try_emplace(unsigned(number_at(payload, 12, 1, true)), payload.substr(14));
      count = std::max(count, unsigned(number_at(payload, 13, 1, true)));
    }
    return true;
  });
  if (parts.empty()) return out;
  const unsigned first = parts.begin()->first == 0 ? 0 : 1;  // some writers count from 0
  for (unsigned i = 0; i < count; ++i) {
    const auto part = parts.find(first + i);
    if (part == parts.end()) {
      out.bytes.clear();
      out.problem = fmt::format("part {} of the {} parts of its profile is missing", i + 1, count);
      return out;
    }
    out.bytes += part->second;
  }
  if (count == 0) out.problem = "its profile has no parts";
  return out;
}

Embedded inflated_profile(std::string_view chunk) {
  Embedded out;
  const size_t name = chunk.find('\0');
  if (name == std::string_view::npos || name + 2 > chunk.size()) {
    out.problem = "its iCCP chunk is damaged";
    return out;
  }
  const std::string_view packed = chunk.substr(name + 2);
  z_stream z{};
  if (inflateInit(&z) != Z_OK) return out;
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  z.avail_in = static_cast<uInt>(packed.size());
  char block[1 << 15];
  int status = Z_OK;
  while (status == Z_OK && out.bytes.size() <= kLargestProfile) {
    z.next_out = reinterpret_cast<Bytef*>(block);
    z.avail_out = sizeof block;
    status = inflate(&z, Z_NO_FLUSH);
    out.bytes.append(block, sizeof block - z.avail_out);
  }
  inflateEnd(&z);
  if (status != Z_STREAM_END) {
    out.bytes.clear();
    out.problem = "the compressed profile of its iCCP chunk is damaged";
  }
  return out;
}

// Uses the profile if valid. Returns whether the file has one.
bool take_icc(const Embedded& embedded, PhotoColor& color) {
  if (embedded.bytes.empty() && embedded.problem.empty()) return false;
  IccProfile icc;
  if (embedded.problem.empty()) icc = icc_profile(embedded.bytes);
  const std::string problem = embedded.problem.empty() ? icc.problem : embedded.problem;
  if (icc.cmyk) {
    color.refusal = fmt::format("its colours are those of print ({}): export it as RGB", problem);
  } else if (!icc.profile) {
    color.problem = "its colour profile cannot be used: " + problem;
  } else if (icc.grey && !embedded.grey_picture) {
    color.problem = fmt::format("its colour profile '{}' is for grey pictures", icc.profile->name());
  } else {
    color.profile = icc.profile;
    color.source = "icc";
  }
  return true;
}

// Returns whether EXIF specifies the colour space.
bool take_exif(const Exif& exif, PhotoColor& color) {
  constexpr int kSrgb = 1, kAdobeRgb = 2, kUncalibrated = 0xffff;
  if (exif.color_space == kSrgb) {
    color.source = "exif ColorSpace";
    return true;
  }
  if (exif.color_space == kAdobeRgb || (exif.color_space == kUncalibrated && exif.interoperability == "R03")) {
    color.profile = adobe_rgb_profile();
    color.source = exif.color_space == kAdobeRgb ? "exif ColorSpace" : "exif InteroperabilityIndex";
    return true;
  }
  if (exif.color_space == kUncalibrated)
    color.problem = "EXIF says that its colours are not sRGB (ColorSpace: uncalibrated), and there is no profile that says more";
  return false;
}

// gAMA stores 100000 / gamma, cHRM eight numbers of 1/100000: white, red, green, blue.
struct PngColors {
  std::optional<Cicp> cicp;
  std::optional<std::string_view> icc;
  bool srgb = false;
  uint64_t gamma = 0;
  std::optional<Chromaticities> primaries;
  bool grey = false;
};

PngColors png_colors(std::string_view file) {
  PngColors out;
  const auto at = [](std::string_view data, size_t i) { return double(number_at(data, 4 * i, 4, true)) / 100000; };
  png_chunks(file, [&](std::string_view type, std::string_view d) {
    if (type == "IHDR" && d.size() >= 10) out.grey = d[9] == 0 || d[9] == 4;
    if (type == "cICP" && d.size() == 4 && !out.cicp)
      out.cicp = Cicp{.primaries = unsigned(number_at(d, 0, 1, true)),
                      .transfer = unsigned(number_at(d, 1, 1, true)),
                      .matrix = unsigned(number_at(d, 2, 1, true)),
                      .full_range = d[3] != 0};
    if (type == "iCCP" && !out.icc) out.icc = d;
    if (type == "sRGB") out.srgb = true;
    if (type == "gAMA" && d.size() == 4) out.gamma = number_at(d, 0, 4, true);
    if (type == "cHRM" && d.size() == 32)
      out.primaries = Chromaticities{.red_x = at(d, 2),
                                     .red_y = at(d, 3),
                                     .green_x = at(d, 4),
                                     .green_y = at(d, 5),
                                     .blue_x = at(d, 6),
                                     .blue_y = at(d, 7),
                                     .white_x = at(d, 0),
                                     .white_y = at(d, 1)};
  });
  return out;
}

// Returns whether the chunks specify the colour space.
bool take_gamma(const PngColors& png, PhotoColor& color) {
  constexpr double kSrgb = 45455, kNear = 0.01, kLeast = 10000, kMost = 500000;
  if (png.gamma == 0) return false;
  const auto gamma = double(png.gamma);
  if (gamma < kLeast || gamma > kMost) {
    color.problem = fmt::format("its gAMA chunk holds {}, which is no gamma of a picture", png.gamma);
    return false;
  }
  const Chromaticities primaries = png.primaries.value_or(kRec709);
  // The value for the sRGB curve in files without an sRGB chunk (PNG, 11.3.2.5).
  const bool srgb_curve = std::abs(gamma / kSrgb - 1) < kNear;
  const bool linear = std::abs(gamma / 100000 - 1) < kNear;
  ColorProfile::Curve curve;
  if (srgb_curve)
    curve = [](double v) { return linear_from_srgb(v); };
  else if (!linear)
    curve = [exponent = 100000 / gamma](double v) { return std::pow(v, exponent); };
  const std::string shape = srgb_curve ? "the curve of sRGB" : linear ? "linear" : fmt::format("gamma {:.2f}", 100000 / gamma);
  const ColorProfilePtr profile = primaries_profile(fmt::format("{}, {}", primaries_name(primaries), shape), primaries, curve);
  if (!profile) {
    color.problem = "the primaries of its cHRM chunk are impossible";
    return false;
  }
  color.profile = profile;
  color.source = png.primaries ? "png gAMA, cHRM" : "png gAMA";
  return true;
}

PhotoColor png_color(std::string_view file, const Exif& exif) {
  PhotoColor color;
  const PngColors png = png_colors(file);
  if (png.cicp) {
    if (const ColorProfilePtr profile = cicp_profile(*png.cicp)) {
      color.profile = profile;
      color.source = "png cICP";
      return color;
    }
    color.problem = fmt::format("its cICP chunk ({} {} {} {}) names no colours that are read", png.cicp->primaries,
                                png.cicp->transfer, png.cicp->matrix, int(png.cicp->full_range));
  }
  if (png.icc) {
    Embedded embedded = inflated_profile(*png.icc);
    embedded.grey_picture = png.grey;
    if (PhotoColor by_icc; take_icc(embedded, by_icc)) return by_icc;
  }
  if (png.srgb) {
    color.source = "png sRGB";
    color.problem.clear();
    return color;
  }
  if (!take_gamma(png, color)) take_exif(exif, color);
  return color;
}

PhotoColor jpeg_color(std::string_view file, const Exif& exif) {
  PhotoColor color;
  bool four_channels = false;
  const Embedded embedded = jpeg_profile(file, four_channels);
  if (four_channels) {
    color.refusal = "its colours are those of print (CMYK): export it as RGB";
    return color;
  }
  if (!take_icc(embedded, color)) take_exif(exif, color);
  return color;
}

PhotoColor tiff_color(std::string_view file, const Probe& probe, const Exif& exif) {
  PhotoColor color;
  const TiffPages pages = tiff_pages(file);
  Embedded embedded;
  embedded.bytes = tiff_profile(file);
  embedded.grey_picture = !pages.pages.empty() && tiff_channels(pages.chosen()).colours == 1;
  const bool has_profile = take_icc(embedded, color);
  if (color.source == "icc" || !color.refusal.empty()) return color;
  if (probe.float_samples) {
    color.profile = linear_rec709_profile();
    color.source = "float linear";
  } else if (!has_profile) {
    take_exif(exif, color);
  }
  return color;
}

PhotoColor exr_color(std::string_view file) {
  ExrPrimaries colors = exr_primaries(file);
  return {.profile = std::move(colors.profile),
          .source = colors.stated ? "chromaticities" : "float linear",
          .problem = std::move(colors.problem),
          .refusal = {}};
}

// The profile precedes the code points, which then describe the coding alone.
PhotoColor heif_color(std::string_view bytes, const Exif& exif) {
  const HeifFile file = heif_file(bytes);
  PhotoColor color;
  if (take_icc({.bytes = std::string(file.icc), .problem = {}}, color) && color.source == "icc") return color;
  constexpr unsigned kUnspecified = 2;
  if (file.nclx && file.nclx->primaries != kUnspecified && file.nclx->transfer != kUnspecified) {
    if (const ColorProfilePtr profile = cicp_profile(*file.nclx)) {
      color.profile = profile;
      color.source = "heif nclx";
      color.problem.clear();
      return color;
    }
    color.problem = fmt::format("its code points ({} {}) name no colours that are read", file.nclx->primaries, file.nclx->transfer);
  }
  if (file.icc.empty()) take_exif(exif, color);
  return color;
}

}  // namespace

PhotoColor color_of(std::string_view bytes, const Probe& probe, const Exif& exif) {
  switch (probe.format) {
    case PhotoFormat::Jpeg:
      return jpeg_color(bytes, exif);
    case PhotoFormat::Png:
      return png_color(bytes, exif);
    case PhotoFormat::Tiff:
      return tiff_color(bytes, probe, exif);
    case PhotoFormat::Exr:
      return exr_color(bytes);
    case PhotoFormat::Heif:
      return heif_color(bytes, exif);
    case PhotoFormat::Raw:
      return {.profile = linear_rec709_profile(), .source = "camera raw", .problem = {}, .refusal = {}};
    case PhotoFormat::Unknown:
      break;
  }
  return {};
}

bool has_alpha(std::string_view bytes, PhotoFormat format) {
  bool found = false;
  if (format == PhotoFormat::Png)
    png_chunks(bytes, [&](std::string_view type, std::string_view d) {
      if (type == "IHDR" && d.size() >= 10) found = d[9] == 4 || d[9] == 6;
      if (type == "tRNS") found = true;
    });
  if (format == PhotoFormat::Tiff) {
    const TiffPages pages = tiff_pages(bytes);
    found = !pages.pages.empty() && tiff_channels(pages.chosen()).alpha.has_value();
  }
  if (format == PhotoFormat::Heif) found = heif_file(bytes).alpha;
  if (format == PhotoFormat::Exr) {
    // Zero-terminated names, each followed by 16 bytes. A layer name precedes a dot.
    const std::string_view list = exr_attribute(bytes, "channels", "chlist");
    for (size_t at = 0; at < list.size() && !found;) {
      const size_t end = list.find('\0', at);
      if (end == std::string_view::npos || end == at) break;
      const std::string_view name = list.substr(at, end - at);
      found = name == "A" || name.ends_with(".A") || name.ends_with(".a");
      at = end + 17;
    }
  }
  return found;
}

namespace {

std::string counted(size_t n) { return n == 1 ? "1 photo" : fmt::format("{} photos", n); }

}  // namespace

ColorFacts color_facts(const PhotoColor& color, bool varying_alpha) {
  return {.profile = color.profile->name(),
          .source = color.source,
          .problem = color.problem,
          .rec709_primaries = color.profile->has_rec709_primaries(),
          .alpha = varying_alpha};
}

std::vector<ColorNote> color_notes(std::span<const ColorFacts* const> photos) {
  std::vector<ColorNote> notes;
  // Grouped by primaries and curve; linear and sRGB pictures of Rec. 709 form one group.
  std::map<std::string, std::vector<size_t>> groups;
  std::vector<size_t> problems, alpha;
  for (size_t i = 0; i < photos.size(); ++i) {
    if (!photos[i]) continue;
    const ColorFacts& p = *photos[i];
    groups[p.rec709_primaries ? "sRGB" : p.profile].push_back(i);
    if (!p.problem.empty()) problems.push_back(i);
    if (p.alpha) alpha.push_back(i);
  }
  if (!problems.empty())
    notes.push_back({.finding = "unusable_profiles",
                     .warning_code = "PHOTO_PROFILE_UNUSABLE",
                     .what = fmt::format("the colours of {} are taken as sRGB, but may be others", counted(problems.size())),
                     .why = photos[problems[0]]->problem,
                     .hint = "export the photos as sRGB, or with their profile",
                     .photos = problems});
  if (groups.size() > 1) {
    std::string list;
    for (const auto& [name, members] : groups) list += fmt::format("{}{} x {}", list.empty() ? "" : ", ", members.size(), name);
    notes.push_back({.finding = "mixed_profiles",
                     .warning_code = "PHOTO_PROFILES_DIFFER",
                     .what = fmt::format("the photos have {} colour profiles", groups.size()),
                     .why = list + "; each photo is converted by its own, and a wrong one shows as a tint",
                     .hint = "export all photos in the same way",
                     .photos = {}});
  }
  if (const std::string text = colors_text(photos); !text.empty())
    notes.push_back(
        {.finding = "color_profiles",
         .warning_code = {},
         .what = text,
         .why = "what the files say of their colours is applied; colours outside of sRGB are clipped in 8-bit pictures",
         .hint = "nothing to do",
         .photos = {}});
  if (!alpha.empty())
    notes.push_back({.finding = "alpha_not_used",
                     .warning_code = "PHOTO_ALPHA_NOT_USED",
                     .what = fmt::format("{} an alpha channel, which is used only as a mask",
                                         alpha.size() == 1 ? "1 photo has" : fmt::format("{} photos have", alpha.size())),
                     .why = "the pixels that it hides are taken as they are in the file, often black",
                     .hint = "--masks PHOTOS takes the alpha of PNG and TIFF photos as the mask of the object",
                     .photos = alpha});
  return notes;
}

std::string colors_text(std::span<const ColorFacts* const> photos) {
  std::map<std::string, size_t> counts;
  for (const ColorFacts* p : photos)
    if (p && !(p->rec709_primaries)) ++counts[p->profile];
  std::string text;
  for (const auto& [name, n] : counts) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", counted(n), name);
  return text.empty() ? "" : text + " -> linear Rec. 709";
}

}  // namespace vitrine
