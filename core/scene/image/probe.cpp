#include "core/scene/image/probe.h"

#include <fmt/format.h>

#include "core/scene/image/file_kind.h"
#include "core/scene/image/heif_file.h"
#include "core/scene/image/segments.h"
#include "core/scene/image/tiff_pages.h"

namespace vitrine {

namespace {

constexpr std::string_view kPngMagic("\x89PNG\r\n\x1a\n", 8);
constexpr std::string_view kExrMagic("\x76\x2f\x31\x01", 4);
constexpr std::string_view kExifMagic("Exif\0\0", 6);

PhotoFormat format_of(std::string_view b) {
  if (b.starts_with("\xff\xd8\xff")) return PhotoFormat::Jpeg;
  if (b.starts_with(kPngMagic)) return PhotoFormat::Png;
  if (is_tiff(b)) return tiff_pages(b).raw.empty() ? PhotoFormat::Tiff : PhotoFormat::Raw;
  if (b.starts_with(kExrMagic)) return PhotoFormat::Exr;
  const FileKind kind = file_kind(b);
  return kind.heif ? PhotoFormat::Heif : kind.raw ? PhotoFormat::Raw : PhotoFormat::Unknown;
}

void probe_tiff(std::string_view b, Probe& probe) {
  const TiffPages pages = tiff_pages(b);
  if (pages.pages.empty()) return;
  const TiffPage& page = pages.chosen();
  probe.width = page.width;
  probe.height = page.height;
  probe.float_samples = page.sample_format == 3;
  probe.orientation = static_cast<int>(page.orientation);
}

void probe_exr(std::string_view b, Probe& probe) {
  constexpr std::string_view kWindow("displayWindow\0box2i\0", 20);  // parsed even if the file is truncated here
  const size_t at = b.find(kWindow);
  if (at == std::string_view::npos) return;
  int32_t box[4];
  for (size_t i = 0; i < 4; ++i) box[i] = static_cast<int32_t>(number_at(b, at + kWindow.size() + 4 + 4 * i, 4, false));
  const int64_t width = int64_t(box[2]) - box[0] + 1, height = int64_t(box[3]) - box[1] + 1;
  if (width > 0 && height > 0) probe.width = static_cast<uint64_t>(width), probe.height = static_cast<uint64_t>(height);
}

}  // namespace

Probe probe_photo(std::string_view b) {
  Probe probe;
  probe.format = format_of(b);
  switch (probe.format) {
    case PhotoFormat::Jpeg:
      jpeg_segments(b, [&](unsigned marker, std::string_view payload) {
        if (!is_start_of_frame(marker)) return true;
        probe.height = number_at(payload, 1, 2, true);
        probe.width = number_at(payload, 3, 2, true);
        return false;
      });
      break;
    case PhotoFormat::Png:
      probe.width = number_at(b, 16, 4, true);
      probe.height = number_at(b, 20, 4, true);
      break;
    case PhotoFormat::Tiff:
      probe_tiff(b, probe);
      break;
    case PhotoFormat::Exr:
      probe_exr(b, probe);
      break;
    case PhotoFormat::Heif: {
      const HeifFile file = heif_file(b);
      probe.width = file.width;
      probe.height = file.height;
      break;
    }
    case PhotoFormat::Raw:  // linear: samples of the sensor
      if (is_tiff(b)) probe_tiff(b, probe);
      probe.float_samples = true;
      break;
    case PhotoFormat::Unknown:
      break;
  }
  return probe;
}

std::string implausible_size(const Probe& probe, size_t file_bytes) {
  constexpr uint64_t kMaxPixels = uint64_t{1} << 28, kAlwaysFine = uint64_t{1} << 24;
  constexpr uint64_t kPixelsPerByte = 2048;  // deflate compresses at most 1032:1, one JPEG byte fills at most 340 pixels
  const uint64_t w = probe.width, h = probe.height;
  if (w > kMaxPixels || h > kMaxPixels || w * h > kMaxPixels)
    return fmt::format("{} x {} pixels are more than vitrine takes ({})", w, h, kMaxPixels);
  if (w * h > kAlwaysFine && w * h / kPixelsPerByte > file_bytes)
    return fmt::format("a file of {} bytes cannot hold {} x {} pixels: its header is damaged", file_bytes, w, h);
  return "";
}

std::string missing_end(std::string_view b) {
  switch (format_of(b)) {
    case PhotoFormat::Jpeg:
      return jpeg_structure(b).damage;
    case PhotoFormat::Png:
      return png_chunks(b, {}) ? "" : "the PNG has no end chunk: the file is truncated";
    default:
      return "";
  }
}

std::string exif_block(std::string_view b) {
  std::string block;
  switch (format_of(b)) {
    case PhotoFormat::Jpeg:
      jpeg_segments(b, [&](unsigned marker, std::string_view payload) {
        if (marker != 0xe1 || !payload.starts_with(kExifMagic)) return true;
        block = payload;
        return false;
      });
      break;
    case PhotoFormat::Png:
      png_chunks(b, [&](std::string_view type, std::string_view data) {
        if (type == "eXIf") block = std::string(kExifMagic).append(data);
      });
      break;
    case PhotoFormat::Tiff:
      block = tiff_exif_block(b);
      break;
    case PhotoFormat::Heif:
      block = heif_file(b).exif;
      break;
    case PhotoFormat::Raw:
      if (is_tiff(b)) block = tiff_exif_block(b);
      break;
    default:
      break;
  }
  return block;
}

}  // namespace vitrine
