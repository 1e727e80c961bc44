// Albedo scale from a card of known albedo in one photo: "photo:x,y,w,h", pixels of the undistorted photo (images/<photo>).
//
// If the scene contains the card, its albedo is that of its surfels. Otherwise, because the object was trained alone, the card's
// radiance C is measured in the photo, and its albedo is that of an unshadowed horizontal patch:
//   rho = pi C / E(up),   E(n) = integral of L max(0, n.l) dOmega over the solved light
// C has the unit of the surfels' radiance: the photo is divided by its gain, measured on the object in the same photo.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/scene/camera/scale_bar_length.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"

namespace vitrine {

using GreyCard = CardBox;

// Median over the box in a picture of the view at any size. Throws Error{Input} if the box is empty.
Vec3f median_in(const GreyCard& card, const View& view, const ImageF& picture);

// Share of the box with content in a picture of the view.
double shown_share(const GreyCard& card, const View& view, const ImageF& picture);
// Median over the box in the linear photo of the view, without overexposed pixels. Throws Error{Input} with too few pixels, or if
// the box is too dark.
Vec3f photographed(const GreyCard& card, const View& view, const ImageF& photo);
// Ratio of the linear photo of a view to the rendered scene (`rendered`, at any size; 0 = no surface): median over the pixels,
// per channel. This is the gain of the view; the gains of the sfm stage may drift around the object, and their errors would be
// albedo errors. Empty if the photo shows too little of the scene.
std::optional<Vec3f> gain_by_scene(const ImageF& photo, const ImageF& rendered);
// Albedo of a card outside the trained scene.
struct CardInPhoto {
  Vec3f albedo{};
  std::optional<Vec3f> drift = std::nullopt;  // gain_by_scene / the view's gain, if they differ more than usual
};
struct PhotoOfCard {
  const ImageF& photo;     // linear
  const ImageF& rendered;  // rendered scene
  Vec3f light{};           // irradiance of an upward patch
};
CardInPhoto albedo_of_card(const GreyCard& card, const View& view, const PhotoOfCard& seen);
// Up direction for a card outside the trained scene: +z in the first pass, which the scene frame is levelled with; in other
// passes the mean up vector of their cameras, because each pass surrounds the object. Throws Error{Input} if the mean has no
// direction.
Vec3f up_in_photo(const View& view, const std::vector<View>& views, const Passes& passes);

}  // namespace vitrine
