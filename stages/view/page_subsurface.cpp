#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/foundation/base/parallel.h"
#include "core/foundation/math/kd_tree.h"
#include "core/render/relight/subsurface.h"
#include "core/scene/surfels/activation.h"
#include "stages/view/page_surfels.h"

namespace vitrine {

namespace {

constexpr size_t kLenders = 24;      // places that lend light to a surfel
constexpr size_t kMostFound = 4096;  // surfels that these places stand for
constexpr float kReach = 5;          // in diffusion lengths
constexpr float kSharedUnit = 255;
constexpr size_t kTaskSurfels = 256;

float disc_area(const SplatLayer& layer, size_t i) {
  const float* s = layer.at(Attribute::LogScale, i);
  return std::numbers::pi_v<float> * std::exp(s[0] + s[1]) * sigmoid(*layer.at(Attribute::Opacity, i));
}

}  // namespace

void add_subsurface(const RelitScene& scene, const PageSurfels& surfels, PageBlocks& blocks) {
  const DecomposedMaterials& m = scene.materials;
  std::vector<uint32_t> which;
  std::vector<Vec3f> places, d;
  for (uint32_t k = 0; !m.scatter.empty() && k < surfels.drawn; ++k) {
    const uint32_t i = surfels.of_diffuse[k];
    if (i == UINT32_MAX || m.scatter[i] == Vec3f{}) continue;
    const float* mean = surfels.layer.at(Attribute::Mean, k);
    which.push_back(k), places.push_back({mean[0], mean[1], mean[2]});
    d.emplace_back();
    for (size_t c = 0; c < 3; ++c) d.back()[c] = diffusion_length(m.scatter[i][c], m.albedo[i][c]);
  }
  if (which.empty()) return;
  const KdTreef tree(places);
  std::vector<uint32_t> lenders(which.size() * kLenders);
  std::vector<uint8_t> shares(which.size() * kLenders * 3);
  parallel_for(which.size(), kTaskSurfels, [&](size_t at) {
    std::vector<KdTreef::Near> found;
    tree.nearest(places[at], kMostFound, kReach * std::max({d[at].x, d[at].y, d[at].z}), found);
    // Consecutive distances share a place: the one in the middle.
    std::array<Vec3f, kLenders> weight{};
    Vec3f sum{};
    for (size_t j = 0; j < kLenders; ++j) {
      const size_t first = j * found.size() / kLenders, last = (j + 1) * found.size() / kLenders;
      lenders[at * kLenders + j] = which[first < last ? found[(first + last) / 2].index : at];
      for (size_t n = first; n < last; ++n) {
        const float area = disc_area(surfels.layer, which[found[n].index]), r = std::sqrt(found[n].squared_distance);
        const float disc = std::sqrt(area / std::numbers::pi_v<float>);
        for (size_t c = 0; c < 3; ++c)
          weight[j][c] += n == 0 ? leaves_within(disc, d[at][c]) : area * diffusion_profile(std::max(r, disc), d[at][c]);
      }
      sum += weight[j];
    }
    for (size_t j = 0; j < kLenders; ++j)
      for (size_t c = 0; c < 3; ++c)
        shares[(at * kLenders + j) * 3 + c] = uint8_t(std::lround(kSharedUnit * weight[j][c] / std::max(sum[c], 1e-20f)));
  });
  blocks.indices("scattering", which, 1);
  blocks.indices("lender", lenders, int(kLenders));
  blocks.bytes("lent_share", shares, int(3 * kLenders));
}

}  // namespace vitrine
