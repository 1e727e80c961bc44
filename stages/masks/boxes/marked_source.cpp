#include "stages/masks/boxes/marked_source.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/scene/camera/view_masks.h"
#include "core/scene/image/ldr.h"
#include "stages/masks/mask_source.h"

namespace vitrine {

namespace {

constexpr float kSoftEdge = 0.7f;                  // pixels of the small photo
constexpr float kCarried = 0.8f, kDoubted = 0.4f;  // confidence of propagated and of doubted pixels
constexpr double kPastShare = 0.5;                 // share of the time spent on stereo

bool wants_outlines(const MarkedObject& object) { return object.kind != MaskClass::Transparent; }

}  // namespace

bool marks_class(MaskClass kind, MaskClass of) {
  return kind == of || (kind == MaskClass::Transparent && of == MaskClass::Specular);
}

std::shared_ptr<const MarkedMasks> carry_marks(const MaskCapture& capture, const std::vector<MarkedObject>& objects,
                                               int hull_voxels, const std::function<void(double)>& progress) {
  auto masks = std::make_shared<MarkedMasks>();
  const std::vector<View> views = small_views(capture, kSmallSide);
  const bool looks = std::ranges::any_of(objects, wants_outlines);
  const std::vector<SmallPhoto> photos = looks ? small_photos(capture, kSmallSide) : std::vector<SmallPhoto>{};
  std::optional<SmallStereo> stereo;
  if (std::ranges::any_of(objects, mirror_in_boxes)) {
    stereo.emplace(edge_photos(photos), capture.set);
    progress(kPastShare);
  }
  const double begun = stereo ? kPastShare : 0;
  if (stereo && stereo->blind()) stereo.reset();
  const CarryDesc desc{capture, views, photos, stereo ? &*stereo : nullptr, hull_voxels};
  masks->inside.resize(views.size());
  masks->doubted.resize(views.size());
  for (size_t v = 0; v < views.size(); ++v) {
    masks->sizes.push_back(views[v].intrinsics);
    const size_t pixels = size_t(masks->sizes[v].width) * size_t(masks->sizes[v].height);
    masks->shown.emplace_back(pixels, uint16_t(0));
    for (auto* planes : {&masks->inside[v], &masks->doubted[v]})
      for (auto& plane : *planes) plane.assign(pixels, 0);
  }
  std::vector<std::vector<float>> nearest;  // [view][h,w] depth of the nearest object
  for (const std::vector<uint16_t>& shown : masks->shown)
    nearest.emplace_back(shown.size(), std::numeric_limits<float>::infinity());
  for (size_t t = 0; t < objects.size(); ++t) {
    const CarriedObject carried = carry_object(desc, objects[t]);
    log_info("masks: '{}' from {} marks is at most {:.2f} across{}", objects[t].name, carried.summary.marks, carried.summary.edge,
             carried.summary.voted ? "; its outlines were looked for in all photos"
             : carried.summary.box_agreement > 0
                 ? fmt::format("; a box has these outlines ({:.0f} % of the pixels)", 100 * carried.summary.box_agreement)
                 : "");
    masks->objects.push_back(carried.summary);
    if (objects[t].kind != MaskClass::Object && objects[t].kind != MaskClass::Ignore)
      for (size_t v = 0; v < views.size(); ++v) {
        const Bounds3& hull = carried.hull.bounds();
        const auto middle = float((views[v].cam_from_world * (0.5 * (hull.low + hull.high))).z);  // for gaps of the hull
        for (size_t i = 0; i < carried.inside[v].size(); ++i) {
          if (!carried.inside[v][i]) continue;
          const float entry = carried.passed[v].entry[i], depth = entry > 0 ? entry : middle;
          if (depth < nearest[v][i]) nearest[v][i] = depth, masks->shown[v][i] = uint16_t(t + 1);
        }
      }
    for (size_t v = 0; v < views.size(); ++v)
      for (MaskClass kind : kMaskClasses) {
        if (!marks_class(objects[t].kind, kind)) continue;
        for (size_t i = 0; i < carried.inside[v].size(); ++i) {
          masks->inside[v][size_t(kind)][i] |= carried.inside[v][i];
          masks->doubted[v][size_t(kind)][i] |= carried.doubted[v][i];
        }
      }
    progress(begun + (1 - begun) * double(t + 1) / double(objects.size()));
  }
  return masks;
}

void write_marked_objects(const std::filesystem::path& artifact, const MaskCapture& capture, const MarkedMasks& masks) {
  if (std::ranges::all_of(masks.objects, [](const CarriedObject::Summary& t) { return t.word.empty(); })) return;
  parallel_for(masks.shown.size(), 1, [&](size_t v) {
    Image16 image(masks.sizes[v].width, masks.sizes[v].height, 1);
    std::ranges::copy(masks.shown[v], image.data().begin());
    const std::filesystem::path path = marked_objects_path(artifact, capture.set.views[v]);
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
  for (const CarriedObject::Summary& t : masks_->objects)
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
