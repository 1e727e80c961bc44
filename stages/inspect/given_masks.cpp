#include "stages/inspect/given_masks.h"

#include <mutex>

#include "core/base/error.h"
#include "core/camera/photo_masks.h"

namespace vitrine {

namespace {

Finding refused(const Error& e) {
  const ErrorDetail& d = e.detail();
  return {.code = d.code,
          .severity = Severity::Problem,
          .what = e.message(),
          .why = d.where + (d.where.empty() || d.why.empty() ? "" : ": ") + d.why,
          .hint = d.hint,
          .photos = {}};
}

// The masks of one class. Masks of another shape may be of undistorted photos, whose size is not known before the poses are.
void check_class(const MaskFolder& folder, MaskClass kind, const std::vector<PhotoFacts>& photos,
                 const std::vector<size_t>& usable, std::vector<Finding>& list) {
  std::vector<std::string> names;
  for (size_t i : usable) names.push_back(photos[i].name);
  std::vector<uint8_t> other_shape(usable.size(), 0);
  const PhotoMasks masks({.folder = folder,
                          .kind = kind,
                          .photos = names,
                          .polarity = "auto",
                          .polarity_option = fmt::format("masks.{}.polarity", name(kind)),
                          .off_setting = fmt::format("masks.{}.source=none", name(kind)),
                          .usable = [&](size_t i, const MaskFile& file, const ImageF& mask) {
                            const PhotoFacts& p = photos[usable[i]];
                            if (same_shape(mask.width(), mask.height(), p.width, p.height)) return true;
                            if (same_shape(mask.width(), mask.height(), p.height, p.width))
                              throw_wrong_mask_size(file, mask, p.width, p.height, true);
                            other_shape[i] = 1;
                            return true;
                          }});
  std::vector<size_t> without, other;
  for (size_t i = 0; i < usable.size(); ++i) {
    if (!masks.file(i)) without.push_back(usable[i]);
    if (other_shape[i]) other.push_back(usable[i]);
  }
  if (!without.empty())
    list.push_back({"MASKS_INCOMPLETE", Severity::Warning,
                    fmt::format("{} of {} photos have no mask of the class '{}'", without.size(), usable.size(), name(kind)),
                    "masks are found by the names of the photos", "give every photo a mask; one without pixels is black",
                    without});
  if (!other.empty())
    list.push_back({"MASK_OTHER_SHAPE", Severity::Warning,
                    fmt::format("{} masks of the class '{}' have another shape than their photos", other.size(), name(kind)),
                    "they are taken where they have the shape of the undistorted photos, else the run ends there",
                    "draw masks on the photos as they were taken", other});
}

}  // namespace

std::vector<Finding> mask_findings(const std::filesystem::path& path, const std::vector<PhotoFacts>& photos) {
  std::vector<Finding> list;
  std::vector<size_t> usable;
  for (size_t i = 0; i < photos.size(); ++i)
    if (photos[i].usable()) usable.push_back(i);
  if (usable.empty()) return list;
  try {
    const MaskFolder folder(path);
    size_t files = 0;
    for (MaskClass kind : kMaskClasses) {
      files += folder.file_count(kind);
      if (folder.file_count(kind) == 0) continue;
      try {
        check_class(folder, kind, photos, usable, list);
      } catch (const Error& e) {
        if (e.kind() != ErrorKind::Input) throw;
        list.push_back(refused(e));
      }
    }
    if (files == 0)
      list.push_back({"MASKS_MISSING",
                      Severity::Problem,
                      "there is no mask file",
                      path.string(),
                      "masks are pictures (png, jpg, tif), in folders called object, transparent, specular or ignore",
                      {}});
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Input) throw;
    list.push_back(refused(e));
  }
  return list;
}

}  // namespace vitrine
