#include "stages/mesh/mirror_shape.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/camera/view_masks.h"
#include "core/image/resample.h"

namespace vitrine {

namespace {

constexpr int kMaskSide = 640;                       // of the masks that shape the hull, pixels
constexpr double kDissent = 0.15;                    // share of the photos that may contradict: outlines on mirrors are rough
constexpr int kHullResolution = 96, kHullBlur = 13;  // outlines of some dozen photos are facets: a bell of three voxels
constexpr float kHalf = 0.5f;

ImageF marks_of(const std::filesystem::path& masks, const View& photo, const Intrinsics& k) {
  const auto specular = read_view_mask(masks, MaskClass::Specular, photo);
  if (!specular) return {};
  ImageF out = resized(*specular, k.width, k.height);
  for (float& v : out.data()) v = v > kHalf ? 1.f : 0.f;
  if (const auto glass = read_view_mask(masks, MaskClass::Transparent, photo)) {
    const ImageF g = resized(*glass, k.width, k.height);
    for (size_t i = 0; i < g.data().size(); ++i)
      if (g.data()[i] > kHalf) out.data()[i] = -1;
  }
  return out;
}

}  // namespace

MirrorShape::MirrorShape(const std::filesystem::path& masks, const std::vector<View>& photos, const std::vector<View>& views,
                         const std::function<RgbdFrame(size_t)>& frame_of) {
  bool any = false;
  for (const View& view : views) {
    const auto photo = std::ranges::find(photos, view.name, &View::name);
    VITRINE_CHECK(photo != photos.end(), "no photo is called {}", view.name);
    marks_.push_back(marks_of(masks, *photo, view.intrinsics.limited_to(kMaskSide)));
    any = any || std::ranges::find(marks_.back().data(), 1.f) != marks_.back().data().end();
  }
  if (!any) return;
  std::vector<HullMask> outlines;
  for (size_t i = 0; i < views.size(); ++i) {
    if (marks_[i].empty()) continue;
    HullMask& outline = outlines.emplace_back(HullMask{views[i], marks_[i], ImageF(marks_[i].width(), marks_[i].height(), 1)});
    outline.view.intrinsics = views[i].intrinsics.limited_to(kMaskSide);
    const RgbdFrame frame = frame_of(i);
    for (int y = 0; y < marks_[i].height(); ++y)
      for (int x = 0; x < marks_[i].width(); ++x) {
        const int fx = x * frame.intrinsics.width / marks_[i].width(), fy = y * frame.intrinsics.height / marks_[i].height();
        outline.zdepth.at(x, y) = frame.zdepth[size_t(fy) * size_t(frame.intrinsics.width) + size_t(fx)];
      }
  }
  hull_.emplace(outlines, HullDesc{.resolution = kHullResolution, .dissent = kDissent, .blur_passes = kHullBlur});
}

void MirrorShape::put(size_t i, RgbdFrame& frame, double tolerance) const {
  if (empty() || marks_[i].empty()) return;
  const ImageF& marks = marks_[i];
  const Intrinsics& k = frame.intrinsics;
  const Rigid world_from_cam = inverse(frame.cam_from_world);
  parallel_for(size_t(k.height), 8, [&](size_t y) {
    for (int x = 0; x < k.width; ++x) {
      if (!(marks.at(x * marks.width() / k.width, int(y) * marks.height() / k.height) > kHalf)) continue;
      const size_t p = y * size_t(k.width) + size_t(x);
      const Vec3d direction = world_from_cam.rotation * k.ray(x + 0.5, double(y) + 0.5);  // z = 1: t is the z-depth
      const auto hit = hull_->first_hit(world_from_cam.translation, direction);
      if (!hit) {
        frame.weight[p] = 0;
        continue;
      }
      if (frame.zdepth[p] > 0 && frame.zdepth[p] < hit->t - tolerance) continue;
      const double cosine = -dot(hit->normal, direction) / length(direction);
      frame.zdepth[p] = float(hit->t);
      frame.weight[p] = float(cosine * cosine / (hit->t * hit->t));
    }
  });
}

}  // namespace vitrine
