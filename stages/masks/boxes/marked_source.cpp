#include "stages/masks/boxes/marked_source.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/json.h"
#include "core/base/log.h"
#include "core/base/parallel.h"
#include "core/base/process.h"
#include "core/camera/mask_origin.h"
#include "core/camera/photo_marks.h"
#include "core/image/ldr.h"
#include "core/stereo/box_fit.h"
#include "core/stereo/revolution_edges.h"
#include "core/stereo/shape_fit.h"
#include "core/stereo/standing_boxes.h"
#include "core/stereo/visual_hull.h"
#include "stages/masks/boxes/appendage_pixels.h"
#include "stages/masks/boxes/grab_cut.h"
#include "stages/masks/boxes/past_outlines.h"
#include "stages/masks/small_photo.h"

namespace vitrine {

namespace {

constexpr size_t kFewestTight = 3;  // polygons whose hull is nearly the thing
constexpr int kPastRounds = 2;
constexpr double kPastShare = 0.5;                 // of the time: stereo
constexpr float kSoftEdge = 0.7f;                  // pixels of the small photo
constexpr float kCarried = 0.8f, kDoubted = 0.4f;  // confidence
constexpr double kEdgesMayDiffer = 0.02;           // from marks of a box, intersection over union
constexpr double kSticksOut = 0.2;                 // of a solid's radius: nearer to it is its outline

// Even-odd rule at pixel centres.
std::vector<uint8_t> filled(std::span<const Vec2d> outline, const Intrinsics& full, const Intrinsics& k) {
  std::vector<uint8_t> inside(size_t(k.width) * size_t(k.height), 0);
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
        inside[size_t(y) * size_t(k.width) + size_t(x)] = 1;
  }
  return inside;
}

bool touches_border(const std::vector<uint8_t>& inside, const Intrinsics& k) {
  const auto at = [&](int x, int y) { return inside[size_t(y) * size_t(k.width) + size_t(x)] != 0; };
  for (int x = 0; x < k.width; ++x)
    if (at(x, 0) || at(x, k.height - 1)) return true;
  for (int y = 0; y < k.height; ++y)
    if (at(0, y) || at(k.width - 1, y)) return true;
  return false;
}

// Where marks are tight they show lids, too, which GrabCut takes for background.
std::vector<SurfaceOfRevolution> solids_of_hull(const VisualHull& marked, const std::vector<View>& views) {
  std::vector<Silhouette> seen;
  const std::vector<std::vector<uint8_t>> inside = silhouettes_of(marked, views);
  for (size_t v = 0; v < views.size(); ++v) seen.push_back(silhouette(views[v], inside[v]));
  return surfaces_of_revolution(seen, marked.surface(), marked.voxel());
}

// Surfaces of revolution: GrabCut takes away bright lids and, photo by photo, appendages, and leaves the outline where what the
// metal mirrors looks like what is behind it. The body is the solid of revolution that the outlines of all photos agree about,
// put on the photos' edges; what sticks out of it is as in the hull of the votes or, where the marks are tight, of the marks, and
// what these have along its outline alone is no part of the thing.
void turn(std::span<const SurfaceOfRevolution> solids, const VisualHull& voted, const VisualHull* marked,
          const std::vector<View>& views, std::vector<std::vector<uint8_t>>& inside) {
  parallel_for(views.size(), 1, [&](size_t v) {
    if (interrupt_signal() != 0) return;
    std::vector<uint8_t> turned(inside[v].size(), 0);
    for (const SurfaceOfRevolution& solid : solids) {
      const std::vector<uint8_t> outline = silhouette_mask(solid, views[v]);
      for (size_t i = 0; i < turned.size(); ++i) turned[i] |= outline[i];
    }
    // What else is there, and what of it stands far off.
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

// [h,w] z-depth of the hull where a thing is `inside`; that of its middle where the hull has a gap.
std::vector<float> depths_inside(const VisualHull& hull, const View& view, const std::vector<uint8_t>& inside) {
  std::vector<float> depth = hull_depths(hull, view).entry;
  const auto middle = float((view.cam_from_world * (0.5 * (hull.bounds().low + hull.bounds().high))).z);
  for (size_t i = 0; i < depth.size(); ++i)
    if (depth[i] == 0 && inside[i]) depth[i] = middle;
  return depth;
}

struct Carried {
  std::vector<std::vector<uint8_t>> inside, doubted;  // [view][h,w]
  std::vector<std::vector<float>> depth;              // [view][h,w] z-depth of the thing, where it is inside
  MarkedMasks::Thing summary;
};

// Outlines of a thing that were looked for in the photos, and the hull that they vote for.
struct FoundOutlines {
  std::vector<Silhouette> outlines;  // [view]; an empty picture: nothing was found there
  VisualHull hull;

  std::vector<Silhouette> votes() const {
    std::vector<Silhouette> found;
    std::ranges::copy_if(outlines, std::back_inserter(found), [](const Silhouette& outline) { return !outline.value.empty(); });
    return found;
  }
};

// What mirrors has no colour of its own; polygons tell its outline all the same.
bool is_tight(const MarkedThing& thing) {
  return thing.marks.size() >= kFewestTight && std::ranges::none_of(thing.marks, &Mark::box);
}
bool mirror_in_boxes(const MarkedThing& thing) { return thing.kind == MaskClass::Specular && !is_tight(thing); }

// Carries the marks of one thing. `views` are those of the capture at the small size, `photos` the same with their colours;
// nobody looks at them for glass. `past`: looks past the hulls of boxes; nullptr: GrabCut looks for what differs in colour.
class Carrier {
 public:
  Carrier(const BoxesConfig& config, const MaskCapture& capture, const std::vector<View>& views,
          const std::vector<SmallPhoto>& photos, const PastOutlines* past, const MarkedThing& thing)
      : config_(config),
        capture_(capture),
        views_(views),
        photos_(photos),
        past_(past),
        thing_(thing),
        mark_of_(views.size(), nullptr),
        drawn_(views.size()),
        tight_(is_tight(thing)) {
    size_t whole = 0;  // photos that show all of it: what they do not see is not the thing
    for (const Mark& mark : thing.marks) {
      const Intrinsics& k = views[mark.view].intrinsics;
      mark_of_[mark.view] = &mark;
      drawn_[mark.view] = filled(mark.outline, capture.set.views[mark.view].intrinsics, k);
      cones_.push_back(silhouette(views[mark.view], drawn_[mark.view]));
      whole += !touches_border(drawn_[mark.view], k);
    }
    desc_ = {.resolution = config.resolution,
             .rule = {.fewest_views = std::max<size_t>(whole, 2)},
             .one_piece = true,
             .most_one_sided = kMostOneSided};
    marked_ = VisualHull(cones_, desc_);
    if (marked_.empty()) throw_disagree();
  }

  Carried carry() const {
    Carried out{silhouettes_of(marked_, views_), std::vector<std::vector<uint8_t>>(views_.size()), {}, {}};
    out.summary = {.name = thing_.name, .word = thing_.word, .kind = thing_.kind, .marks = thing_.marks.size()};
    const Vec3d extent = marked_.bounds().high - marked_.bounds().low;
    out.summary.edge = std::max({extent.x, extent.y, extent.z});
    for (size_t v = 0; v < views_.size(); ++v) out.doubted[v].assign(out.inside[v].size(), 0);
    const VisualHull* hull = &marked_;
    FoundOutlines found;
    if (thing_.kind == MaskClass::Transparent) {
      if (tight_) take_box_of_marks(out);
    } else {
      found = past_ != nullptr && mirror_in_boxes(thing_) ? outlines_past() : outlines_by_colour(out.inside);
      for (size_t v = 0; v < views_.size(); ++v)
        out.summary.refined +=
            !is_polygon(v) && std::ranges::any_of(found.outlines[v].value.data(), [](float c) { return c > 0; });
      if (!found.hull.empty()) take_shape(found, out), hull = &found.hull;
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
    out.depth.resize(views_.size());
    parallel_for(views_.size(), 1, [&](size_t v) { out.depth[v] = depths_inside(*hull, views_[v], out.inside[v]); });
    return out;
  }

 private:
  bool is_polygon(size_t v) const { return mark_of_[v] != nullptr && !mark_of_[v]->box; }

  [[noreturn]] void throw_disagree() const {
    throw Error(ErrorKind::Input, fmt::format("the marks of '{}' do not meet", thing_.name),
                {.why = marked_.one_sidedness() > kMostOneSided
                            ? "the marked photos look from the same side, so that nothing tells how far away it is"
                            : fmt::format("no point of space lies inside the marks of all {} photos", thing_.marks.size()),
                 .hint = "mark the whole thing, and the same thing, in photos from different sides",
                 .code = "MARKS_DISAGREE"});
  }

  // Glass that is a box where its marks are silhouettes of one.
  void take_box_of_marks(Carried& out) const {
    const std::optional<BoxFit> fit = fit_box(cones_, marked_.bounds());
    if (!fit) return;
    Box box = drawn_to_edges(fit->box, edge_photos(capture_, 2 * config_.max_side));
    if (agreement(cones_, box) < fit->agreement - kEdgesMayDiffer) box = fit->box;  // those are edges of something else
    for (size_t v = 0; v < views_.size(); ++v) out.inside[v] = silhouette_mask(box, views_[v]);
    out.summary.box_agreement = fit->agreement;
  }

  // A hull that is nearer to the thing lets more photos tell what is behind it.
  FoundOutlines outlines_past() const {
    HullDesc desc = desc_;
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
    HullDesc desc = desc_;
    desc.rule = kOutlineVote;
    found.hull = VisualHull(found.votes(), desc);
    return found;
  }

  // The silhouettes of what the outlines vote for: a box, solids of revolution with their appendages, or the hull.
  void take_shape(const FoundOutlines& found, Carried& out) const {
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
    const std::vector<EdgePhoto> edges = edge_photos(capture_, 2 * config_.max_side);
    for (SurfaceOfRevolution& solid : solids) solid = drawn_to_edges(solid, edges);
    turn(solids, found.hull, tight_ ? &marked_ : nullptr, views_, out.inside);
  }

  // Where an outline and the shape disagree; what something else hides is no part of the mask.
  void doubt(const FoundOutlines& found, Carried& out) const {
    for (size_t v = 0; v < views_.size(); ++v) {
      const std::span<const float> value = found.outlines[v].value.data();
      for (size_t i = 0; i < value.size(); ++i)
        if (value[i] < 0)
          out.inside[v][i] = 0;
        else
          out.doubted[v][i] = (value[i] > 0) != (out.inside[v][i] != 0);
    }
  }

  const BoxesConfig& config_;
  const MaskCapture& capture_;
  const std::vector<View>& views_;
  const std::vector<SmallPhoto>& photos_;
  const PastOutlines* past_;
  const MarkedThing& thing_;
  std::vector<const Mark*> mark_of_;         // [view]
  std::vector<std::vector<uint8_t>> drawn_;  // [view][h,w] of the marks; empty: not marked
  std::vector<Silhouette> cones_;            // the marks
  bool tight_;                               // polygons whose hull is nearly the thing
  HullDesc desc_;
  VisualHull marked_;  // of the marks
};

bool wants_outlines(const MarkedThing& thing) { return thing.kind != MaskClass::Transparent; }

}  // namespace

bool marks_class(MaskClass kind, MaskClass of) {
  return kind == of || (kind == MaskClass::Transparent && of == MaskClass::Specular);
}

void describe(Describer& d, BoxesConfig& c) {
  d.option("max_side", c.max_side, "Longest side of the photos that outlines are looked for in, pixels.").range(64, 4096);
  d.option("resolution", c.resolution, "Voxels along the longest side of a marked thing.").range(16, 512);
}

std::shared_ptr<const MarkedMasks> carry_marks(const BoxesConfig& config, const MaskCapture& capture,
                                               const std::vector<MarkedThing>& things,
                                               const std::function<void(double)>& progress) {
  auto masks = std::make_shared<MarkedMasks>();
  const std::vector<View> views = small_views(capture, config.max_side);
  const bool looks = std::ranges::any_of(things, wants_outlines);
  const std::vector<SmallPhoto> photos = looks ? small_photos(capture, config.max_side) : std::vector<SmallPhoto>{};
  std::optional<PastOutlines> past;
  if (std::ranges::any_of(things, mirror_in_boxes)) {
    past.emplace(photos, capture);
    progress(kPastShare);
  }
  const double begun = past ? kPastShare : 0;
  if (past && past->blind()) past.reset();
  masks->inside.resize(views.size());
  masks->doubted.resize(views.size());
  for (size_t v = 0; v < views.size(); ++v) {
    masks->sizes.push_back(views[v].intrinsics);
    const size_t pixels = size_t(masks->sizes[v].width) * size_t(masks->sizes[v].height);
    masks->shown.emplace_back(pixels, uint16_t(0));
    for (auto* planes : {&masks->inside[v], &masks->doubted[v]})
      for (auto& plane : *planes) plane.assign(pixels, 0);
  }
  std::vector<std::vector<float>> nearest;  // [view][h,w] depth of what is shown
  for (const std::vector<uint16_t>& shown : masks->shown)
    nearest.emplace_back(shown.size(), std::numeric_limits<float>::infinity());
  for (size_t t = 0; t < things.size(); ++t) {
    const Carrier carrier(config, capture, views, photos, past ? &*past : nullptr, things[t]);
    const Carried carried = carrier.carry();
    log_info("masks: '{}' from {} marks is at most {:.2f} across{}", things[t].name, carried.summary.marks, carried.summary.edge,
             carried.summary.voted ? "; its outlines were looked for in all photos"
             : carried.summary.box_agreement > 0
                 ? fmt::format("; a box has these outlines ({:.0f} % of the pixels)", 100 * carried.summary.box_agreement)
                 : "");
    masks->things.push_back(carried.summary);
    if (things[t].kind != MaskClass::Object && things[t].kind != MaskClass::Ignore)
      for (size_t v = 0; v < views.size(); ++v)
        for (size_t i = 0; i < carried.inside[v].size(); ++i)
          if (carried.inside[v][i] && carried.depth[v][i] < nearest[v][i])
            nearest[v][i] = carried.depth[v][i], masks->shown[v][i] = uint16_t(t + 1);
    for (size_t v = 0; v < views.size(); ++v)
      for (MaskClass kind : kMaskClasses) {
        if (!marks_class(things[t].kind, kind)) continue;
        for (size_t i = 0; i < carried.inside[v].size(); ++i) {
          masks->inside[v][size_t(kind)][i] |= carried.inside[v][i];
          masks->doubted[v][size_t(kind)][i] |= carried.doubted[v][i];
        }
      }
    progress(begun + (1 - begun) * double(t + 1) / double(things.size()));
  }
  return masks;
}

void write_marked_things(const std::filesystem::path& artifact, const MaskCapture& capture, const MarkedMasks& masks) {
  if (std::ranges::all_of(masks.things, [](const MarkedMasks::Thing& t) { return t.word.empty(); })) return;
  parallel_for(masks.shown.size(), 1, [&](size_t v) {
    Image16 image(masks.sizes[v].width, masks.sizes[v].height, 1);
    std::ranges::copy(masks.shown[v], image.data().begin());
    const std::filesystem::path path = marked_things_path(artifact, capture.set.views[v]);
    make_folders(path.parent_path());
    write_png16(path, image);
  });
}

std::optional<SoftMask> MarkedSource::at(size_t view) const {
  const Intrinsics& k = masks_->sizes[view];
  const auto &inside = masks_->inside[view][size_t(kind_)], &doubted = masks_->doubted[view][size_t(kind_)];
  std::vector<float> value(inside.begin(), inside.end());
  blur_planes(value, k.width, k.height, kSoftEdge);
  SoftMask soft{.value = ImageF(k.width, k.height, 1), .confidence = ImageF(k.width, k.height, 1)};
  std::copy(value.begin(), value.end(), soft.value.data().begin());
  for (size_t i = 0; i < doubted.size(); ++i) soft.confidence.data()[i] = doubted[i] ? kDoubted : kCarried;
  return soft;
}

void MarkedSource::report(nlohmann::ordered_json& j) const {
  j["things"] = nlohmann::ordered_json::array();
  for (const MarkedMasks::Thing& t : masks_->things)
    if (marks_class(t.kind, kind_))
      j["things"].push_back({{"name", t.name},
                             {"marks", t.marks},
                             {"across", t.edge},
                             {"outlines_found", t.refined},
                             {"voted", t.voted},
                             {"solids_of_revolution", t.solids},
                             {"box_agreement", t.box_agreement}});
}

}  // namespace vitrine
