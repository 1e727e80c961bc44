#include "stages/masks/contact_sheet.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/camera/view_masks.h"
#include "core/image/bitmap_font.h"
#include "core/image/exr.h"
#include "core/image/ldr.h"
#include "core/image/resample.h"

namespace vitrine {

namespace {

constexpr int kGap = 4, kTextMargin = 6, kTextScale = 2, kCellWidth = 400;
constexpr size_t kRows = 8;
constexpr float kTint = 0.5f;

struct Tint {
  MaskClass kind;
  float rgb[3];
};
constexpr Tint kTints[] = {
    {MaskClass::Specular, {1.f, 0.45f, 0.f}}, {MaskClass::Transparent, {0.f, 0.7f, 1.f}}, {MaskClass::Ignore, {1.f, 0.f, 0.6f}}};

ImageF grey_at(const fs::path& path, int width, int height) {
  const ImageF image = read_unchanged(path);
  return image.width() == width && image.height() == height ? image : resized(image, width, height);
}

void paste(const ImageF& picture, int x, int y, Image8& sheet) {
  for (int j = 0; j < picture.height(); ++j)
    for (int i = 0; i < picture.width(); ++i)
      for (int c = 0; c < 3; ++c) {
        const float v = picture.at(i, j, picture.channels() == 3 ? c : 0);
        sheet.at(x + i, y + j, c) = uint8_t(std::lround(std::clamp(v, 0.f, 1.f) * 255.f));
      }
}

}  // namespace

void write_contact_sheet(const MaskOutputDesc& desc, const MaskResults& results) {
  if (std::none_of(results.classes.begin(), results.classes.end(), [](const ClassResult& c) { return c.kept; })) return;
  const std::vector<View>& views = desc.capture.set.views;
  const fs::path masks = desc.output / "masks";
  const size_t rows = std::min(kRows, views.size());
  const int width = std::min(kCellWidth, views[0].intrinsics.width);
  const int height = std::max(1, int(std::lround(double(views[0].intrinsics.height) * width / views[0].intrinsics.width)));
  const int bar = kGlyphHeight * kTextScale + 2 * kTextMargin;
  Image8 sheet(3 * (width + kGap) + kGap, bar + int(rows) * (height + bar), 3, uint8_t(24));
  draw_text(sheet, kGap, kTextMargin, "PHOTO", kTextScale, 200);
  draw_text(sheet, kGap + width + kGap, kTextMargin, "BLUE GLASS, ORANGE MIRROR", kTextScale, 200);
  draw_text(sheet, kGap + 2 * (width + kGap), kTextMargin, "CONFIDENCE", kTextScale, 200);
  for (size_t r = 0; r < rows; ++r) {
    const size_t v = r * views.size() / rows;
    const View& view = views[v];
    const ImageF photo =
        srgb_from_linear_image(resized(read_exr_rgb(linear_image_path(desc.capture.sfm_folder, view)), width, height));
    ImageF painted = photo;
    std::string label = view.name;
    for (MaskClass kind : kMaskClasses)
      if (results.classes[size_t(kind)].kept)
        label += fmt::format("  {} {:.0f}%", name(kind), 100 * results.classes[size_t(kind)].coverage[v]);
    if (results.classes[size_t(MaskClass::Object)].kept) {
      const ImageF object = grey_at(view_mask_path(desc.output, MaskClass::Object, view), width, height);
      for (size_t i = 0; i < painted.pixel_count(); ++i)
        for (size_t c = 0; c < 3; ++c) painted.data()[3 * i + c] *= 0.3f + 0.7f * object.data()[i];
    }
    for (const Tint& tint : kTints) {
      if (!results.classes[size_t(tint.kind)].kept) continue;
      const ImageF mask = grey_at(view_mask_path(desc.output, tint.kind, view), width, height);
      for (size_t i = 0; i < painted.pixel_count(); ++i)
        for (size_t c = 0; c < 3; ++c) {
          float& p = painted.data()[3 * i + c];
          p += kTint * mask.data()[i] * (tint.rgb[c] - p);
        }
    }
    const int y = bar + int(r) * (height + bar);
    paste(photo, kGap, y, sheet);
    paste(painted, kGap + width + kGap, y, sheet);
    paste(grey_at(masks / "confidence" / (view.stem() + ".png"), width, height), kGap + 2 * (width + kGap), y, sheet);
    draw_text(sheet, kGap, y + height + kTextMargin, label, kTextScale, 255);
  }
  write_ldr(masks / "contact_sheet.png", sheet);
}

}  // namespace vitrine
