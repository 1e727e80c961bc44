#include "stages/masks/outputs.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/config/json_file.h"
#include "core/scene/camera/view_masks.h"
#include "core/scene/image/contact_sheet.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

constexpr int kCellWidth = 400;  // of the contact sheet, pixels
constexpr size_t kRows = 8;
constexpr float kTint = 0.5f;

struct Tint {
  MaskClass kind;
  float rgb[3];
};
constexpr Tint kTints[] = {
    {MaskClass::Specular, {1.f, 0.45f, 0.f}}, {MaskClass::Transparent, {0.f, 0.7f, 1.f}}, {MaskClass::Ignore, {1.f, 0.f, 0.6f}}};

ImageF fitted(ImageF image, const Intrinsics& k) {
  if (image.width() != k.width || image.height() != k.height) image = resized(image, k.width, k.height);
  return image;
}

// Sets to black where COLMAP should not extract features: outside the object, and on glass, mirrors and ignored pixels.
void fold_into_colmap(MaskClass kind, const ImageF& mask, ImageF& colmap) {
  for (size_t i = 0; i < colmap.data().size(); ++i) {
    const float usable = kind == MaskClass::Object ? mask.data()[i] : 1 - mask.data()[i];
    colmap.data()[i] = std::min(colmap.data()[i], usable >= 0.5f ? 1.f : 0.f);
  }
}

ImageF grey_at(const fs::path& path, int width, int height) {
  const ImageF image = read_unchanged(path);
  return image.width() == width && image.height() == height ? image : resized(image, width, height);
}

}  // namespace

double ClassResult::mean_coverage() const {
  double sum = 0;
  for (double c : coverage) sum += c;
  return coverage.empty() ? 0 : sum / double(coverage.size());
}

float value_without_mask(MaskClass kind) { return kind == MaskClass::Object ? 1.f : 0.f; }

MaskResults write_masks(const MaskOutputDesc& desc, StageContext& context) {
  const std::vector<View>& views = desc.capture.set.views;
  MaskResults results;
  std::array<std::vector<uint8_t>, kMaskClassCount> touched;  // [view] the file has a value above zero
  for (MaskClass kind : kMaskClasses) {
    if (!desc.sources[size_t(kind)]) continue;
    results.classes[size_t(kind)].coverage.assign(views.size(), 0);
    touched[size_t(kind)].assign(views.size(), 0);
    make_folders(desc.output / "masks" / name(kind));
  }
  size_t done = 0;
  std::mutex reporting;
  parallel_for(views.size(), 1, [&](size_t v) {
    throw_if_interrupted();
    const Intrinsics& k = views[v].intrinsics;
    ImageF confidence(k.width, k.height, 1, 1.f), colmap(k.width, k.height, 1, 1.f);
    for (MaskClass kind : kMaskClasses) {
      const MaskSource* source = desc.sources[size_t(kind)].get();
      if (source == nullptr) continue;
      std::optional<SoftMask> soft = source->at(v);
      const ImageF mask = soft ? fitted(std::move(soft->value), k) : ImageF(k.width, k.height, 1, value_without_mask(kind));
      const ImageF sure = soft ? fitted(std::move(soft->confidence), k) : ImageF(k.width, k.height, 1, 0.f);
      for (size_t i = 0; i < confidence.data().size(); ++i) confidence.data()[i] = std::min(confidence.data()[i], sure.data()[i]);
      const fs::path path = view_mask_path(desc.output, kind, views[v]);
      make_folders(path.parent_path());
      double sum = 0;
      for (float value : mask.data()) sum += value;
      results.classes[size_t(kind)].coverage[v] = sum / double(mask.pixel_count());
      const Image8 grey = bytes_of(mask);
      touched[size_t(kind)][v] = std::any_of(grey.data().begin(), grey.data().end(), [](uint8_t g) { return g > 0; });
      write_ldr(path, grey);
      fold_into_colmap(kind, mask, colmap);
    }
    const fs::path sure_path = desc.output / "masks/confidence" / (views[v].stem() + ".png");
    const fs::path colmap_path = desc.output / "masks/colmap" / (views[v].name + ".png");
    make_folders(sure_path.parent_path());
    make_folders(colmap_path.parent_path());
    write_ldr(sure_path, bytes_of(confidence));
    write_ldr(colmap_path, bytes_of(colmap));
    const std::lock_guard lock(reporting);
    ++done;
    context.progress({.fraction = 0.8 + 0.2 * double(done) / double(views.size()),
                      .text = fmt::format("masks written {}/{}", done, views.size()),
                      .values = {}});
  });
  bool any = false;
  for (MaskClass kind : kMaskClasses) {
    ClassResult& result = results.classes[size_t(kind)];
    const auto& of_class = touched[size_t(kind)];
    result.kept = std::any_of(of_class.begin(), of_class.end(), [](uint8_t t) { return t != 0; });
    any |= result.kept;
    if (!result.kept) fs::remove_all(desc.output / "masks" / name(kind));
  }
  if (!any)
    for (const char* folder : {"masks/confidence", "masks/colmap"}) fs::remove_all(desc.output / folder);
  return results;
}

void write_mask_report(const MaskOutputDesc& desc, const MaskResults& results, const std::vector<std::string>& objects) {
  const std::vector<View>& views = desc.capture.set.views;
  nlohmann::ordered_json j;
  j["photos"] = views.size();
  j["classes"] = nlohmann::ordered_json::object();
  std::map<MaskClass, MaskOrigin> origins;
  for (MaskClass kind : kMaskClasses) {
    const MaskSource* source = desc.sources[size_t(kind)].get();
    const ClassResult& result = results.classes[size_t(kind)];
    nlohmann::ordered_json row;
    row["source"] = source ? source->name() : "none";
    row["written"] = result.kept;
    if (source != nullptr) {
      row["trust"] = source->trust();
      origins[kind] = {std::string(source->name()), std::string(source->trust()), source->propagated()};
      row["propagated"] = source->propagated();
      source->report(row);
      row["mean_coverage"] = result.mean_coverage();
      for (size_t v = 0; v < views.size(); ++v) row["coverage"][views[v].name] = result.coverage[v];
    }
    j["classes"][std::string(name(kind))] = std::move(row);
  }
  write_mask_origins(desc.output, origins, objects);
  write_file(desc.output / "masks/report.json", j.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

void write_contact_sheet(const MaskOutputDesc& desc, const MaskResults& results) {
  if (std::none_of(results.classes.begin(), results.classes.end(), [](const ClassResult& c) { return c.kept; })) return;
  const std::vector<View>& views = desc.capture.set.views;
  const fs::path masks = desc.output / "masks";
  const size_t rows = std::min(kRows, views.size());
  const int width = std::min(kCellWidth, views[0].intrinsics.width);
  const int height = std::max(1, int(std::lround(double(views[0].intrinsics.height) * width / views[0].intrinsics.width)));
  ContactSheet sheet(3, kCellWidth);
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
    sheet.start_row(label);
    sheet.add("PHOTO", bytes_of(photo));
    sheet.add("BLUE GLASS, ORANGE MIRROR", bytes_of(painted));
    sheet.add("CONFIDENCE", bytes_of(grey_at(masks / "confidence" / (view.stem() + ".png"), width, height)));
  }
  sheet.write(masks / "contact_sheet.png");
}

}  // namespace vitrine
