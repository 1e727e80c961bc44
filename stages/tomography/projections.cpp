#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/parallel.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "stages/tomography/scan_file.h"

namespace vitrine {

namespace {

constexpr float kLeastShare = 1e-5f;  // of the light without object: a line integral of 11.5
constexpr int kFewestPixels = 4;      // pixels along a side

// The first channel; integers as shares of white.
ImageF first_channel(const fs::path& path) {
  const ImageF all = lowered(path.extension().string()) == ".exr" ? read_exr(path).pixels : read_unchanged(path);
  ImageF out(all.width(), all.height(), 1);
  for (int y = 0; y < all.height(); ++y)
    for (int x = 0; x < all.width(); ++x) {
      out.at(x, y) = all.at(x, y);
      if (!std::isfinite(out.at(x, y)))
        throw Error(ErrorKind::Input, "a picture contains a value that is not finite",
                    {.where = fmt::format("{}, column {}, row {}", path.string(), x, y),
                     .hint = "replace such pixels by their neighbours",
                     .code = "NOT_FINITE"});
    }
  return out;
}

void check_size(const ImageF& image, const fs::path& path, const ImageF& first, const fs::path& first_path) {
  if (image.width() == first.width() && image.height() == first.height()) return;
  throw Error(ErrorKind::Input, "the pictures of the scan have different sizes",
              {.where = path.string(),
               .why = fmt::format("{} x {}, but {} has {} x {}", image.width(), image.height(), first_path.filename().string(),
                                  first.width(), first.height()),
               .hint = "give the pictures of one scan, with flat and dark fields of the same detector",
               .code = "SIZES_DIFFER"});
}

ImageF level_picture(const DetectorLevel& level, const ImageF& first, const fs::path& first_path) {
  if (level.file.empty()) return ImageF(first.width(), first.height(), 1, float(level.value));
  ImageF image = first_channel(level.file);
  check_size(image, level.file, first, first_path);
  return image;
}

// Light without object, minus dark.
ImageF open_beam(const ScanFile& scan, const ImageF& dark, const ImageF& first) {
  ImageF open = level_picture(scan.flat, first, scan.projections.front());
  size_t wrong = 0;
  for (size_t i = 0; i < open.pixel_count(); ++i) {
    open.data()[i] -= dark.data()[i];
    wrong += !(open.data()[i] > 0);
  }
  if (wrong > 0)
    throw Error(ErrorKind::Input, "the flat field is not brighter than the dark field",
                {.where = scan.flat.where,
                 .why = fmt::format("in {} of {} pixels", wrong, open.pixel_count()),
                 .hint = "flat: the detector without object, dark: without X-rays; they may be swapped",
                 .code = "FLAT_NOT_BRIGHTER"});
  return open;
}

void check_content(const ScanFile& scan, const std::vector<ImageF>& images) {
  const auto dense = [](const ImageF& i) { return std::ranges::any_of(i.data(), [](float v) { return v > 0; }); };
  if (std::ranges::any_of(images, dense)) return;
  throw Error(ErrorKind::Input, "the projections show nothing",
              {.where = scan.where,
               .why = "no pixel of any projection is darker than the beam without object",
               .hint = "check flat and dark, and whether the pixels are line integrals (absorption: 1)",
               .code = "EMPTY_SCAN"});
}

}  // namespace

std::vector<ImageF> read_projections(ScanFile& scan) {
  std::vector<ImageF> out(scan.projections.size());
  parallel_for(out.size(), 1, [&](size_t i) { out[i] = first_channel(scan.projections[i]); });
  const ImageF& first = out.front();
  for (size_t i = 0; i < out.size(); ++i) check_size(out[i], scan.projections[i], first, scan.projections.front());
  if (std::min(first.width(), first.height()) < kFewestPixels)
    throw Error(ErrorKind::Input, "the projections are too small",
                {.where = scan.where,
                 .why = fmt::format("{} x {} pixels; a side has at least {}", first.width(), first.height(), kFewestPixels),
                 .hint = "give the pictures of the detector, not thumbnails",
                 .code = "SIZES_DIFFER"});
  scan.geometry.width = first.width(), scan.geometry.height = first.height();
  if (scan.absorption) {
    for (ImageF& image : out)
      for (float& v : image.data()) v *= float(scan.full_scale);
  } else {
    const ImageF dark = level_picture(scan.dark, first, scan.projections.front()), open = open_beam(scan, dark, first);
    parallel_for(out.size(), 1, [&](size_t n) {
      for (size_t i = 0; i < open.pixel_count(); ++i) {
        const float share = (out[n].data()[i] - dark.data()[i]) / open.data()[i];
        out[n].data()[i] = -std::log(std::max(share, kLeastShare));
      }
    });
  }
  check_content(scan, out);
  return out;
}

}  // namespace vitrine
