#include "core/render/model/opened_scene.h"

#include <algorithm>

#include "core/foundation/base/parallel.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {

namespace {

constexpr size_t kOpenedGrain = 512;   // surfels per parallel chunk
constexpr float kNotSpecular = 1e-4f;  // k_s and tau of opaque, non-specular surfels
constexpr Attribute kShapeAndColor[] = {Attribute::Mean,    Attribute::Rotation, Attribute::LogScale,
                                        Attribute::Opacity, Attribute::ShDc,     Attribute::ShRest};
constexpr Attribute kSurfaceMaterials[] = {Attribute::F0, Attribute::Roughness, Attribute::SpecularWeight,
                                           Attribute::Transmission};

// Coefficients above the used degree are not part of the picture, whatever the degree of the other layer.
size_t used_width(const SplatLayer& layer, Attribute a, int degree) {
  return a == Attribute::ShRest ? 3 * (sh_coefficient_count(degree) - 1) : layer.width(a);
}

void gather(const SplatScene& scene, OpenedDegrees degrees, LayerKind kind, OpenedScene& opened) {
  const SplatLayer& diffuse = scene.diffuse;
  auto& [merged, opaque] = opened;
  opaque = opaque_surfels(diffuse);
  const int degree = std::max(degrees.diffuse, degrees.transmittance);
  const size_t count = opaque.size() + scene.transmittance.size();
  if (merged.kind() != kind || merged.sh_degree() != degree) merged = SplatLayer(kind, degree, count);
  merged.resize(count);
  const bool materials = kind == LayerKind::Diffuse;
  parallel_chunks(count, kOpenedGrain, [&](size_t, size_t first, size_t last) {
    for (size_t k = first; k < last; ++k) {
      const bool own = k >= opaque.size();
      const SplatLayer& from = own ? scene.transmittance : diffuse;
      const size_t i = own ? k - opaque.size() : opaque[k];
      for (Attribute a : kShapeAndColor) {
        const size_t used = used_width(from, a, own ? degrees.transmittance : degrees.diffuse);
        std::fill(std::copy_n(from.at(a, i), used, merged.at(a, k)), merged.at(a, k) + merged.width(a), 0.f);
      }
      if (!materials) continue;
      for (Attribute a : kSurfaceMaterials) {
        const bool dull = a == Attribute::SpecularWeight || a == Attribute::Transmission;
        if (own)
          std::fill_n(merged.at(a, k), merged.width(a), raw_value(row(a).activation, dull ? kNotSpecular : row(a).initial));
        else
          std::copy_n(diffuse.at(a, i), diffuse.width(a), merged.at(a, k));
      }
    }
  });
}

}  // namespace

std::vector<uint32_t> opaque_surfels(const SplatLayer& diffuse) {
  std::vector<uint32_t> out;
  for (size_t i = 0; i < diffuse.size(); ++i)
    if (!is_glass(diffuse, i)) out.push_back(static_cast<uint32_t>(i));
  return out;
}

OpenedDegrees opened_degrees(const SplatScene& scene, const ImageOptions& options) {
  return {std::min(options.diffuse.sh_degree, scene.diffuse.sh_degree()),
          std::min(options.transmission.sh_degree, scene.transmittance.sh_degree())};
}

void without_glass(const SplatScene& scene, OpenedDegrees degrees, OpenedScene& opened) {
  gather(scene, degrees, LayerKind::Transmittance, opened);
}

void without_glass_with_materials(const SplatScene& scene, OpenedDegrees degrees, OpenedScene& opened) {
  if (scene.transmittance.size() == 0) degrees.transmittance = 0;
  gather(scene, degrees, LayerKind::Diffuse, opened);
}

void give_back(OpenedDegrees degrees, const OpenedGradients& from, Frame& frame, SplatScene& grad) {
  const auto& [merged, opaque] = frame.opened;
  const bool materials = merged.kind() == LayerKind::Diffuse;
  frame.transmission.took_part |= merged.size() > opaque.size();
  parallel_chunks(merged.size(), kOpenedGrain, [&](size_t, size_t first, size_t last) {
    for (size_t k = first; k < last; ++k) {
      const bool own = k >= opaque.size();
      SplatLayer& to = own ? grad.transmittance : grad.diffuse;
      const size_t i = own ? k - opaque.size() : opaque[k];
      const int degree = std::min(own ? degrees.transmittance : degrees.diffuse, to.sh_degree());
      for (Attribute a : kShapeAndColor)
        for (size_t c = 0, used = used_width(to, a, degree); c < used; ++c) to.at(a, i)[c] += from.surfels.at(a, k)[c];
      if (materials && !own)
        for (Attribute a : kSurfaceMaterials)
          for (size_t c = 0; c < to.width(a); ++c) to.at(a, i)[c] += from.surfels.at(a, k)[c];
      SurfelStatistics& statistics = own ? frame.transmission.statistics : frame.statistics;
      statistics.screen_gradient[i] += from.statistics.screen_gradient[k];
      statistics.weight[i] += from.statistics.weight[k];
      statistics.error[i] += from.statistics.error[k];
    }
  });
}

}  // namespace vitrine
