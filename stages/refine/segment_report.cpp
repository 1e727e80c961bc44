#include "stages/refine/refine.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/scene/image/contact_sheet.h"

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<const char*, kSegmentKinds> kNames{"none", "open", "closed", "no_mesh", "apart", "not_glass"};
constexpr std::array<std::array<uint8_t, 3>, kSegmentKinds> kColors{
    {{0, 0, 0}, {60, 110, 255}, {40, 200, 80}, {230, 40, 40}, {230, 40, 40}, {240, 210, 40}}};
constexpr size_t kPictures = 12;
constexpr int kColumns = 4, kSheetCell = 480;  // pixels
constexpr float kTint = 0.55f;
constexpr int kFrame = 3;

}  // namespace

double SegmentTotals::share(SegmentKind kind) const {
  return glass > 0 ? double(count[static_cast<size_t>(kind)]) / double(glass) : 0;
}
double SegmentTotals::fallback_share() const { return glass > 0 ? double(fallback) / double(glass) : 0; }

SegmentTotals segment_totals(std::span<const GlassView> views) {
  SegmentTotals t;
  for (const GlassView& v : views) {
    const GlassSegments& s = v.segments;
    if (s.glass() == 0) continue;
    ++t.views;
    t.fallback_views += !s.trusted;
    t.glass += s.glass();
    for (size_t k = 1; k < kSegmentKinds; ++k) {
      t.count[k] += s.count[k];
      if (!s.trusted || !is_split(static_cast<SegmentKind>(k))) t.fallback += s.count[k];
    }
  }
  return t;
}

Json segments_json(std::span<const GlassView> views, const Capture& capture) {
  const SegmentTotals t = segment_totals(views);
  Json json{{"photos", t.views}, {"photos_fallback", t.fallback_views}, {"glass_pixels", t.glass}};
  for (size_t k = 1; k < kSegmentKinds; ++k) json[kNames[k]] = rounded(t.share(static_cast<SegmentKind>(k)));
  json["fallback"] = rounded(t.fallback_share());
  json["per_photo"] = Json::array();
  for (const GlassView& v : views) {
    const GlassSegments& s = v.segments;
    if (s.glass() == 0) continue;
    Json row{{"name", capture.photos[v.photo].name()}, {"glass_pixels", s.glass()}};
    for (size_t k = 1; k < kSegmentKinds; ++k) row[kNames[k]] = rounded(double(s.count[k]) / double(s.glass()));
    row["agreement"] = rounded(s.agreement());
    row["trusted"] = s.trusted;
    json["per_photo"].push_back(std::move(row));
  }
  return json;
}

void write_segments_picture(const std::filesystem::path& path, std::span<const GlassView> views, const Capture& capture,
                            size_t level) {
  std::vector<const GlassView*> shown;
  for (const GlassView& v : views)
    if (v.segments.glass() > 0) shown.push_back(&v);
  const size_t count = std::min(kPictures, shown.size());
  ContactSheet sheet(kColumns, kSheetCell);
  std::vector<float> photo;
  for (size_t n = 0; n < count; ++n) {
    const GlassView& v = *shown[n * shown.size() / count];  // uniformly over the capture
    decode(capture.photos[v.photo].levels[level], photo);
    const int w = v.view->intrinsics.width, h = v.view->intrinsics.height;
    const size_t pixels = size_t(w) * size_t(h);
    Image8 picture(w, h, 3);
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        const size_t i = size_t(y) * size_t(w) + size_t(x);
        const float grey = 85.f * (photo[i] + photo[pixels + i] + photo[2 * pixels + i]);
        const SegmentKind kind = v.segments.kind[i];
        const bool edge = std::min({x, y, w - 1 - x, h - 1 - y}) < kFrame;
        for (size_t c = 0; c < 3; ++c) {
          float value = grey;
          if (kind != SegmentKind::None) value += kTint * (float(kColors[static_cast<size_t>(kind)][c]) - grey);
          if (edge && !v.segments.trusted) value = kColors[static_cast<size_t>(SegmentKind::Apart)][c];
          picture.at(x, y, int(c)) = static_cast<uint8_t>(std::lround(value));
        }
      }
    sheet.add(capture.photos[v.photo].name(), picture);
  }
  sheet.write(path);
}

}  // namespace vitrine
