// The user's masks of one class for a list of photos: which file belongs to which photo, read with the right polarity, and
// looked at before anything uses them. Whoever needs masks (features in sfm, the masks stage) refuses the same files for the same
// reasons: no file called like a photo, another shape than the photo, nothing in any mask, a negative.
#pragma once

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/camera/mask_files.h"

namespace vitrine {

struct PhotoMasksDesc {
  const MaskFolder& folder;
  MaskClass kind = MaskClass::Object;
  std::vector<std::string> photos;  // names, "left/b.jpg"
  std::string polarity = "auto";    // what belongs to the class: "white", "black", or white after a look ("auto")
  std::string polarity_option;      // what the user sets: "masks.object.polarity"
  std::string off_setting;          // and how to do without: "masks.object.source=none"
  // May throw (throw_wrong_mask_size) or say that this mask takes no part. Called from several threads.
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
  std::set<std::string> conventions() const;
  const Notes& notes() const { return notes_; }  // on names

 private:
  bool black_belongs_ = false;
  Notes notes_;
  std::vector<std::optional<MaskFile>> files_;
  size_t matched_ = 0;
};

// Same picture at another size: sides in proportion, up to the rounding of one pixel of the smaller one.
bool same_shape(int width, int height, double other_width, double other_height);
[[noreturn]] void throw_wrong_mask_size(const MaskFile& file, const ImageF& mask, int photo_width, int photo_height, bool turned);

}  // namespace vitrine
