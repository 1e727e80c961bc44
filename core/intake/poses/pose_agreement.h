// How well cameras and poses agree with photos. Three witnesses, from the cheapest to the most independent:
//
//   own points  a model's observations against its own points: are poses and points of one model?
//   pictures    what the photos show at the observations of one track: are the poses of *these* photos? The same place looks
//   alike in
//               two photos; so two observations of a track should look more alike than two of different tracks. The share of such
//               comparisons that the track wins is 0.5 for poses of other photos, whatever the scene shows.
//   matches     features that match between two photos (found without the poses) against the epipolar geometry of the poses, and
//               their depths. Sampson's distance in pixels, with f the focal lengths and x = (u, v, 1) undistorted directions:
//                 |x_b' E x_a| / sqrt(((E x_a)_1^2 + (E x_a)_2^2) / f_b^2 + ((E' x_b)_1^2 + (E' x_b)_2^2) / f_a^2),  E = [t] R
//
// Each gives a share of tests that agree, over all photos and for each.
#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/scene/camera/colmap_model.h"
#include "core/scene/image/image.h"

namespace vitrine {

struct AgreementCount {
  size_t tests = 0, agree = 0;
  double share() const { return tests > 0 ? double(agree) / double(tests) : 0; }
};

struct PairAgreement {
  std::string a, b;  // photo names
  AgreementCount count;
};

struct Agreement {
  AgreementCount all;
  std::vector<PairAgreement> pairs;  // own points: a photo with itself
  // Median over all tests that have one: pixels (matches, own points), or difference of colours in 0..1 (pictures).
  double offset = 0;
  double share() const { return all.share(); }
};

// Photos whose tests mostly fail while the others agree: the worst goes first, and takes its pairs along, so that its neighbours
// are not blamed. Empty when most photos would go.
std::vector<std::pair<std::string, AgreementCount>> disagreeing_photos(const Agreement& agreement, double least_share);

// Matches between two photos of a capture.
struct PhotoMatches {
  std::string a, b;               // photo names
  std::vector<Vec2d> in_a, in_b;  // pixels, same length
};

// Of the longest side; at least a few pixels. Poses of phones (ARKit, ARCore) are off by up to 20 pixels of 1920: they agree.
inline constexpr double kAgreementTolerance = 0.015;
double agreement_tolerance_px(const ColmapCamera& camera, double of_longest_side = kAgreementTolerance);

// At most about `most` of them, from all pairs alike.
std::vector<PhotoMatches> thinned(std::span<const PhotoMatches> matches, size_t most);

// Matches that stay in place take no part.
Agreement matches_agreement(const ColmapModel& poses, std::span<const PhotoMatches> matches,
                            double tolerance = kAgreementTolerance);
Agreement own_points_agreement(const ColmapModel& model);

// The pictures of a model's photos, reduced to what comparisons need.
class TrackPictures {
 public:
  // `picture`: of an image of the model, any size of the same shape, sRGB.
  TrackPictures(const ColmapModel& model, const std::function<Image8(const ColmapImage&)>& picture);
  // `model`: the same photos, perhaps with other poses and observations.
  Agreement agreement(const ColmapModel& model) const;

 private:
  std::map<std::string, Image8> pictures_;
};

}  // namespace vitrine
