#include "core/learn/trainer/targets.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/scene/camera/view_masks.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace fs = std::filesystem;

namespace {

constexpr float kFullScale = 32767.f;
// Minimum length of the mean of unit normals: shorter means lie across an edge or next to unknown pixels.
constexpr float kShortestMean = 0.5f;
// Maximum coverage of masks of glass, mirrors and ignored regions in a capture.
constexpr double kMostCoverage = 0.6;

ImageF sized(const ImageF& image, const Intrinsics& k) {
  return image.width() == k.width && image.height() == k.height ? image : resized(image, k.width, k.height);
}

std::vector<uint8_t> quantised(const ImageF& image) {
  std::vector<uint8_t> bytes(image.pixel_count());
  for (size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<uint8_t>(std::lround(255.f * std::clamp(image.data()[i * size_t(image.channels())], 0.f, 1.f)));
  return bytes;
}

std::vector<int16_t> quantised_normals(const ImageF& image) {
  const size_t pixels = image.pixel_count();
  std::vector<int16_t> planes(3 * pixels, 0);
  for (size_t i = 0; i < pixels; ++i) {
    const float* n = image.data().data() + 3 * i;
    const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(length > kShortestMean)) continue;
    for (size_t c = 0; c < 3; ++c) planes[c * pixels + i] = static_cast<int16_t>(std::lround(kFullScale * n[c] / length));
  }
  return planes;
}

// Loads every photo's mask of one class; returns the coverage of each (NaN: no file).
std::vector<double> load_class(const Capture& capture, const fs::path& artifact, size_t mask, Targets& targets) {
  const auto& views = capture.view_set.views;
  std::vector<double> coverage(views.size(), NAN);
  parallel_for(views.size(), 1, [&](size_t i) {
    if (interrupt_signal() != 0) return;
    auto image = read_view_mask(artifact, static_cast<MaskClass>(mask), views[i]);
    if (!image) return;
    double sum = 0;
    for (float m : image->data()) sum += m;
    coverage[i] = sum / double(image->pixel_count());
    for (size_t level = 0; level < kLevels; ++level) {
      image = sized(*image, capture.photos[i].levels[level].view.intrinsics);
      targets.photos[i][level].masks[mask] = quantised(*image);
    }
  });
  throw_if_interrupted();
  return coverage;
}

void warn_of_coverage(std::string_view name, double share, Targets& targets) {
  if (share > kMostCoverage)
    targets.warnings.push_back(
        {"MASK_COVERS_MOST", fmt::format("the {} masks mark {:.0f} % of the photos: are they inverted?", name, 100 * share)});
}

void load_masks(const Capture& capture, const fs::path& artifact, Targets& targets) {
  for (const MaskClass kind : {MaskClass::Object, MaskClass::Ignore}) {
    const auto mask = static_cast<size_t>(kind);
    const std::string name(vitrine::name(kind));
    const fs::path folder = artifact / "masks" / name;
    if (!fs::is_directory(folder)) continue;
    const std::vector<double> coverage = load_class(capture, artifact, mask, targets);
    size_t found = 0, marked = 0;
    double sum = 0;
    for (double c : coverage) {
      found += std::isfinite(c);
      marked += c > 0;
      sum += std::isfinite(c) ? c : 0;
    }
    if (found == 0)
      throw Error(ErrorKind::Input, fmt::format("no {} mask belongs to a photo", name),
                  {.where = folder.string(),
                   .why = fmt::format("none of its files is called like a photo, {}.png for example",
                                      capture.view_set.views.front().stem()),
                   .hint = "run the masks stage again",
                   .code = "MASKS_MATCH_NO_PHOTO"});
    if (found < coverage.size())
      targets.warnings.push_back(
          {"MASKS_INCOMPLETE", fmt::format("{} of {} photos have no {} mask", coverage.size() - found, coverage.size(), name)});
    targets.has[mask] = marked > 0;
    if (marked == 0) {
      targets.warnings.push_back({"MASK_EMPTY", fmt::format("the {} masks are black in every photo: not used", name)});
      for (auto& photo : targets.photos)
        for (TargetLevel& level : photo) level.masks[mask].clear();
    }
    if (kind == MaskClass::Ignore) warn_of_coverage(name, sum / double(found), targets);
  }
}

// Masks of glass and reflective objects. A mirror without a known shape reflects with its surfels, like a coat.
void load_labels(const Capture& capture, const LabelledObjects& objects, Targets& targets) {
  const ObjectSet& set = objects.objects();
  const auto glass = [](const Object& o) { return is_glass(o.role); };
  const auto mirrors = [&](const Object& o) { return is_glass(o.role) || set.is_drawn_mirror(o); };
  const auto coated = [&](const Object& o) { return is_specular(o.role) && !mirrors(o); };
  const auto& views = capture.view_set.views;
  const auto load = [&](const auto& counts, const auto& plane_of) {
    parallel_for(views.size(), 1, [&](size_t i) {
      if (interrupt_signal() != 0) return;
      ImageF image = objects.coverage(views[i], views[i].intrinsics, counts);
      for (size_t level = 0; level < kLevels && !image.empty(); ++level) {
        image = sized(image, capture.photos[i].levels[level].view.intrinsics);
        plane_of(targets.photos[i][level]) = quantised(image);
      }
    });
    throw_if_interrupted();
  };
  const auto plane_of = [](MaskClass kind) {
    return [kind](TargetLevel& level) -> std::vector<uint8_t>& { return level.masks[static_cast<size_t>(kind)]; };
  };
  const auto coat_plane = [](TargetLevel& level) -> std::vector<uint8_t>& { return level.coat; };
  if (objects.any(glass)) load(glass, plane_of(MaskClass::Transparent));
  if (!set.empty()) load(mirrors, plane_of(MaskClass::Specular));
  if (objects.any(coated)) load(coated, coat_plane);
  const auto share = [&](const auto& plane) {
    double sum = 0, count = 0;
    for (auto& photo : targets.photos) {
      for (const uint8_t m : plane(photo[0])) sum += m / 255.0;
      count += double(plane(photo[0]).size());
    }
    return count > 0 ? sum / count : 0;
  };
  const double transparent = share(plane_of(MaskClass::Transparent));
  const double specular = share(plane_of(MaskClass::Specular)) + share(coat_plane);
  targets.has[size_t(MaskClass::Transparent)] = transparent > 0;
  targets.has[size_t(MaskClass::Specular)] = specular > 0;
  warn_of_coverage(name(MaskClass::Transparent), transparent, targets);
  warn_of_coverage(name(MaskClass::Specular), specular, targets);
}

void load_normals(const Capture& capture, const fs::path& artifact, Targets& targets) {
  const auto& views = capture.view_set.views;
  std::vector<uint8_t> found(views.size(), 0);
  parallel_for(views.size(), 1, [&](size_t i) {
    const fs::path path = artifact / "normals" / (views[i].stem() + ".exr");
    if (interrupt_signal() != 0 || !fs::exists(path)) return;
    const ExrImage file = read_exr(path);
    if (file.pixels.channels() != 3)
      throw Error(ErrorKind::Input, "a file of normals has the wrong channels",
                  {.where = path.string(),
                   .why = fmt::format("{} channels instead of X, Y, Z", file.pixels.channels()),
                   .hint = "run the normals stage again",
                   .code = "BAD_NORMALS"});
    const fs::path confidence_path = artifact / "normals" / (views[i].stem() + "_confidence.png");
    std::optional<ImageF> confidence;
    if (fs::exists(confidence_path)) confidence = read_unchanged(confidence_path);
    for (size_t level = 0; level < kLevels; ++level) {
      const Intrinsics& k = capture.photos[i].levels[level].view.intrinsics;
      TargetLevel& target = targets.photos[i][level];
      target.normals = quantised_normals(sized(file.pixels, k));
      if (confidence) target.confidence = quantised(sized(*confidence, k));
    }
    found[i] = 1;
  });
  throw_if_interrupted();
  const auto count = static_cast<size_t>(std::count(found.begin(), found.end(), 1));
  if (count == 0) {
    const auto is_map = [](const fs::directory_entry& file) { return file.path().extension() == ".exr"; };
    const fs::path folder = artifact / "normals";
    if (!fs::is_directory(folder) || std::none_of(fs::recursive_directory_iterator(folder), {}, is_map)) return;  // source: none
    throw Error(
        ErrorKind::Input, "no file of normals belongs to a photo",
        {.where = (artifact / "normals").string(), .hint = "run the normals stage again", .code = "NORMALS_MATCH_NO_PHOTO"});
  }
  if (count < views.size())
    targets.warnings.push_back(
        {"NORMALS_INCOMPLETE", fmt::format("{} of {} photos have no normals", views.size() - count, views.size())});
  targets.has_normals = true;
}

}  // namespace

void Targets::forget(MaskClass mask) {
  has[static_cast<size_t>(mask)] = false;
  for (auto& photo : photos)
    for (TargetLevel& level : photo) level.masks[static_cast<size_t>(mask)].clear();
}

void Targets::ignore_outside(const Targets& trained) {
  for (size_t photo = 0; photo < photos.size(); ++photo)
    for (size_t level = 0; level < kLevels; ++level) {
      const std::vector<uint8_t>& object = trained.photos[photo][level].masks[size_t(MaskClass::Object)];
      std::vector<uint8_t>& ignore = photos[photo][level].masks[size_t(MaskClass::Ignore)];
      ignore.resize(std::max(ignore.size(), object.size()), 0);
      for (size_t i = 0; i < object.size(); ++i) ignore[i] = std::max(ignore[i], uint8_t(255 - object[i]));
      has[size_t(MaskClass::Ignore)] |= !object.empty();
    }
}

Targets load_targets(const Capture& capture, const std::optional<fs::path>& masks, const LabelledObjects& objects,
                     const std::optional<fs::path>& normals) {
  Targets targets;
  targets.photos.resize(capture.photos.size());
  if (masks) load_masks(capture, *masks, targets);
  load_labels(capture, objects, targets);
  if (normals) load_normals(capture, *normals, targets);
  for (const auto& photo : targets.photos)
    for (const TargetLevel& level : photo) {
      for (const auto& mask : level.masks) targets.memory_bytes += mask.size();
      targets.memory_bytes += level.coat.size() + level.normals.size() * sizeof(int16_t) + level.confidence.size();
    }
  return targets;
}

void decode(const TargetLevel& level, TargetImages& images) {
  constexpr size_t kChunk = 1 << 16;
  const auto scaled = [](const auto& from, float factor, std::vector<float>& to) {
    to.resize(from.size());
    parallel_chunks(to.size(), kChunk, [&](size_t, size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) to[i] = static_cast<float>(from[i]) * factor;
    });
  };
  for (size_t m = 0; m < level.masks.size(); ++m) scaled(level.masks[m], 1.f / 255.f, images.masks[m]);
  scaled(level.coat, 1.f / 255.f, images.coat);
  scaled(level.normals, 1.f / kFullScale, images.normals);
  scaled(level.confidence, 1.f / 255.f, images.confidence);
}

LossTargets TargetImages::spans() const {
  return {.specular = mask(MaskClass::Specular),
          .transparent = mask(MaskClass::Transparent),
          .object = mask(MaskClass::Object),
          .ignore = mask(MaskClass::Ignore),
          .normals = normals,
          .normal_confidence = confidence,
          .coat = coat};
}

}  // namespace vitrine
