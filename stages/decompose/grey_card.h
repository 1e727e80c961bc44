// A card of known albedo in one photo: "photo:x,y,w,h", pixels of the undistorted photo (images/<photo>).
//
// Where the scene shows the card, its albedo is that of its surfels. Where it does not, because the object was trained alone,
// the card's radiance C is read from the photo, and its albedo is that of a horizontal patch which nothing shades:
//   rho = pi C / E(up),   E(n) = integral of L max(0, n.l) dOmega over the solved light
// C is in the unit of the surfels' radiance: the photo is divided by its gain, measured on the object in the same photo.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/scene/camera/passes.h"
#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"

namespace vitrine {

struct GreyCard {
  size_t view = 0;
  int x = 0, y = 0, width = 0, height = 0;
};

// Throws Error{Usage} when the text is not of that form, names no photo or a box outside of it.
GreyCard parse_grey_card(const std::string& text, const std::vector<View>& views);
// Median over the box of a picture of the view at any size. Throws Error{Input} when nothing is there.
Vec3f median_in(const GreyCard& card, const View& view, const ImageF& picture);

// Share of the box in which a picture of the view shows something.
double shown_share(const GreyCard& card, const View& view, const ImageF& picture);
// Median over the box of the linear photo of the view; overexposed pixels do not count. Throws Error{Input} when too few pixels
// are left, or the box is too dark.
Vec3f photographed(const GreyCard& card, const View& view, const ImageF& photo);
// How much brighter the linear photo of a view is than the scene in it (`rendered`, at any size; 0 where nothing is): median over
// the pixels, per channel. That is the gain of the view; but gains that the sfm stage solved may drift around the object, and
// their errors would be errors of all albedos. Nothing when the photo shows too little of the scene.
std::optional<Vec3f> gain_by_scene(const ImageF& photo, const ImageF& rendered);
// A card beside the trained scene.
struct CardInPhoto {
  Vec3f albedo{};
  std::optional<Vec3f> drift = std::nullopt;  // gain_by_scene / the view's gain, where they differ by more than is usual
};
struct PhotoOfCard {
  const ImageF& photo;     // linear
  const ImageF& rendered;  // the scene in it
  Vec3f light{};           // irradiance of what looks up
};
CardInPhoto albedo_of_card(const GreyCard& card, const View& view, const PhotoOfCard& seen);
// Up in the scene for what stands beside the object in a photo: +z in the first pass, whose photos the scene's frame is
// levelled with; in others the mean up vector of the pass' cameras, for each pass goes around the object. Throws Error{Input}
// where that has no direction.
Vec3f up_in_photo(const View& view, const std::vector<View>& views, const Passes& passes);

}  // namespace vitrine
