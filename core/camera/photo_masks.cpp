#include "core/camera/photo_masks.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/process.h"

namespace vitrine {

PhotoMasks::PhotoMasks(const PhotoMasksDesc& desc)
    : black_belongs_(desc.polarity == "black"), files_(desc.folder.match(desc.kind, desc.photos, &notes_)) {
  const std::string class_name(name(desc.kind));
  for (const auto& file : files_) matched_ += file.has_value();
  const size_t files = desc.folder.file_count(desc.kind);
  if (matched_ == 0)
    throw Error(
        ErrorKind::Input, fmt::format("no photo has a mask of the class '{}'", class_name),
        {.where = desc.folder.path().string(),
         .why = fmt::format("{} file{} there; none is called like a photo, for example {}", files, files == 1 ? "" : "s",
                            desc.photos.front()),
         .hint = fmt::format("call them {}, or --set {}",
                             std::filesystem::path(desc.photos.front()).replace_extension(".png").string(), desc.off_setting),
         .code = "MASKS_MATCH_NO_PHOTO"});
  std::vector<MaskExtent> extents(files_.size());
  std::vector<uint8_t> left_out(files_.size(), 0);
  parallel_for(files_.size(), 1, [&](size_t i) {
    if (!files_[i] || interrupt_signal() != 0) return;
    const ImageF mask = at(i);
    if (desc.usable && !desc.usable(i, *files_[i], mask))
      left_out[i] = 1;
    else
      extents[i].add(mask);
  });
  throw_if_interrupted();
  for (size_t i = 0; i < files_.size(); ++i)
    if (left_out[i]) files_[i].reset(), --matched_;
  MaskExtent all;
  for (const MaskExtent& e : extents) {
    if (e.masks == 0) continue;
    const double n = double(++all.masks);
    all.mean += (e.mean - all.mean) / n;
    all.border += (e.border - all.border) / n;
    all.centre += (e.centre - all.centre) / n;
    all.empty += e.empty;
  }
  if (all.masks == 0) return;
  if (all.empty == all.masks)
    throw Error(ErrorKind::Input,
                fmt::format("all masks of the class '{}' are {}", class_name, black_belongs_ ? "white" : "black"),
                {.where = desc.folder.path().string(),
                 .why = fmt::format("{} masks, and no pixel belongs to the class", all.masks),
                 .hint = fmt::format("white means '{}' (--set {}=black turns it round); without such pixels: --set {}",
                                     class_name, desc.polarity_option, desc.off_setting),
                 .code = "MASKS_ALL_BLACK"});
  if (desc.polarity == "auto" && looks_inverted(all))
    throw Error(ErrorKind::Input, fmt::format("the masks of the class '{}' look inverted", class_name),
                {.where = desc.folder.path().string(),
                 .why = fmt::format("{:.0f} % of the pixels are white, {:.0f} % at the border, {:.0f} % in the middle",
                                    100 * all.mean, 100 * all.border, 100 * all.centre),
                 .hint = fmt::format("--set {}=black if black means '{}', white if they are right as they are",
                                     desc.polarity_option, class_name),
                 .code = "MASKS_INVERTED"});
}

ImageF PhotoMasks::at(size_t photo) const {
  VITRINE_CHECK(files_[photo], "photo {} has no mask", photo);
  ImageF mask = read_mask(*files_[photo]);
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
