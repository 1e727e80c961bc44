#include "stages/masks/boxes/marked_source.h"

#include <algorithm>
#include <cmath>
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
#include "stages/masks/small_photo.h"

namespace vitrine {

namespace {

constexpr size_t kFewestTight = 3;                 // polygons whose hull is nearly the thing
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

struct Carried {
  std::vector<std::vector<uint8_t>> inside, doubted;  // [view][h,w]
  MarkedMasks::Thing summary;
};

// `views`: at the small size. `photos`: the same with their colours; nobody looks at them for glass.
Carried carry(const BoxesConfig& config, const MaskCapture& capture, const std::vector<View>& views,
              const std::vector<SmallPhoto>& photos, const MarkedThing& thing) {
  std::vector<Silhouette> cones;
  size_t whole = 0;  // photos that show all of it: what they do not see is not the thing
  std::vector<const Mark*> mark_of(views.size(), nullptr);
  std::vector<std::vector<uint8_t>> drawn(views.size());
  for (const Mark& mark : thing.marks) {
    mark_of[mark.view] = &mark;
    drawn[mark.view] = filled(mark.outline, capture.set.views[mark.view].intrinsics, views[mark.view].intrinsics);
    cones.push_back(silhouette(views[mark.view], drawn[mark.view]));
    whole += !touches_border(drawn[mark.view], views[mark.view].intrinsics);
  }
  const auto is_drawn = [&](size_t v) { return mark_of[v] != nullptr && !mark_of[v]->box; };  // a polygon
  const bool tight = thing.marks.size() >= kFewestTight && std::ranges::none_of(thing.marks, &Mark::box);
  HullDesc desc{.resolution = config.resolution,
                .rule = {.fewest_views = std::max<size_t>(whole, 2)},
                .one_piece = true,
                .most_one_sided = kMostOneSided};
  const VisualHull hull(cones, desc);
  if (hull.empty())
    throw Error(ErrorKind::Input, fmt::format("the marks of '{}' do not meet", thing.name),
                {.why = hull.one_sidedness() > kMostOneSided
                            ? "the marked photos look from the same side, so that nothing tells how far away it is"
                            : fmt::format("no point of space lies inside the marks of all {} photos", thing.marks.size()),
                 .hint = "mark the whole thing, and the same thing, in photos from different sides",
                 .code = "MARKS_DISAGREE"});
  Carried out{silhouettes_of(hull, views), std::vector<std::vector<uint8_t>>(views.size()), {thing.name, thing.word, thing.kind}};
  out.summary.marks = thing.marks.size();
  const Vec3d extent = hull.bounds().high - hull.bounds().low;
  out.summary.edge = std::max({extent.x, extent.y, extent.z});
  for (size_t v = 0; v < views.size(); ++v) out.doubted[v].assign(out.inside[v].size(), 0);

  if (thing.kind == MaskClass::Transparent && tight)
    if (const std::optional<BoxFit> fit = fit_box(cones, hull.bounds())) {
      Box box = drawn_to_edges(fit->box, edge_photos(capture, 2 * config.max_side));
      if (agreement(cones, box) < fit->agreement - kEdgesMayDiffer) box = fit->box;  // those are edges of something else
      for (size_t v = 0; v < views.size(); ++v) out.inside[v] = silhouette_mask(box, views[v]);
      out.summary.box_agreement = fit->agreement;
    }
  if (thing.kind != MaskClass::Transparent) {
    std::vector<std::vector<uint8_t>> found(views.size());
    parallel_for(views.size(), 1, [&](size_t v) {
      if (interrupt_signal() != 0) return;
      found[v] = is_drawn(v) ? drawn[v] : grab_cut(photos[v], out.inside[v], tight);
    });
    throw_if_interrupted();
    std::vector<Silhouette> outlines;
    for (size_t v = 0; v < views.size(); ++v) {
      if (found[v].empty()) continue;
      outlines.push_back(silhouette(views[v], found[v]));
      out.summary.refined += !is_drawn(v);
    }
    desc.rule = kOutlineVote;
    const VisualHull second(outlines, desc);
    if (!second.empty()) {
      const FittedShapes fits = fit_shapes(outlines, second);
      if (fits.box)
        for (size_t v = 0; v < views.size(); ++v) out.inside[v] = silhouette_mask(fits.box->box, views[v]);
      else
        out.inside = silhouettes_of(second, views);
      out.summary.voted = true;
      out.summary.solids = fits.solids.size();
      if (out.summary.solids > 0) {
        std::vector<SurfaceOfRevolution> solids = tight ? solids_of_hull(hull, views) : std::vector<SurfaceOfRevolution>{};
        if (solids.empty()) solids = fits.solids;
        const std::vector<EdgePhoto> edges = edge_photos(capture, 2 * config.max_side);
        for (SurfaceOfRevolution& solid : solids) solid = drawn_to_edges(solid, edges);
        turn(solids, second, tight ? &hull : nullptr, views, out.inside);
      }
    }
    for (size_t v = 0; v < views.size(); ++v)
      for (size_t i = 0; i < found[v].size(); ++i) out.doubted[v][i] = found[v][i] != out.inside[v][i];
  }
  for (size_t v = 0; v < views.size(); ++v) {
    if (is_drawn(v)) {
      out.inside[v] = drawn[v];
      std::fill(out.doubted[v].begin(), out.doubted[v].end(), uint8_t(0));
    } else if (mark_of[v] != nullptr) {
      for (size_t i = 0; i < drawn[v].size(); ++i) out.inside[v][i] &= drawn[v][i];
    }
  }
  return out;
}

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
  const bool looks = std::any_of(things.begin(), things.end(), [](const auto& t) { return t.kind != MaskClass::Transparent; });
  const std::vector<SmallPhoto> photos = looks ? small_photos(capture, config.max_side) : std::vector<SmallPhoto>{};
  masks->inside.resize(views.size());
  masks->doubted.resize(views.size());
  for (size_t v = 0; v < views.size(); ++v) {
    masks->sizes.push_back(views[v].intrinsics);
    const size_t pixels = size_t(masks->sizes[v].width) * size_t(masks->sizes[v].height);
    masks->shown.emplace_back(pixels, uint16_t(0));
    for (auto* planes : {&masks->inside[v], &masks->doubted[v]})
      for (auto& plane : *planes) plane.assign(pixels, 0);
  }
  for (size_t t = 0; t < things.size(); ++t) {
    const Carried carried = carry(config, capture, views, photos, things[t]);
    log_info("masks: '{}' from {} marks is at most {:.2f} across{}", things[t].name, carried.summary.marks, carried.summary.edge,
             carried.summary.voted ? "; its outlines were looked for in all photos"
             : carried.summary.box_agreement > 0
                 ? fmt::format("; a box has these outlines ({:.0f} % of the pixels)", 100 * carried.summary.box_agreement)
                 : "");
    masks->things.push_back(carried.summary);
    const bool glass = things[t].kind == MaskClass::Transparent;
    if (things[t].kind != MaskClass::Object && things[t].kind != MaskClass::Ignore)
      for (size_t v = 0; v < views.size(); ++v)
        for (size_t i = 0; i < carried.inside[v].size(); ++i)
          if (uint16_t& shown = masks->shown[v][i]; carried.inside[v][i] && (glass || shown == 0)) shown = uint16_t(t + 1);
    for (size_t v = 0; v < views.size(); ++v)
      for (MaskClass kind : kMaskClasses) {
        if (!marks_class(things[t].kind, kind)) continue;
        for (size_t i = 0; i < carried.inside[v].size(); ++i) {
          masks->inside[v][size_t(kind)][i] |= carried.inside[v][i];
          masks->doubted[v][size_t(kind)][i] |= carried.doubted[v][i];
        }
      }
    progress(double(t + 1) / double(things.size()));
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
