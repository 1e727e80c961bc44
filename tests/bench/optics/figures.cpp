#include "tests/bench/optics/figures.h"

#include <string_view>

#include <fmt/format.h>

namespace vitrine {
namespace {

constexpr FigureKind kFigureKinds[] = {
    {"all", "heldout.psnr", "all", 2, true, true},
    {"glass_pooled", "regions.transparent.pooled_psnr", "glass", 2, true, true},
    {"mirror_pooled", "regions.mirror.pooled_psnr", "mirror", 2, true, true},
    {"coated_pooled", "regions.coated.pooled_psnr", "coated", 2, true, true},
    {"rest_pooled", "regions.rest.pooled_psnr", "rest", 2, true, true},
    {"glass", "regions.transparent.psnr", "", 2, true, false},
    {"mirror", "regions.mirror.psnr", "", 2, true, false},
    {"coated", "regions.coated.psnr", "", 2, true, false},
    {"rest", "regions.rest.psnr", "", 2, true, false},
    {"mirror_correlation", "regions.mirror.correlation", "mirror c.", 2, true, true},
    {"coated_correlation", "regions.coated.correlation", "coated c.", 2, true, true},
    {"behind_glass", "truth.transmitted.psnr", "behind", 2, true, true},
    {"albedo", "truth.albedo.psnr", "albedo", 2, true, true},
    {"relit", "truth.relit.psnr", "relit", 2, true, true},
    {"relit_glass", "truth.relit.regions.transparent.psnr", "relit glass", 2, true, true},
    {"relit_mirror", "truth.relit.regions.mirror.psnr", "relit mirror", 2, true, true},
    {"relit_coated", "truth.relit.regions.coated.psnr", "relit coated", 2, true, true},
    {"normals", "truth.normal_mae_deg", "normals", 1, false, true},
    {"normals_glass", "truth.regions.transparent.normal_mae_deg", "n.glass", 1, false, true},
    {"normals_mirror", "truth.regions.mirror.normal_mae_deg", "n.mirror", 1, false, true},
    {"normals_coated", "truth.regions.coated.normal_mae_deg", "n.coated", 1, false, true},
    {"normals_rest", "truth.regions.rest.normal_mae_deg", "n.rest", 1, false, true},
    {kCpuFigure, "", "CPU s", 0, false, true},
    {"ssim", "heldout.ssim", "SSIM", 4, true, false},
    {"flip", "heldout.flip", "FLIP", 4, false, false},
    {"train", "train.psnr", "train", 2, true, false},
    {"object", "regions.object.psnr", "object", 2, true, false},
    {"specular", "regions.specular.psnr", "specular", 2, true, false},
    {"depth", "truth.depth_rel", "depth", 5, false, false},
    {"normals_glass_median", "truth.regions.transparent.normal_median_deg", "", 1, false, false},
    {"normals_mirror_median", "truth.regions.mirror.normal_median_deg", "", 1, false, false},
    {"normals_coated_median", "truth.regions.coated.normal_median_deg", "", 1, false, false},
    {"normals_rest_median", "truth.regions.rest.normal_median_deg", "", 1, false, false},
    {"surfels", "surfels", "surfels", 0, false, false},
};

const nlohmann::json* found_at(const nlohmann::json& document, std::string_view path) {
  const nlohmann::json* at = &document;
  while (!path.empty()) {
    const size_t dot = std::min(path.find('.'), path.size());
    const auto it = at->is_object() ? at->find(std::string(path.substr(0, dot))) : at->end();
    if (!at->is_object() || it == at->end()) return nullptr;
    at = &*it;
    path.remove_prefix(std::min(dot + 1, path.size()));
  }
  return at->is_number() ? at : nullptr;
}

}  // namespace

std::span<const FigureKind> figure_kinds() { return kFigureKinds; }

Figures figures_of(const nlohmann::json& metrics) {
  const auto has = [&](const char* path) { return found_at(metrics, path) != nullptr; };
  const bool coats_known = has("regions.coated.psnr") || has("regions.mirror.psnr") ||
                           has("truth.regions.coated.normal_mae_deg") || has("truth.regions.mirror.normal_mae_deg");
  Figures figures;
  for (const FigureKind& kind : kFigureKinds) {
    std::string path = kind.path;
    if (path.empty()) continue;
    if (const size_t at = path.find(".mirror."); at != std::string::npos && !coats_known) path.replace(at, 8, ".reflective.");
    if (const nlohmann::json* value = found_at(metrics, path)) figures[kind.name] = value->get<double>();
  }
  if (const auto objects = metrics.find("objects"); objects != metrics.end() && objects->is_array())
    for (const nlohmann::json& object : *objects)
      if (const nlohmann::json* value = found_at(object, "pooled_psnr"))
        figures[fmt::format("{}{} {}", kObjectFigure, object.value("role", ""), object.value("name", ""))] = value->get<double>();
  return figures;
}

}  // namespace vitrine
