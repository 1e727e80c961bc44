#include "core/intake/masks/photo_masks.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"

namespace vitrine {

namespace {

// Same file name as the photo, extension included: when the photo folder is given for the masks, the file is the photo itself.
bool called_like_photo(const MaskFile& file, const std::string& photo) {
  return lowered(file.path.filename().string()) == lowered(std::filesystem::path(photo).filename().string());
}

// Reads a mask; nullopt for a photo without a varying alpha channel.
std::optional<ImageF> mask_or_photo(const MaskFile& file, const std::string& photo, bool& void_label) {
  try {
    return read_mask(file, &void_label);
  } catch (const Error& e) {
    if (e.detail().code != "MASK_NOT_GREY" || !called_like_photo(file, photo)) throw;
    return std::nullopt;
  }
}

}  // namespace

std::vector<std::optional<MaskFile>> matching_masks(const MaskFolder& folder, MaskClass kind,
                                                    const std::vector<std::string>& photos, const std::string& off_setting,
                                                    Notes* notes) {
  const std::vector<std::optional<MaskFile>> found = folder.match(kind, photos, notes);
  if (photos.empty() || std::ranges::any_of(found, [](const auto& f) { return f.has_value(); })) return found;
  const size_t files = folder.file_count(kind);
  throw Error(ErrorKind::Input, fmt::format("no photo has a mask of the class '{}'", name(kind)),
              {.where = folder.path().string(),
               .why = fmt::format("{} file{} there; none is called like a photo, for example {}", files, files == 1 ? "" : "s",
                                  photos.front()),
               .hint = fmt::format("call them {}, or --set {}",
                                   std::filesystem::path(photos.front()).replace_extension(".png").string(), off_setting),
               .code = "MASKS_MATCH_NO_PHOTO"});
}

std::vector<std::string> check_mask_names(const std::filesystem::path& masks, MaskClass flat,
                                          const std::vector<std::string>& photos, std::span<const MaskClass> used) {
  const MaskFolder folder(masks, flat, photos);
  size_t files = 0;
  for (MaskClass kind : kMaskClasses) files += folder.file_count(kind);
  if (files == 0) throw_no_mask_file(masks);
  std::vector<std::string> notes;
  for (MaskClass kind : used) {
    if (folder.file_count(kind) == 0) continue;
    const auto found = matching_masks(folder, kind, photos, fmt::format("masks.{}.source=none", name(kind)));
    const size_t without = size_t(std::count(found.begin(), found.end(), std::nullopt));
    if (without > 0)
      notes.push_back(fmt::format("{} of {} photos have no mask of the class '{}'", without, photos.size(), name(kind)));
  }
  return notes;
}

void throw_no_mask_file(const std::filesystem::path& masks) {
  throw Error(ErrorKind::Input, "there is no mask file",
              {.where = masks.string(),
               .why = "masks are pictures (png, jpg, tif), in folders called object, transparent, specular or ignore",
               .hint = "stages/masks/mask_files.md shows how they may be called",
               .code = "MASKS_MISSING"});
}

PhotoMasks::PhotoMasks(const PhotoMasksDesc& desc)
    : kind_(desc.kind),
      where_(desc.folder.path().string()),
      polarity_option_(desc.polarity_option),
      off_setting_(desc.off_setting),
      black_belongs_(desc.polarity == MaskPolarity::Black),
      files_(matching_masks(desc.folder, desc.kind, desc.photos, desc.off_setting, &notes_)) {
  const std::string class_name(name(desc.kind));
  matched_ = size_t(std::count_if(files_.begin(), files_.end(), [](const auto& f) { return f.has_value(); }));
  std::vector<MaskExtent> extents(files_.size());
  std::vector<uint8_t> left_out(files_.size(), 0), photo_itself(files_.size(), 0), with_void(files_.size(), 0);
  parallel_for(files_.size(), 1, [&](size_t i) {
    if (!files_[i] || interrupt_signal() != 0) return;
    bool void_label = false;
    const std::optional<ImageF> read = mask_or_photo(*files_[i], desc.photos[i], void_label);
    with_void[i] = void_label;
    if (!read) {
      left_out[i] = photo_itself[i] = 1;
      return;
    }
    const ImageF mask = with_polarity(*read);
    if (desc.usable && !desc.usable(i, *files_[i], mask))
      left_out[i] = 1;
    else
      extents[i].add(mask);
  });
  throw_if_interrupted();
  for (size_t i = 0; i < files_.size(); ++i)
    if (left_out[i]) files_[i].reset(), --matched_;
  if (const auto maps = std::ranges::count(with_void, 1); maps > 0)
    notes_.push_back(
        {"MASKS_VOID_LABEL",
         fmt::format("{} of the masks of the class '{}' have small labels and 255: labels belong to the class, 255 is "
                     "taken for void and does not; if it does, write masks of 0 and 255 only",
                     maps, class_name)});
  // Photos without a varying alpha channel are no masks.
  const auto photos_themselves = static_cast<size_t>(std::count(photo_itself.begin(), photo_itself.end(), 1));
  if (matched_ == 0 && photos_themselves > 0)
    throw Error(ErrorKind::Input, fmt::format("no photo has a mask of the class '{}'", class_name),
                {.where = desc.folder.path().string(),
                 .why = fmt::format("its {} files are photos, and none has an alpha channel that varies", photos_themselves),
                 .hint = fmt::format("give a folder of masks, or --set {}", desc.off_setting),
                 .code = "MASKS_ARE_PHOTOS"});
  MaskExtent all;
  for (const MaskExtent& e : extents) {
    if (e.masks == 0) continue;
    const double n = double(++all.masks);
    all.mean += (e.mean - all.mean) / n;
    all.border += (e.border - all.border) / n;
    all.centre += (e.centre - all.centre) / n;
    all.empty += e.empty;
    all.full += e.full;
  }
  if (all.masks == 0) return;
  extent_ = all;
  if (nothing()) return;
  if (desc.polarity == MaskPolarity::Auto && looks_inverted(all))
    throw Error(ErrorKind::Input, fmt::format("the masks of the class '{}' look inverted", class_name),
                {.where = desc.folder.path().string(),
                 .why = fmt::format("{:.0f} % of the pixels are white, {:.0f} % at the border, {:.0f} % in the middle",
                                    100 * all.mean, 100 * all.border, 100 * all.centre),
                 .hint = fmt::format("--set {}=black if black means '{}', white if they are right as they are",
                                     desc.polarity_option, class_name),
                 .code = "MASKS_INVERTED"});
}

std::string PhotoMasks::all_black_text() const {
  return fmt::format("all masks of the class '{}' are {}", name(kind_), black_belongs_ ? "white" : "black");
}

void PhotoMasks::throw_all_black() const {
  throw Error(ErrorKind::Input, all_black_text(),
              {.where = where_,
               .why = fmt::format("{} masks, and no pixel belongs to the class", extent_.masks),
               .hint = fmt::format("white means '{}' (--set {}=black turns it round); without such pixels: --set {}", name(kind_),
                                   polarity_option_, off_setting_),
               .code = "MASKS_ALL_BLACK"});
}

ImageF PhotoMasks::at(size_t photo) const {
  VITRINE_CHECK(files_[photo], "photo {} has no mask", photo);
  return with_polarity(read_mask(*files_[photo]));
}

ImageF PhotoMasks::with_polarity(ImageF mask) const {
  if (black_belongs_)
    for (float& v : mask.data()) v = 1 - v;
  return mask;
}

std::set<std::string> PhotoMasks::conventions() const {
  std::set<std::string> found;
  for (const auto& f : files_)
    if (f) found.insert(f->convention);
  return found;
}

bool same_shape(int width, int height, double other_width, double other_height) {
  const double scale = double(width) / other_width;
  return std::abs(height - scale * other_height) <= std::max(1.0, scale) + 0.5;
}

void throw_wrong_mask_size(const MaskFile& file, const ImageF& mask, int photo_width, int photo_height, bool turned) {
  throw Error(
      ErrorKind::Input, "a mask has another shape than its photo",
      {.where = file.path.string(),
       .why = fmt::format("{} x {} pixels; the photo has {} x {}", mask.width(), mask.height(), photo_width, photo_height),
       .hint = turned ? "photos are turned upright by their EXIF orientation: turn the mask as well"
                      : "masks may have another size than the photo, but show the same frame",
       .code = "MASK_WRONG_SIZE"});
}

}  // namespace vitrine
