#include "core/intake/photos/raw_photo.h"

#include <algorithm>
#include <map>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/file.h"

namespace vitrine {

namespace fs = std::filesystem;

namespace {

constexpr const char* kRawExtensions[] = {".3fr", ".arw", ".cr2", ".cr3", ".crw", ".dcr", ".dng", ".erf", ".fff",
                                          ".gpr", ".iiq", ".kdc", ".mef", ".mos", ".mrw", ".nef", ".nrw", ".orf",
                                          ".pef", ".raf", ".rw2", ".rwl", ".sr2", ".srf", ".srw", ".x3f"};

}  // namespace

bool has_raw_extension(const std::string& extension) {
  return std::find(std::begin(kRawExtensions), std::end(kRawExtensions), extension) != std::end(kRawExtensions);
}

RawHead raw_head(const fs::path& path) {
  RawHead head;
  head.problem = camera_codecs().raw_facts(path.string(), head.facts);
  if (head.problem.empty() && !head.facts.colors_known)
    head.problem = fmt::format("{} does not know the colours of its camera ({}): export a 16-bit TIFF, or a DNG",
                               camera_codecs().raw_version(), head.facts.camera.empty() ? "no name" : head.facts.camera);
  return head;
}

void add_raw_facts(Exif& exif, const RawFacts& facts) {
  const auto add = [](std::optional<double>& to, double value) {
    if (!to && value > 0) to = value;
  };
  add(exif.exposure_s, facts.exposure_s);
  add(exif.f_number, facts.f_number);
  add(exif.iso, facts.iso);
  add(exif.focal_mm, facts.focal_mm);
  add(exif.focal_35mm, facts.focal_35mm);
  if (exif.camera.empty()) exif.camera = facts.camera;
  exif.orientation = facts.orientation;
}

ImageF read_raw_photo(const fs::path& path, const RawBalance& balance, bool half) {
  ImageF linear;
  if (std::string why = camera_codecs().raw(path.string(), {.balance = balance, .half = half}, linear); !why.empty())
    throw Error(
        ErrorKind::Input, "a photo cannot be used",
        {.where = path.string(), .why = std::move(why), .hint = "replace it or take it out of the folder", .code = "BAD_PHOTO"});
  return linear;
}

std::vector<RawBalance> common_balance(std::span<const fs::path> photos) {
  std::vector<RawHead> heads(photos.size());
  parallel_for(photos.size(), 1, [&](size_t i) {
    if (has_raw_extension(lowered(photos[i].extension().string()))) heads[i] = raw_head(photos[i]);
  });
  std::map<std::string, RawBalance> of_camera;
  std::vector<RawBalance> out(photos.size());
  for (size_t i = 0; i < photos.size(); ++i)
    if (heads[i].facts.width > 0) out[i] = of_camera.try_emplace(heads[i].facts.camera, heads[i].facts.balance).first->second;
  return out;
}

}  // namespace vitrine
