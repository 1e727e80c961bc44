// The user's masks of one class for a list of photos: matched to photos, read with the correct polarity, and validated. All
// users of masks (features in sfm, the masks stage) reject the same files for the same reasons: no file name matches a photo, the
// aspect ratio differs, the mask is inverted. Empty masks mean that the scene lacks the class, unless no class has pixels: the
// caller, who has all classes, then calls throw_all_black().
#pragma once

#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/intake/masks/mask_files.h"

namespace vitrine {

// What belongs to the class in files. Auto: white, after a check that this can be.
enum class MaskPolarity { Auto, White, Black };

struct PhotoMasksDesc {
  const MaskFolder& folder;
  MaskClass kind = MaskClass::Object;
  std::vector<std::string> photos;  // names, "left/b.jpg"
  MaskPolarity polarity = MaskPolarity::Auto;
  std::string polarity_option;  // what the user sets: "masks.object.polarity"
  std::string off_setting;      // and how to do without: "masks.object.source=none"
  // May throw (throw_wrong_mask_size) or return false: the mask takes no part. Called from several threads.
  std::function<bool(size_t photo, const MaskFile&, const ImageF&)> usable = {};
};

class PhotoMasks {
 public:
  // Reads every file once. Throws Error{Input}.
  explicit PhotoMasks(const PhotoMasksDesc& desc);

  size_t photo_count() const { return files_.size(); }
  size_t matched() const { return matched_; }  // photos with a mask
  const std::optional<MaskFile>& file(size_t photo) const { return files_[photo]; }
  ImageF at(size_t photo) const;  // of a photo with a mask; 1 = belongs to the class; size as in the file
  bool black_belongs() const { return black_belongs_; }
  // No pixel, or every pixel, of all masks belongs to the class.
  bool nothing() const { return extent_.masks > 0 && extent_.empty == extent_.masks; }
  bool everything() const { return extent_.masks > 0 && extent_.full == extent_.masks; }
  [[noreturn]] void throw_all_black() const;
  // "all masks of the class 'object' are black"
  std::string all_black_text() const;
  std::set<std::string> conventions() const;
  const Notes& notes() const { return notes_; }  // on names and labels

 private:
  ImageF with_polarity(ImageF mask) const;
  MaskClass kind_;
  std::string where_, polarity_option_, off_setting_;
  MaskExtent extent_;
  bool black_belongs_ = false;
  Notes notes_;
  std::vector<std::optional<MaskFile>> files_;
  size_t matched_ = 0;
};

// Matches the masks of one class by photo names alone. Throws Error{Input} when no photo has one; `off_setting`: the setting
// that disables them.
std::vector<std::optional<MaskFile>> matching_masks(const MaskFolder& folder, MaskClass kind,
                                                    const std::vector<std::string>& photos, const std::string& off_setting,
                                                    Notes* notes = nullptr);

// Checks mask names before a run: throws for no masks, folders that are no classes, no file that matches a photo. Returns
// sentences on photos without a mask. `photos`: names from ingest; `used`: classes read from files.
std::vector<std::string> check_mask_names(const std::filesystem::path& masks, MaskClass flat,
                                          const std::vector<std::string>& photos, std::span<const MaskClass> used = kMaskClasses);

[[noreturn]] void throw_no_mask_file(const std::filesystem::path& masks);

// Equal aspect ratio, up to one pixel of rounding in the smaller picture.
bool same_shape(int width, int height, double other_width, double other_height);
[[noreturn]] void throw_wrong_mask_size(const MaskFile& file, const ImageF& mask, int photo_width, int photo_height, bool turned);

}  // namespace vitrine
