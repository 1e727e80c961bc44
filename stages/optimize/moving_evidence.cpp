#include "stages/optimize/moving_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/scene/camera/projection.h"
#include "core/observe/stereo/patch_score.h"

namespace vitrine {

namespace {

// Offsets in name order of the photos compared at the same image position; they span a ring capture.
constexpr std::array<int, 6> kApart{1, 2, 3, 5, 8, 13};
constexpr double kOtherDirection = 0.087;  // radians; far content moves by more than a patch
constexpr float kAlike = 0.8f;             // correlation
constexpr float kSameBrightness = 0.05f;   // mean brightness difference of textured patches
constexpr float kSamePlain = 0.02f;        // mean brightness difference of textureless patches
constexpr float kFine = 0.02f;             // of brightness: above noise
constexpr size_t kFewestInPlace = 2, kFewestPlain = 4;
constexpr double kMostPlain = 0.9;
constexpr size_t kFewestNeighbours = 2;
constexpr double kHidden = 0.95;  // relative depth: nearer surfaces occlude
// Votes in the window: at least 20 % of its pixels must vote, and the majority must be 2:1.
constexpr int kWindow = 3;
constexpr double kFewestVotes = 0.2, kMajority = 2;
// Static rooms: textured pixels in place 0 to 3 % (a white plate's rim), unexplained 7 to 16 %. Turntables: in place 40 % and
// more on a tripod; 9 %, and 33 % unexplained, with a handheld camera that sways by 7 degrees.
constexpr double kMovesInPlace = 0.15, kMovesPlain = 0.3, kMovesUnexplained = 0.4;
constexpr double kSomeInPlace = 0.04, kSomeUnexplained = 0.25;

double angle_between(const View& a, const View& b) {
  const Mat3d r = b.cam_from_world.rotation * transposed(a.cam_from_world.rotation);
  return std::acos(std::clamp((r.c0.x + r.c1.y + r.c2.z - 1) / 2, -1.0, 1.0));
}

struct EvidenceSurvey {
  const Capture& capture;
  const Targets& targets;
  const DenseDepth& dense;

  bool inside(size_t photo, size_t pixel) const {
    const auto& mask = targets.photos[photo][dense.level].masks[size_t(MaskClass::Object)];
    return !mask.empty() && mask[pixel] >= 128;
  }

  // Training photos with other view directions, near in name order.
  std::vector<uint32_t> elsewhere(size_t t) const {
    const View& view = dense.photos[capture.train[t]].view;
    std::vector<uint32_t> list;
    for (int apart : kApart)
      for (int sign : {-1, 1}) {
        const auto count = int(capture.train.size()), at = int(t) + sign * apart;
        const uint32_t other = capture.train[size_t((at % count + count) % count)];
        const Intrinsics& k = dense.photos[other].view.intrinsics;
        if (k.width != view.intrinsics.width || k.height != view.intrinsics.height) continue;
        if (angle_between(view, dense.photos[other].view) < kOtherDirection) continue;
        if (std::find(list.begin(), list.end(), other) == list.end()) list.push_back(other);
      }
    return list;
  }

  size_t in_place(const ReferencePatch& patch, std::span<const uint32_t> others, int x, int y) const {
    constexpr Vec3d kNoPlane{};
    const Transfer same{.rotation_part = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .translation_part = {}, .centre = {}};
    size_t alike = 0, seen = 0;
    for (uint32_t other : others) {
      const ImageF& luma = dense.photos[other].luma;
      if (inside(other, luma.index(x, y))) continue;
      const float difference = patch_difference(patch, luma, same, kNoPlane, x + 0.5, y + 0.5);
      if (difference < 0) continue;
      ++seen;
      if (patch.flat())
        alike += difference < kSamePlain;
      else
        alike += difference < kSameBrightness && patch_score(patch, luma, same, kNoPlane, x + 0.5, y + 0.5) > kAlike;
    }
    if (patch.flat()) return seen >= kFewestPlain && double(alike) >= kMostPlain * double(seen) ? alike : 0;
    return alike >= kFewestInPlace ? alike : 0;
  }

  // Number of neighbours that see the pixel's position at the extended depth without an occluder.
  size_t neighbours_that_look(const StereoPhoto& photo, const DepthMap& map, int x, int y) const {
    const Vec3d at =
        inverse(photo.view.cam_from_world) * (double(map.zdepth[map.index(x, y)]) * photo.view.intrinsics.ray(x + 0.5, y + 0.5));
    size_t count = 0;
    for (uint32_t n : photo.neighbours) {
      const View& view = dense.photos[n].view;
      const DepthMap& other = dense.maps[n];
      const auto p = image_point(at, view, 0, kPatchRadius);
      if (!p) continue;
      const size_t pixel = size_t(p->y) * size_t(view.intrinsics.width) + size_t(p->x);
      if (!other.zdepth.empty() && other.reliable(pixel) && double(other.zdepth[pixel]) < kHidden * p->z) continue;
      count += !inside(n, pixel);
    }
    return count;
  }
};

float range_around(const ImageF& luma, int x, int y) {
  float least = luma.at(x, y), most = least;
  for (int v = std::max(0, y - 1); v <= std::min(luma.height() - 1, y + 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(luma.width() - 1, x + 1); ++u)
      least = std::min(least, luma.at(u, v)), most = std::max(most, luma.at(u, v));
  return most - least;
}

// Pixels inside the mask or within one patch of it.
std::vector<uint8_t> widened(std::span<const uint8_t> mask, int width, int height) {
  std::vector<uint8_t> wide(size_t(width) * size_t(height), 0);
  if (mask.empty()) return wide;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (mask[size_t(y) * size_t(width) + size_t(x)] < 128) continue;
      for (int v = std::max(0, y - kPatchRadius); v <= std::min(height - 1, y + kPatchRadius); ++v)
        for (int u = std::max(0, x - kPatchRadius); u <= std::min(width - 1, x + kPatchRadius); ++u)
          wide[size_t(v) * size_t(width) + size_t(u)] = 1;
    }
  return wide;
}

// Majority vote of the surrounding pixels.
std::vector<Evidence> voted(const PhotoEvidence& photo) {
  std::vector<Evidence> result = photo.pixels;
  for (int y = 0; y < photo.height; ++y)
    for (int x = 0; x < photo.width; ++x) {
      const size_t i = size_t(y) * size_t(photo.width) + size_t(x);
      if (photo.pixels[i] == Evidence::Object) continue;
      int still = 0, moves = 0, all = 0;
      for (int v = std::max(0, y - kWindow); v <= std::min(photo.height - 1, y + kWindow); ++v)
        for (int u = std::max(0, x - kWindow); u <= std::min(photo.width - 1, x + kWindow); ++u) {
          const Evidence e = photo.pixels[size_t(v) * size_t(photo.width) + size_t(u)];
          still += e == Evidence::Still, moves += e == Evidence::Moves, all += e != Evidence::Object;
        }
      result[i] = Evidence::None;
      if (still + moves < kFewestVotes * all) continue;
      if (still > kMajority * moves) result[i] = Evidence::Still;
      if (moves > kMajority * still) result[i] = Evidence::Moves;
    }
  return result;
}

}  // namespace

double EvidenceCounts::part(size_t n) const { return n > 0 ? double(n) / double(still + unexplained + in_place + plain) : 0; }

bool EvidenceCounts::moving() const { return moving_by_texture() || part(in_place + plain) >= kMovesPlain; }

bool EvidenceCounts::moving_by_texture() const {
  const double in_place_share = part(in_place), unlike = part(unexplained + in_place);
  return in_place_share >= kMovesInPlace || unlike >= kMovesUnexplained ||
         (in_place_share >= kSomeInPlace && unlike >= kSomeUnexplained);
}

MovingEvidence moving_evidence(const Capture& capture, const Targets& targets, const DenseDepth& dense) {
  const EvidenceSurvey survey{capture, targets, dense};
  MovingEvidence evidence;
  evidence.photos.resize(capture.photos.size());
  std::vector<EvidenceCounts> counts(capture.train.size());
  parallel_for(capture.train.size(), 1, [&](size_t t) {
    throw_if_interrupted();
    const uint32_t v = capture.train[t];
    const StereoPhoto& photo = dense.photos[v];
    const DepthMap& map = dense.maps[v];
    if (map.zdepth.empty()) return;
    const std::vector<uint32_t> others = survey.elsewhere(t);
    const auto& masks = targets.photos[v][dense.level].masks;
    const auto& ignore = masks[size_t(MaskClass::Ignore)];
    const std::vector<uint8_t> object = widened(masks[size_t(MaskClass::Object)], map.width, map.height);
    PhotoEvidence& of = evidence.photos[v];
    of.width = map.width, of.height = map.height;
    of.pixels.assign(object.size(), Evidence::None);
    of.plain.assign(object.size(), 0);
    of.fine.assign(object.size(), 0);
    EvidenceCounts& count = counts[t];
    for (int y = 0; y < map.height; ++y)
      for (int x = 0; x < map.width; ++x) {
        const size_t i = map.index(x, y);
        of.fine[i] = range_around(photo.luma, x, y) > kFine;
        if (object[i]) of.pixels[i] = Evidence::Object;
        if (object[i] || (!ignore.empty() && ignore[i] >= 128)) continue;
        ++count.all;
        if (map.reliable(i)) {
          of.pixels[i] = Evidence::Still, ++count.still;
          continue;
        }
        const ReferencePatch patch = reference_patch(photo.luma, x, y);
        const bool in_place = survey.in_place(patch, others, x, y) > 0;
        if (patch.flat()) {
          count.plain += in_place, of.plain[i] = in_place;
        } else if (in_place) {
          of.pixels[i] = Evidence::Moves, ++count.in_place;
        } else if (survey.neighbours_that_look(photo, map, x, y) >= kFewestNeighbours) {
          of.pixels[i] = Evidence::Moves, ++count.unexplained;
        }
      }
    of.pixels = voted(of);
  });
  for (const EvidenceCounts& c : counts) {
    evidence.counts.all += c.all, evidence.counts.still += c.still, evidence.counts.unexplained += c.unexplained;
    evidence.counts.in_place += c.in_place, evidence.counts.plain += c.plain;
  }
  return evidence;
}

}  // namespace vitrine
