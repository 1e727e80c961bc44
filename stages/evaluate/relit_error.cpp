#include "stages/evaluate/relit_error.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/foundation/base/file.h"
#include "core/scene/camera/projection.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/metrics.h"
#include "core/scene/image/resample.h"
#include "core/foundation/math/color.h"
#include "core/foundation/math/quantile.h"
#include "stages/evaluate/alignment.h"
#include "stages/evaluate/view_error.h"

namespace vitrine {

namespace {

constexpr int kFewestPixels = 64;

// One view under one environment, truth and ours on the same pixels, linear.
struct Pair {
  size_t view = 0;
  ImageF truth, ours, known, object, opaque;  // the last three: 0 or 1
  RegionMasks regions;                        // where the truth is known
};

ImageF srgb(const ImageF& linear, const Vec3d& scale, const ImageF& known) {
  ImageF out(linear.width(), linear.height(), 3);
  for (size_t i = 0; i < out.data().size(); ++i)
    if (known.data()[i / 3] > 0) out.data()[i] = srgb_from_linear(std::clamp(float(scale[i % 3]) * linear.data()[i], 0.f, 1.f));
  return out;
}

Pair pair_of(size_t view, ImageF ours, const Intrinsics& k, const TruthPicture& truth, RegionMasks regions) {
  Pair p{view,
         ImageF(k.width, k.height, 3),
         std::move(ours),
         ImageF(k.width, k.height, 1),
         ImageF(k.width, k.height, 1),
         ImageF(k.width, k.height, 1),
         std::move(regions)};
  const double shrink = std::max(1.0, double(truth.intrinsics.width) / k.width);
  const Intrinsics from = truth.intrinsics.scaled_to(int(std::lround(truth.intrinsics.width / shrink)),
                                                     int(std::lround(truth.intrinsics.height / shrink)));
  const ImageF map = shrink > 1 ? resized(truth.radiance, from.width, from.height) : truth.radiance;
  const auto region = [&](const char* name) {
    const auto it = p.regions.find(name);
    return it == p.regions.end() ? nullptr : &it->second;
  };
  const ImageF *object = region("object"), *glass = region("transparent");
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const auto at = image_point(truth.truth_from_ours * k.ray(x + 0.5, y + 0.5), from);
      if (!at) continue;
      sample_bilinear(map, at->x, at->y, p.truth.pixel(x, y));
      p.known.at(x, y) = 1;
      p.object.at(x, y) = object == nullptr || object->at(x, y) > 0.5f ? 1.f : 0.f;
      p.opaque.at(x, y) = glass != nullptr && glass->at(x, y) > 0.5f ? 0.f : p.object.at(x, y);
    }
  for (auto& [name, pixels] : p.regions) keep_within(p.known, pixels);
  return p;
}

Vec3d median_scale(const std::vector<Pair>& pairs) {
  Vec3d scale{1, 1, 1};
  for (size_t c = 0; c < 3; ++c) {
    std::vector<double> ratio;
    for (const Pair& p : pairs)
      for (size_t i = 0; i < p.object.data().size(); ++i)
        if (p.opaque.data()[i] > 0 && p.ours.data()[3 * i + c] > 1e-4f)
          ratio.push_back(double(p.truth.data()[3 * i + c]) / double(p.ours.data()[3 * i + c]));
    if (!ratio.empty()) scale[c] = median(std::move(ratio));
  }
  return scale;
}

int count_of(const ImageF& mask) {
  return int(std::ranges::count_if(mask.data(), [](float v) { return v > 0; }));
}

RelitScore score_of(const std::vector<Pair>& pairs, const RelitErrorDesc& desc, const std::string& environment) {
  RelitScore score;
  score.environment = environment;
  score.scale = desc.albedo_scale ? Vec3d{1, 1, 1} : median_scale(pairs);
  std::vector<double> object, opaque, everywhere, similarity;
  std::map<std::string, std::vector<double>> regions;
  for (const Pair& p : pairs) {
    const ImageF truth = srgb(p.truth, {1, 1, 1}, p.known), ours = srgb(p.ours, score.scale, p.known);
    if (count_of(p.object) >= kFewestPixels) object.push_back(psnr(ours, truth, &p.object));
    if (count_of(p.opaque) >= kFewestPixels) opaque.push_back(psnr(ours, truth, &p.opaque));
    for (const auto& [region, mask] : p.regions)
      if (region != "object" && count_of(mask) >= kFewestPixels) regions[region].push_back(psnr(ours, truth, &mask));
    if (count_of(p.known) >= kFewestPixels) {
      everywhere.push_back(psnr(ours, truth, &p.known));
      similarity.push_back(ssim(ours, truth));
    }
    if (desc.pictures.empty()) continue;
    ImageF both(2 * truth.width(), truth.height(), 3);
    for (int y = 0; y < truth.height(); ++y) {
      std::copy_n(truth.pixel(0, y), 3 * size_t(truth.width()), both.pixel(0, y));
      std::copy_n(ours.pixel(0, y), 3 * size_t(truth.width()), both.pixel(truth.width(), y));
    }
    Image8 picture(both.width(), both.height(), 3);
    for (size_t i = 0; i < both.data().size(); ++i) picture.data()[i] = uint8_t(std::lround(255 * both.data()[i]));
    const fs::path path = desc.pictures / environment / (desc.views[p.view].stem() + ".png");
    make_folders(path.parent_path());
    write_ldr(path, picture);
  }
  const auto mean_of = [](const std::vector<double>& v) { return v.empty() ? std::nullopt : std::optional(mean(v)); };
  score.views = everywhere.size();
  score.psnr = mean_of(opaque), score.with_glass_psnr = mean_of(object);
  score.everywhere_psnr = mean_of(everywhere), score.ssim = mean_of(similarity);
  for (const auto& [region, values] : regions) score.region_psnr[region] = mean(values);
  return score;
}

}  // namespace

std::vector<std::string> relit_environments(const Truth& truth) {
  std::vector<std::string> names;
  std::error_code ec;
  for (const auto& e : fs::directory_iterator(truth.folder() / "relit", ec))
    if (e.is_directory() && fs::exists(truth.folder() / "env" / (e.path().filename().string() + ".exr")))
      names.push_back(e.path().filename().string());
  std::ranges::sort(names);
  return names;
}

std::vector<RelitScore> relit_scores(RelitScene scene, const RelitRegions& regions, const RelitErrorDesc& desc,
                                     const std::function<void(double)>& progress) {
  if (desc.albedo_scale) {
    const auto scaled = [&](Vec3f& albedo) {
      for (size_t c = 0; c < 3; ++c) albedo[c] = std::min(1.f, float((*desc.albedo_scale)[c]) * albedo[c]);
    };
    std::ranges::for_each(scene.materials.albedo, scaled);
    std::ranges::for_each(scene.materials.albedo_behind_glass, scaled);
    std::ranges::for_each(scene.surroundings.colors, scaled);
    // An albedo that is too bright implies captured light that is too dim; this light illuminates the content behind glass.
    ImageF light = scene.captured.map();
    for (size_t i = 0; i < light.pixel_count(); ++i)
      for (size_t c = 0; c < 3; ++c) light.data()[3 * i + c] /= std::max(float((*desc.albedo_scale)[c]), 1e-6f);
    scene.captured = Environment(std::move(light), scene.captured.world_from_map());
  }
  RelitPainter painter(std::move(scene));
  const std::vector<std::string> names = relit_environments(desc.truth);
  std::vector<RelitScore> scores;
  for (size_t e = 0; e < names.size(); ++e) {
    std::vector<size_t> shown;
    for (size_t v = 0; v < desc.views.size(); ++v)
      if (desc.truth.has_relit(names[e], v)) shown.push_back(v);
    if (shown.empty()) continue;
    // Uniformly spaced.
    const size_t count = std::min(shown.size(), size_t(desc.max_views));
    const Environment map = read_environment(desc.truth.folder() / "env" / (names[e] + ".exr"));
    painter.set_lighting({.environment = map.turned(cast<float>(transposed(desc.truth_from_ours.rotation))),
                          .points = {},
                          .directionals = {},
                          .areas = {}});
    std::vector<Pair> pairs;
    for (size_t i = 0; i < count; ++i) {
      const size_t v = shown[i * shown.size() / count];
      View view = desc.views[v];
      const auto truth = desc.truth.relit(names[e], v, view.intrinsics);
      // A truth pixel is a mean over its area: ours is rendered at photo size and then averaged.
      const Intrinsics k = view.intrinsics.limited_to(truth->intrinsics.longest_side());
      const double finer = double(view.intrinsics.width) * view.intrinsics.height / (double(k.width) * k.height);
      const RelitPicture picture = painter.picture(view, {.samples = std::max(1, int(std::lround(desc.samples / finer)))});
      pairs.push_back(pair_of(v, resized(picture.radiance, k.width, k.height), k, *truth, regions(v, k)));
      progress((double(e) + double(i + 1) / double(count)) / double(names.size()));
    }
    scores.push_back(score_of(pairs, desc, names[e]));
  }
  return scores;
}

}  // namespace vitrine
