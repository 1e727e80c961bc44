// Removal of features that must not be used for pose estimation, by the user's masks (distorted photo coordinates, like the
// features):
//   specular, transparent   features seen in a mirror or through glass do not move with the scene
//   ignore                  passers-by
//   object                  removes everything outside, when the object is on a turntable (turntable.h); else the room is used,
//   too
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/intake/masks/photo_masks.h"
#include "stages/sfm/database.h"
#include "stages/sfm/turntable.h"

namespace vitrine {

struct SfmPhoto;
class Describer;

// Does the object turn before a camera that stands still? Auto: turntable.h finds out.
enum class Turntable { Auto, Yes, No };
inline constexpr std::array<std::string_view, 3> kTurntableWords{"auto", "yes", "no"};

// The values of MaskPolarity in their order, then Off: the masks of this class are not used here.
enum class FeatureMaskUse { Auto, White, Black, Off };
struct FeatureMasksConfig {
  MaskClass flat = MaskClass::Object;
  FeatureMaskUse object = FeatureMaskUse::Auto, transparent = FeatureMaskUse::Auto;
  FeatureMaskUse specular = FeatureMaskUse::Auto, ignore = FeatureMaskUse::Auto;
};
void describe(Describer& d, FeatureMasksConfig& c);

class FeatureMasks {
 public:
  // Throws Error{Input} for masks that cannot be right, and for Turntable::Yes without masks of the object.
  FeatureMasks(const std::filesystem::path& folder, const FeatureMasksConfig& config, Turntable turntable,
               const std::vector<SfmPhoto>& photos);

  Turntable turntable() const { return turntable_; }
  bool has(MaskClass kind) const { return masks_[size_t(kind)].has_value(); }
  size_t photos_with(MaskClass kind) const { return has(kind) ? masks_[size_t(kind)]->matched() : 0; }
  bool empty() const;
  // Number of masks whose aspect ratio differs from their photo: probably made for undistorted photos, which do not exist yet.
  size_t other_shape() const { return other_shape_; }
  // Per feature: 1 = inside the object mask.
  std::vector<uint8_t> on_object(size_t photo, std::span<const float> xy) const;
  // Per feature: bit `1 << class` where it lies in the mask. Without a mask a photo has no class bits, except that all of it is
  // object.
  std::vector<uint8_t> classes_at(size_t photo, std::span<const float> xy) const;
  bool has_mask(MaskClass kind, size_t photo) const { return has(kind) && masks_[size_t(kind)]->file(photo).has_value(); }
  double longest_side(size_t photo) const { return sides_[photo]; }

 private:
  Turntable turntable_;
  std::vector<std::pair<int, int>> sizes_;
  std::vector<double> sides_;
  std::array<std::optional<PhotoMasks>, kMaskClassCount> masks_;
  size_t other_shape_ = 0;
};

// Features used, of those that the other masks keep. ByTurntable: all, or those of the object if it turns (turntable.h).
enum class UsedFeatures { ByTurntable, All, Surroundings };

// Effect of the masks on the features of a capture.
struct MaskEffect {
  std::array<size_t, kMaskClassCount> photos{}, removed{};  // photos with a mask; features that this class removes
  size_t before = 0, after = 0;                             // features; a feature in two masks counts once
  std::vector<size_t> removed_of_photo;                     // [photo]
  Turntable turntable = Turntable::Auto;                    // the option
  bool object_applied = false;
  std::optional<TurntableEvidence> evidence;  // for "auto" with masks of the object
};

// Removes masked features from `features`; returns, per photo, the previous indices of the remaining features. `photo_of[i]`:
// photo index of features[i].
std::vector<std::vector<uint32_t>> suppress_features(const FeatureMasks& masks, UsedFeatures used,
                                                     std::span<const size_t> photo_of, std::vector<PhotoFeatures>& features,
                                                     MaskEffect& effect);

}  // namespace vitrine
