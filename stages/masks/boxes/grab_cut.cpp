#include "stages/masks/boxes/grab_cut.h"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace vitrine {

namespace {

constexpr int kIterations = 4;
constexpr size_t kFewestPixels = 40;
constexpr double kMargin = 0.12;  // of the silhouette's width: background beyond, perhaps thing up to there
constexpr double kLeast = 0.2;    // of the silhouette that must be found

}  // namespace

std::vector<uint8_t> grab_cut(const SmallPhoto& photo, const std::vector<uint8_t>& about, bool tight) {
  const Intrinsics& k = photo.view.intrinsics;
  const size_t pixels = about.size(), inside = size_t(std::count(about.begin(), about.end(), 1));
  if (inside < kFewestPixels) return {};
  cv::Mat bgr(k.height, k.width, CV_8UC3), hull(k.height, k.width, CV_8UC1), wide, core;
  for (size_t i = 0; i < pixels; ++i) {
    for (size_t c = 0; c < 3; ++c)
      bgr.data[3 * i + c] = uint8_t(std::lround(255 * std::clamp(photo.srgb[(2 - c) * pixels + i], 0.f, 1.f)));
    hull.data[i] = about[i];
  }
  const int reach = std::max(2, int(std::lround(kMargin * std::sqrt(double(inside)))));
  cv::dilate(hull, wide, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * reach + 1, 2 * reach + 1}));
  if (tight) cv::erode(hull, core, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * reach + 1, 2 * reach + 1}));
  cv::Mat labels(k.height, k.width, CV_8UC1);
  for (size_t i = 0; i < pixels; ++i)
    labels.data[i] = uint8_t(tight && core.data[i] ? cv::GC_FGD
                             : about[i]            ? cv::GC_PR_FGD
                             : wide.data[i]        ? cv::GC_PR_BGD
                                                   : cv::GC_BGD);
  if (size_t(cv::countNonZero(wide)) + kFewestPixels > pixels) return {};  // nothing is surely background
  cv::setRNGSeed(1);  // its k-means draws; the generator is this thread's own
  cv::Mat background, foreground;
  cv::grabCut(bgr, labels, {}, background, foreground, kIterations, cv::GC_INIT_WITH_MASK);
  std::vector<uint8_t> found(pixels);
  size_t kept = 0;
  for (size_t i = 0; i < pixels; ++i) {
    found[i] = labels.data[i] == cv::GC_PR_FGD || labels.data[i] == cv::GC_FGD;
    kept += found[i] && about[i];
  }
  if (double(kept) < kLeast * double(inside)) return {};
  return found;
}

}  // namespace vitrine
