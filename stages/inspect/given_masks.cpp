#include "stages/inspect/given_masks.h"

#include "core/foundation/base/error.h"
#include "core/intake/masks/photo_masks.h"

namespace vitrine {

Finding refused_input(const Error& e) {
  const ErrorDetail& d = e.detail();
  return {.code = d.code,
          .severity = Severity::Problem,
          .what = e.message(),
          .why = d.where + (d.where.empty() || d.why.empty() ? "" : ": ") + d.why,
          .hint = d.hint,
          .photos = {}};
}

namespace {

// Checks the masks of one class. Masks of another size may belong to undistorted photos, whose size is unknown before the poses.
void check_class(const MaskFolder& folder, MaskClass kind, const std::vector<PhotoFacts>& photos,
                 const std::vector<size_t>& usable, std::vector<Finding>& list, std::vector<std::string>& blank) {
  std::vector<std::string> names;
  for (size_t i : usable) names.push_back(photos[i].name);
  std::vector<uint8_t> other_shape(usable.size(), 0);
  const PhotoMasks masks({.folder = folder,
                          .kind = kind,
                          .photos = names,
                          .polarity = MaskPolarity::Auto,
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
  for (const Note& note : masks.notes())
    list.push_back({note.code,
                    Severity::Warning,
                    note.text,
                    note.code == "MASKS_VOID_LABEL" ? "other values of a mask are shares of the class" : "a name means one photo",
                    "",
                    {}});
  if (masks.nothing()) {
    blank.push_back(masks.all_black_text());
    return;
  }
  if (masks.everything())
    list.push_back({"MASKS_ALL_WHITE",
                    kind == MaskClass::Ignore ? Severity::Problem : Severity::Warning,  // no usable pixel remains
                    fmt::format("all masks of the class '{}' are white", name(kind)),
                    "every pixel of every photo belongs to the class",
                    "leave the class out if it is not meant",
                    {}});
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
  std::vector<std::string> names;
  for (size_t i : usable) names.push_back(photos[i].name);
  try {
    const MaskFolder folder(path, MaskClass::Object, names);
    for (const Note& note : folder.notes()) list.push_back({note.code, Severity::Warning, note.text, path.string(), "", {}});
    size_t classes = 0;
    std::vector<std::string> blank;
    for (MaskClass kind : kMaskClasses) {
      if (folder.file_count(kind) == 0) continue;
      ++classes;
      try {
        check_class(folder, kind, photos, usable, list, blank);
      } catch (const Error& e) {
        if (e.kind() != ErrorKind::Input) throw;
        list.push_back(refused_input(e));
      }
    }
    if (classes == 0) throw_no_mask_file(path);
    for (const std::string& text : blank)
      list.push_back(classes == blank.size()
                         ? Finding{"MASKS_ALL_BLACK",
                                   Severity::Problem,
                                   text,
                                   "no pixel of any photo belongs to a class",
                                   "white means yes: --set masks.CLASS.polarity=black turns it round",
                                   {}}
                         : Finding{"MASKS_EMPTY", Severity::Warning, text, "the class is taken as absent", "", {}});
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Input) throw;
    list.push_back(refused_input(e));
  }
  return list;
}

}  // namespace vitrine
