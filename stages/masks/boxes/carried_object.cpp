#include "stages/masks/boxes/carried_object.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/intake/masks/photo_marks.h"
#include "core/observe/stereo/box_fit.h"
#include "core/observe/stereo/revolution_fit.h"
#include "core/observe/stereo/shape_fit.h"
#include "core/observe/stereo/upright_edges.h"
#include "core/observe/stereo/visual_hull.h"
#include "stages/masks/boxes/outlines.h"

namespace vitrine {

namespace {

constexpr size_t kFewestTight = 3;  // polygons for a tight visual hull
constexpr int kPastRounds = 2;
constexpr double kEdgesMayDiffer = 0.02;  // IoU loss allowed for a box refined on image edges, against the fit to the marks
constexpr double kSticksOut = 0.2;        // of a solid's radius: surface beyond it is an appendage, nearer it is the outline

// Even-odd rule at pixel centres.
std::vector<uint8_t> filled(std::span<const Vec2d> outline, const Intrinsics& full, const Intrinsics& k) {
  std::vector<uint8_t> inside(k.pixel_count(), 0);
  const double sx = double(k.width) / full.width, sy = double(k.height) / full.height;
  std::vector<double> crossings;
  for (int y = 0; y < k.height; ++y) {
    crossings.clear();
    const double v = y + 0.5;
    for (size_t i = 0; i < outline.size(); ++i) {
      const Vec2d a{outline[i].x * sx, outline[i].y * sy};
      const Vec2d &end = outline[(i + 1) % outline.size()], b{end.x * sx, end.y * sy};
      if ((a.y <= v) != (b.y <= v)) crossings.push_back(a.x + (v - a.y) / (b.y - a.y) * (b.x - a.x));
    }
    std::sort(crossings.begin(), crossings.end());
    for (size_t c = 0; c + 1 < crossings.size(); c += 2)
      for (int x = std::max(0, int(std::ceil(crossings[c] - 0.5))); x < k.width && x + 0.5 <= crossings[c + 1]; ++x)
        inside[k.index(x, y)] = 1;
  }
  return inside;
}

bool touches_border(const std::vector<uint8_t>& inside, const Intrinsics& k) {
  const auto at = [&](int x, int y) { return inside[k.index(x, y)] != 0; };
  for (int x = 0; x < k.width; ++x)
    if (at(x, 0) || at(x, k.height - 1)) return true;
  for (int y = 0; y < k.height; ++y)
    if (at(0, y) || at(k.width - 1, y)) return true;
  return false;
}

// Tight marks include lids, which GrabCut assigns to the background.
std::vector<SurfaceOfRevolution> solids_of_hull(const VisualHull& marked, const std::vector<View>& views) {
  std::vector<Silhouette> seen;
  const std::vector<std::vector<uint8_t>> inside = silhouettes_of(marked, views);
  for (size_t v = 0; v < views.size(); ++v) seen.push_back(silhouette(views[v], inside[v]));
  return surfaces_of_revolution(seen, marked.surface(), marked.voxel());
}

// Replaces the body by its surface of revolution. GrabCut removes bright lids and, in single photos, appendages, and fails where
// a mirror looks like its background. The body is the surface of revolution fitted to the outlines of all photos and refined on
// image edges. Appendages are taken from the voted hull or, with tight marks, from the hull of the marks; parts of these hulls
// along the outline of the body are removed.
void turn(std::span<const SurfaceOfRevolution> solids, const VisualHull& voted, const VisualHull* marked,
          const std::vector<View>& views, std::vector<std::vector<uint8_t>>& inside) {
  parallel_for(views.size(), 1, [&](size_t v) {
    if (interrupt_signal() != 0) return;
    std::vector<uint8_t> turned(inside[v].size(), 0);
    for (const SurfaceOfRevolution& solid : solids) {
      const std::vector<uint8_t> outline = silhouette_mask(solid, views[v]);
      for (size_t i = 0; i < turned.size(); ++i) turned[i] |= outline[i];
    }
    // Remaining hull pixels, and those far from the body.
    std::vector<uint8_t> off(turned.size(), 0), far(turned.size(), 0);
    mask_of_rays(views[v], [&](size_t pixel, const Vec3d& eye, const Vec3d& direction) {
      if (turned[pixel]) return false;
      for (const VisualHull* hull : {&voted, marked}) {
        if (hull == nullptr) continue;
        const auto hit = hull->first_hit(eye, direction);
        if (!hit) continue;
        const Vec3d place = eye + hit->t * direction;
        double distance = 1e300, radius = 0;
        for (const SurfaceOfRevolution& solid : solids) {
          const double d = length(solid.nearest(place).position - place);
          if (d < distance) distance = d, radius = solid.largest_radius();
        }
        if (hull == &voted || distance > voted.voxel()) off[pixel] = 1;
        if (distance > kSticksOut * radius) far[pixel] = 1;
      }
      return false;
    });
    inside[v] = with_appendages(turned, off, far, views[v].intrinsics);
  });
  throw_if_interrupted();
}

// Segmented outlines of an object in the photos, and the hull that they vote for.
struct FoundOutlines {
  std::vector<Silhouette> outlines;  // [view]; empty image: none found
  VisualHull hull;

  std::vector<Silhouette> votes() const {
    std::vector<Silhouette> found;
    std::ranges::copy_if(outlines, std::back_inserter(found), [](const Silhouette& outline) { return !outline.value.empty(); });
    return found;
  }
};

bool is_tight(const MarkedObject& object) {
  return object.marks.size() >= kFewestTight && std::ranges::none_of(object.marks, &Mark::box);
}

// Propagation of one object. Uses GrabCut unless background prediction applies.
class Carrier {
 public:
  Carrier(const CarryDesc& desc, const MarkedObject& object)
      : capture_(desc.capture),
        views_(desc.views),
        photos_(desc.photos),
        object_(object),
        mark_of_(views_.size(), nullptr),
        drawn_(views_.size()),
        tight_(is_tight(object)) {
    if (desc.stereo != nullptr && mirror_in_boxes(object)) past_.emplace(*desc.stereo);
    size_t whole = 0;  // photos that show all of it: points outside their view are not part of the object
    for (const Mark& mark : object.marks) {
      const Intrinsics& k = views_[mark.view].intrinsics;
      mark_of_[mark.view] = &mark;
      drawn_[mark.view] = filled(mark.outline, capture_.set.views[mark.view].intrinsics, k);
      cones_.push_back(silhouette(views_[mark.view], drawn_[mark.view]));
      whole += !touches_border(drawn_[mark.view], k);
    }
    hull_desc_ = {.resolution = desc.hull_voxels,
                  .rule = {.fewest_views = std::max<size_t>(whole, 2)},
                  .one_piece = true,
                  .most_one_sided = kMostOneSided};
    marked_ = VisualHull(cones_, hull_desc_);
  }

  bool marks_meet() const { return !marked_.empty(); }

  [[noreturn]] void throw_disagree() const {
    throw Error(ErrorKind::Input, fmt::format("the marks of '{}' do not meet", object_.name),
                {.why = marked_.one_sidedness() > kMostOneSided
                            ? "the marked photos look from the same side, so that its distance is unknown"
                            : fmt::format("no point of space lies inside the marks of all {} photos", object_.marks.size()),
                 .hint = "mark the whole object, and the same object, in photos from different sides",
                 .code = "MARKS_DISAGREE"});
  }

  CarriedObject carry() const {
    CarriedObject out;
    out.inside = silhouettes_of(marked_, views_);
    out.doubted.resize(views_.size());
    out.summary = {.name = object_.name, .word = object_.word, .kind = object_.kind, .marks = object_.marks.size()};
    const Vec3d extent = marked_.bounds().high - marked_.bounds().low;
    out.summary.edge = std::max({extent.x, extent.y, extent.z});
    for (size_t v = 0; v < views_.size(); ++v) out.doubted[v].assign(out.inside[v].size(), 0);
    out.hull = marked_;
    FoundOutlines found;
    if (object_.kind == MaskClass::Transparent) {
      if (tight_) take_box_of_marks(out);
    } else {
      found = past_ ? outlines_past() : outlines_by_colour(out.inside);
      for (size_t v = 0; v < views_.size(); ++v)
        out.summary.refined +=
            !is_polygon(v) && std::ranges::any_of(found.outlines[v].value.data(), [](float c) { return c > 0; });
      if (!found.hull.empty()) take_shape(found, out), out.hull = found.hull;
      doubt(found, out);
    }
    for (size_t v = 0; v < views_.size(); ++v) {
      if (is_polygon(v)) {
        out.inside[v] = drawn_[v];
        std::ranges::fill(out.doubted[v], uint8_t(0));
      } else if (mark_of_[v] != nullptr) {
        for (size_t i = 0; i < drawn_[v].size(); ++i) out.inside[v][i] &= drawn_[v][i];
      }
    }
    out.passed.resize(views_.size());
    parallel_for(views_.size(), 1, [&](size_t v) { out.passed[v] = hull_depths(out.hull, views_[v]); });
    return out;
  }

 private:
  bool is_polygon(size_t v) const { return mark_of_[v] != nullptr && !mark_of_[v]->box; }

  // Replaces the hull of glass by a box if the marks are silhouettes of a box.
  void take_box_of_marks(CarriedObject& out) const {
    const std::optional<BoxFit> fit = fit_box(cones_, marked_.bounds());
    if (!fit) return;
    Box box = drawn_to_edges(fit->box, edge_photos(capture_, 2 * kSmallSide));
    if (agreement(cones_, box) < fit->agreement - kEdgesMayDiffer) box = fit->box;  // the edges are not those of the box
    for (size_t v = 0; v < views_.size(); ++v) out.inside[v] = silhouette_mask(box, views_[v]);
    out.summary.box_agreement = fit->agreement;
  }

  // Outlines by background prediction; a tighter hull lets more photos predict the background.
  FoundOutlines outlines_past() const {
    HullDesc desc = hull_desc_;
    desc.within = past_->sides(marked_);
    FoundOutlines found{std::vector<Silhouette>(views_.size()), VisualHull(cones_, desc)};
    desc.rule = kOutlineVote;
    const std::vector<std::vector<uint8_t>> hidden = past_->hidden(marked_);
    for (int round = 0; round < kPastRounds && !found.hull.empty(); ++round) {
      found.outlines = past_->outlines(found.hull, hidden);
      for (size_t v = 0; v < views_.size(); ++v)
        if (is_polygon(v)) found.outlines[v] = silhouette(views_[v], drawn_[v]);
      found.hull = VisualHull(found.outlines, desc);
    }
    return found;
  }

  FoundOutlines outlines_by_colour(const std::vector<std::vector<uint8_t>>& about) const {
    FoundOutlines found{std::vector<Silhouette>(views_.size()), {}};
    parallel_for(views_.size(), 1, [&](size_t v) {
      if (interrupt_signal() != 0) return;
      const std::vector<uint8_t> inside = is_polygon(v) ? drawn_[v] : grab_cut(photos_[v], about[v], tight_);
      if (!inside.empty()) found.outlines[v] = silhouette(views_[v], inside);
    });
    throw_if_interrupted();
    HullDesc desc = hull_desc_;
    desc.rule = kOutlineVote;
    found.hull = VisualHull(found.votes(), desc);
    return found;
  }

  // Silhouettes of the fitted shape: a box, surfaces of revolution with their appendages, or the hull.
  void take_shape(const FoundOutlines& found, CarriedObject& out) const {
    const FittedShapes fits = fit_shapes(found.votes(), found.hull);
    if (fits.box)
      for (size_t v = 0; v < views_.size(); ++v) out.inside[v] = silhouette_mask(fits.box->box, views_[v]);
    else
      out.inside = silhouettes_of(found.hull, views_);
    out.summary.voted = true;
    out.summary.solids = fits.solids.size();
    if (fits.solids.empty()) return;
    std::vector<SurfaceOfRevolution> solids = tight_ ? solids_of_hull(marked_, views_) : std::vector<SurfaceOfRevolution>{};
    if (solids.empty()) solids = fits.solids;
    const std::vector<EdgePhoto> edges = edge_photos(capture_, 2 * kSmallSide);
    for (SurfaceOfRevolution& solid : solids) solid = drawn_to_edges(solid, edges);
    turn(solids, found.hull, tight_ ? &marked_ : nullptr, views_, out.inside);
  }

  // Marks the pixels where outline and shape disagree; occluded pixels are removed from the mask.
  void doubt(const FoundOutlines& found, CarriedObject& out) const {
    for (size_t v = 0; v < views_.size(); ++v) {
      const std::span<const float> value = found.outlines[v].value.data();
      for (size_t i = 0; i < value.size(); ++i)
        if (value[i] < 0)
          out.inside[v][i] = 0;
        else
          out.doubted[v][i] = (value[i] > 0) != (out.inside[v][i] != 0);
    }
  }

  const MaskCapture& capture_;
  const std::vector<View>& views_;
  const std::vector<SmallPhoto>& photos_;
  std::optional<PastOutlines> past_;
  const MarkedObject& object_;
  std::vector<const Mark*> mark_of_;         // [view]
  std::vector<std::vector<uint8_t>> drawn_;  // [view][h,w] filled marks; empty: not marked
  std::vector<Silhouette> cones_;            // silhouettes of the marks
  bool tight_;                               // polygons with a tight visual hull
  HullDesc hull_desc_;
  VisualHull marked_;  // hull of the marks
};

}  // namespace

bool mirror_in_boxes(const MarkedObject& object) { return object.kind == MaskClass::Specular && !is_tight(object); }

CarriedObject carry_object(const CarryDesc& desc, const MarkedObject& object) {
  const Carrier carrier(desc, object);
  if (!carrier.marks_meet()) carrier.throw_disagree();
  return carrier.carry();
}

std::optional<CarriedObject> carry_if_marks_meet(const CarryDesc& desc, const MarkedObject& object) {
  const Carrier carrier(desc, object);
  if (!carrier.marks_meet()) return std::nullopt;
  return carrier.carry();
}

}  // namespace vitrine
