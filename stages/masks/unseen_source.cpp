#include "stages/masks/unseen_source.h"

#include <algorithm>
#include <map>

#include "core/foundation/base/json.h"
#include "core/scene/camera/wide_views.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

class UnseenSource final : public MaskSource {
 public:
  // `unseen`: [view] index in `masks`, or -1.
  UnseenSource(std::vector<ImageF> masks, std::vector<int> unseen, std::unique_ptr<MaskSource> others)
      : masks_(std::move(masks)), unseen_(std::move(unseen)), others_(std::move(others)) {}

  std::string_view name() const override { return others_ ? others_->name() : "lens"; }
  std::string_view trust() const override { return others_ ? others_->trust() : MaskSource::trust(); }
  bool propagated() const override { return others_ && others_->propagated(); }
  void report(nlohmann::ordered_json& j) const override {
    if (others_) others_->report(j);
    j["views_with_unseen_pixels"] = std::ranges::count_if(unseen_, [](int i) { return i >= 0; });
  }
  std::optional<SoftMask> at(size_t view) const override {
    std::optional<SoftMask> soft = others_ ? others_->at(view) : std::nullopt;
    if (unseen_[view] < 0) return soft;
    const ImageF& mask = masks_[size_t(unseen_[view])];
    const int w = mask.width(), h = mask.height();
    const bool alone = !soft;
    if (alone) soft = SoftMask{.value = mask, .confidence = ImageF(w, h, 1, 1.f)};
    for (ImageF* image : {&soft->value, &soft->confidence})
      if (image->width() != w || image->height() != h) *image = resized(*image, w, h);
    for (size_t i = 0; i < mask.pixel_count(); ++i)
      if (mask.data()[i] > 0) soft->value.data()[i] = soft->confidence.data()[i] = 1;
    return soft;
  }

 private:
  std::vector<ImageF> masks_;
  std::vector<int> unseen_;
  std::unique_ptr<MaskSource> others_;
};

// Equal for views with the same unseen pixels.
bool same_view(const Undistortion& a, const Undistortion& b) {
  return a.source == b.source && a.target == b.target && a.circle_px == b.circle_px;
}

}  // namespace

void add_unseen_pixels(const MaskCapture& capture, std::unique_ptr<MaskSource>& ignore) {
  std::vector<ImageF> masks;
  std::vector<int> of_view;
  std::vector<std::pair<const Undistortion*, int>> known;  // one for each camera
  for (const Undistortion& u : capture.undistortions) {
    int index = -1;
    if (u.rotation) {
      const auto found = std::ranges::find_if(known, [&](const auto& k) { return same_view(*k.first, u); });
      if (found != known.end()) {
        index = found->second;
      } else {
        ImageF mask = unseen_pixels(u);
        if (mask.pixel_count() > 0) index = int(masks.size()), masks.push_back(std::move(mask));
        known.emplace_back(&u, index);
      }
    }
    of_view.push_back(index);
  }
  if (!masks.empty()) ignore = std::make_unique<UnseenSource>(std::move(masks), std::move(of_view), std::move(ignore));
}

}  // namespace vitrine
