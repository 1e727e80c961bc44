// Consistency of cameras and poses with photos. Three tests, from the cheapest to the most independent:
//
//   own points  a model's observations against its own points: do poses and points belong to one model?
//   pictures    image patches at the observations of one track: do the poses belong to *these* photos? One scene point looks
//               alike in two photos, so two observations of a track should look more alike than two of different tracks. The
//               share of comparisons that the track wins is 0.5 for poses of other photos, for any scene.
//   matches     feature matches between two photos (found without the poses) against the epipolar geometry of the poses, and
//               their depths. Sampson distance in pixels, with f the focal lengths and x = (u, v, 1) undistorted directions:
//                 |x_b' E x_a| / sqrt(((E x_a)_1^2 + (E x_a)_2^2) / f_b^2 + ((E' x_b)_1^2 + (E' x_b)_2^2) / f_a^2),  E = [t] R
//
// Each returns the share of consistent tests, over all photos and per pair.
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
  // Median over all tests that have a value: pixels (matches, own points), or colour difference in 0..1 (pictures).
  double offset = 0;
  double share() const { return all.share(); }
};

// Photos whose tests mostly fail while the others pass. The worst is removed first, with its pairs, so that its neighbours are
// not affected. Empty when most photos would be removed.
std::vector<std::pair<std::string, AgreementCount>> disagreeing_photos(const Agreement& agreement, double least_share);

// Matches between two photos of a capture.
struct PhotoMatches {
  std::string a, b;               // photo names
  std::vector<Vec2d> in_a, in_b;  // pixels, same length
};

// Of the longest side; at least a few pixels. Phone poses (ARKit, ARCore) are off by up to 20 of 1920 pixels and must pass.
inline constexpr double kAgreementTolerance = 0.015;
double agreement_tolerance_px(const ColmapCamera& camera, double of_longest_side = kAgreementTolerance);

// Subsamples to about `most` matches, evenly over all pairs.
std::vector<PhotoMatches> thinned(std::span<const PhotoMatches> matches, size_t most);

// Matches that do not move between the photos are ignored.
Agreement matches_agreement(const ColmapModel& poses, std::span<const PhotoMatches> matches,
                            double tolerance = kAgreementTolerance);
Agreement own_points_agreement(const ColmapModel& model);

// Reduced photos of a model, for the picture test.
class TrackPictures {
 public:
  // `picture`: the photo of a model image, sRGB, any size with the same aspect ratio.
  TrackPictures(const ColmapModel& model, const std::function<Image8(const ColmapImage&)>& picture);
  // `model`: the same photos, possibly with other poses and observations.
  Agreement agreement(const ColmapModel& model) const;

 private:
  std::map<std::string, Image8> pictures_;
};

}  // namespace vitrine
