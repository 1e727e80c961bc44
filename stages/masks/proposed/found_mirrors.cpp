#include "stages/masks/proposed/proposed_source.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/observe/stereo/unexplained_pieces.h"
#include "core/observe/stereo/view_dependence.h"
#include "core/scene/camera/projection.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

constexpr double kMargin = 1.5;     // voxels around a piece
constexpr size_t kFewestMarks = 3;  // photos that show all of a piece
constexpr int kReduction = 2;       // downscaling of the photos in which surface points are compared
constexpr float kWhole = 0.999f;    // coverage of a pixel that shows only the object
constexpr double kSlack = 3;        // tolerance of the hull surface, voxels
constexpr size_t kMostPlaces = 4000;
constexpr double kMayMirror = 0.2;       // minimum view dependence of the stereo points of a piece
constexpr double kMayOwnSurface = 0.25;  // minimum share of its pixels with such points
constexpr double kMirror = 0.18;         // minimum for a mirror; matt objects are mostly below .13
constexpr double kOwnSurface = 0.3;      // below this share the piece is a gap in the known surfaces
constexpr double kStereoElsewhere = 4;   // minimum ratio to the share of surfaces in front or behind
constexpr double kPartOfAnother = 0.5;   // of the surface points

// Loose outlines of a piece in the photos that show all of it.
MarkedObject outlined(const UnexplainedPiece& piece, const CarryDesc& desc) {
  MarkedObject object{.name = "specular", .word = {}, .kind = MaskClass::Specular, .marks = {}};
  for (size_t v = 0; v < desc.views.size(); ++v) {
    const Intrinsics &k = desc.views[v].intrinsics, &full = desc.capture.set.views[v].intrinsics;
    std::vector<cv::Point2f> corners, outline;
    bool whole = true;
    for (const Vec3d& place : piece.places) {
      const auto p = projection(place, desc.views[v]);
      const double margin = p ? kMargin * piece.voxel * k.fx / p->z : 0;
      whole = whole && p && in_picture(*p, k, margin);
      if (!whole) break;
      for (const double dx : {-margin, margin})
        for (const double dy : {-margin, margin}) corners.emplace_back(float(p->x + dx), float(p->y + dy));
    }
    if (!whole) continue;
    cv::convexHull(corners, outline);
    Mark mark{.view = v, .box = true, .outline = {}};
    for (const cv::Point2f& p : outline)
      mark.outline.push_back({double(p.x) * full.width / k.width, double(p.y) * full.height / k.height});
    object.marks.push_back(std::move(mark));
  }
  return object;
}

// Pixels of an object and the depths at which their rays pass it.
struct Shown {
  std::span<const std::vector<uint8_t>> inside;  // [view][h,w]
  std::span<const HullDepths> passed;            // [view]
  double slack;                                  // tolerance of the depths
};

struct PieceSeen {
  std::vector<std::vector<uint8_t>> inside;
  std::vector<HullDepths> passed;
};
PieceSeen seen_in(std::span<const View> views, const UnexplainedPiece& piece) {
  PieceSeen out{std::vector<std::vector<uint8_t>>(views.size()), std::vector<HullDepths>(views.size())};
  parallel_for(views.size(), 1, [&](size_t v) {
    const Intrinsics& k = views[v].intrinsics;
    const size_t pixels = k.pixel_count();
    out.inside[v].assign(pixels, 0);
    std::vector<float>&entry = out.passed[v].entry, &exit = out.passed[v].exit;
    entry.assign(pixels, 0.f), exit.assign(pixels, 0.f);
    for (const Vec3d& place : piece.places) {
      const auto p = projection(place, views[v]);
      if (!p) continue;
      const double half = 0.5 * piece.voxel * k.fx / p->z;
      const auto pixel = [](double at, int size) { return int(std::floor(std::clamp(at, -1.0, double(size)))); };
      for (int y = std::max(0, pixel(p->y - half, k.height)); y <= std::min(k.height - 1, pixel(p->y + half, k.height)); ++y)
        for (int x = std::max(0, pixel(p->x - half, k.width)); x <= std::min(k.width - 1, pixel(p->x + half, k.width)); ++x) {
          const size_t i = k.index(x, y);
          const auto z = float(p->z);
          entry[i] = out.inside[v][i] ? std::min(entry[i], z) : z;
          exit[i] = std::max(exit[i], z);
          out.inside[v][i] = 1;
        }
    }
  });
  return out;
}

class MirrorTrial {
 public:
  explicit MirrorTrial(const SmallStereo& stereo) : stereo_(stereo) {
    for (const EdgePhoto& photo : stereo.surroundings().photos) {
      const Intrinsics& k = photo.view.intrinsics;
      photos_.push_back(
          luminance_photo(photo.view, linear_from_srgb_image(photo.srgb), std::max(k.width, k.height) / kReduction));
    }
    spread_ = luminance_spread(photos_);
  }

  // Quick test by the stereo points of a piece: rejects most pieces.
  bool may_be(const UnexplainedPiece& piece) {
    const PieceSeen in = seen_in(stereo_.views(), piece);
    const Shown seen{in.inside, in.passed, kSlack * piece.voxel};
    const StereoPlaces stereo = stereo_places(seen);
    const double by = changes(stereo.places, seen);
    log_debug("masks: a piece of {} voxels, of which stereo sees {:.0f} %, changes by {:.2f}", piece.places.size(),
              100 * stereo.share, by);
    return by >= kMayMirror && stereo.share >= kMayOwnSurface;
  }

  // nullopt: not a mirror.
  std::optional<FoundMirror> mirror(CarriedObject object) {
    FoundMirror found{.object = std::move(object)};
    const Shown seen{found.object.inside, found.object.passed, kSlack * found.object.hull.voxel()};
    const StereoPlaces stereo = stereo_places(seen);
    found.stereo_share = stereo.share;
    found.of_hull = changes(found.object.hull.surface(), seen);
    found.of_stereo = changes(stereo.places, seen);
    log_debug("masks: a piece {:.2f} across changes with the view by {:.2f} and {:.2f}; stereo sees its surface at {:.0f} %",
              found.object.summary.edge, found.of_hull, found.of_stereo, 100 * stereo.share);
    if (std::min(found.of_hull, found.of_stereo) < kMirror || stereo.share < kOwnSurface ||
        stereo.share < kStereoElsewhere * stereo.elsewhere)
      return std::nullopt;
    return found;
  }

 private:
  struct StereoPlaces {
    std::vector<ShapePoint> places;  // on the object
    double share, elsewhere;         // shares of its pixels: with such a point; with a surface in front or behind
  };

  // View dependence of surface points of an object; 0 if too few are visible.
  double changes(const std::vector<ShapePoint>& places, const Shown& seen) {
    const std::span<const View> views = stereo_.views();
    for (size_t v = 0; v < photos_.size(); ++v) {
      ImageF coverage(views[v].intrinsics.width, views[v].intrinsics.height, 1);
      std::ranges::copy(seen.inside[v], coverage.data().begin());
      const ImageF small = resized(coverage, photos_[v].luminance.width(), photos_[v].luminance.height());
      std::ranges::transform(small.data(), photos_[v].inside.begin(), [](float c) { return uint8_t(c > kWhole); });
    }
    const auto hidden = [&](size_t v, const Vec3d& place) {
      const auto p = image_point(place, views[v]);
      if (!p) return true;
      const float entry = seen.passed[v].entry[size_t(p->y) * size_t(views[v].intrinsics.width) + size_t(p->x)];
      return entry > 0 && p->z > double(entry) + seen.slack;
    };
    return view_dependence(places, {.photos = photos_, .photo_spread = spread_, .hidden = hidden}).value_or(0);
  }

  StereoPlaces stereo_places(const Shown& seen) const {
    const Surroundings scene = stereo_.surroundings();
    std::vector<ShapePoint> all;
    size_t pixels = 0, elsewhere = 0;
    for (size_t v = 0; v < scene.photos.size(); ++v) {
      const DepthMap& map = scene.maps[v];
      if (map.zdepth.empty()) continue;
      const View& view = scene.photos[v].view;
      const HullDepths& passed = seen.passed[v];
      const Rigid world_from_cam = inverse(view.cam_from_world);
      for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
          const size_t i = map.index(x, y);
          if (!seen.inside[v][i] || passed.entry[i] == 0) continue;
          ++pixels;
          if (!map.reliable(i)) continue;
          const double z = map.zdepth[i];
          if (z < double(passed.entry[i]) - seen.slack || z > double(passed.exit[i]) + seen.slack) {
            ++elsewhere;
            continue;
          }
          const Vec3f& n = map.normal[i];
          all.push_back({world_from_cam * (z * view.intrinsics.ray(x + 0.5, y + 0.5)),
                         world_from_cam.rotation * Vec3d{double(n.x), double(n.y), double(n.z)}});
        }
    }
    const double count = double(std::max<size_t>(pixels, 1));
    StereoPlaces out{{}, double(all.size()) / count, double(elsewhere) / count};
    const size_t stride = (all.size() + kMostPlaces - 1) / kMostPlaces;
    for (size_t i = 0; i < all.size(); i += stride) out.places.push_back(all[i]);
    return out;
  }

  const SmallStereo& stereo_;
  std::vector<LuminancePhoto> photos_;
  double spread_ = 0;
};

}  // namespace

std::vector<FoundMirror> found_mirrors(const CarryDesc& desc, std::span<const Explanation> explained,
                                       const std::function<void(double)>& progress) {
  const std::vector<UnexplainedPiece> pieces = unexplained_pieces(desc.views, explained);
  MirrorTrial trial(*desc.stereo);
  std::vector<FoundMirror> found;
  for (size_t i = 0; i < pieces.size(); ++i) {
    throw_if_interrupted();
    progress(double(i) / double(pieces.size()));
    const UnexplainedPiece& piece = pieces[i];
    const auto shares = [&](const FoundMirror& other) {
      const auto inside =
          std::ranges::count_if(piece.places, [&](const Vec3d& p) { return other.object.hull.carved().at(p) != 0; });
      return double(inside) > kPartOfAnother * double(piece.places.size());
    };
    if (std::ranges::any_of(found, shares) || !trial.may_be(piece)) continue;
    const MarkedObject object = outlined(piece, desc);
    if (object.marks.size() < kFewestMarks) continue;
    std::optional<CarriedObject> carried = carry_if_marks_meet(desc, object);
    if (!carried || !carried->summary.voted) continue;
    if (std::optional<FoundMirror> mirror = trial.mirror(std::move(*carried))) found.push_back(std::move(*mirror));
  }
  return found;
}

}  // namespace vitrine
