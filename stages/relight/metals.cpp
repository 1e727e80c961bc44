#include "stages/relight/metals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "core/base/rng.h"
#include "core/camera/view_set.h"
#include "core/image/exr.h"
#include "core/image/resample.h"
#include "core/render/renderer.h"
#include "core/render/surface_depth.h"
#include "core/trace/tracer.h"
#include "stages/relight/light_solver.h"

namespace vitrine {

namespace {

constexpr float kMinAlpha = 0.5f, kMinCosine = 0.3f, kShortestMetalNormal = 0.05f;
constexpr float kBrightest = 0.95f;      // of a photo; more is clipped, and white whatever the metal
constexpr size_t kFewestPixels = 300;    // of a metal, over all views
constexpr double kLeastReflects = 0.2;   // less is paint with gloss
constexpr float kLeastCoverage = 0.05f;  // of a ray by surfels: less shows the light beyond
constexpr float kLeastLight = 1e-3f;     // mean of the mirrored light
constexpr double kSureness = 4;  // power of a pixel's trained reflection in its weight: margins of the mask reflect little

using Cell = std::array<int64_t, 3>;
struct CellHash {
  size_t operator()(const Cell& c) const {
    return static_cast<size_t>(mix64(mix64(uint64_t(c[0]), uint64_t(c[1])), uint64_t(c[2])));
  }
};

struct CellCount {
  float mirror = 0, all = 0;
  int metal = -1;
  bool is_mirror() const { return mirror > 0.5f * all; }
};

struct Samples {
  std::vector<Vec3f> origins, directions, photo;
  std::vector<float> reflects;
};

class Finder {
 public:
  explicit Finder(const MetalsDesc& desc) : d_(desc), layer_(desc.scene.surfels.diffuse) {}

  Metals run() {
    const std::unique_ptr<Renderer> renderer = make_renderer(Backend::Cpu);
    for (const View& v : d_.views) look_at(v, *renderer);
    connect();
    Metals out{measured(), std::vector<int>(layer_.size(), -1)};
    for (size_t i = 0; i < layer_.size(); ++i) {
      const float* p = layer_.at(Attribute::Mean, i);
      const auto it = cells_.find(cell_of({p[0], p[1], p[2]}));
      if (it != cells_.end()) out.of_surfel[i] = it->second.metal;
    }
    return out;
  }

 private:
  Cell cell_of(const Vec3f& p) const {
    Cell c;
    for (size_t i = 0; i < 3; ++i) c[i] = static_cast<int64_t>(std::floor(p[i] / d_.cell));
    return c;
  }

  void look_at(const View& view, Renderer& renderer) {
    RasterDesc raster;
    raster.intrinsics = view.intrinsics.limited_to(d_.max_side);
    const Intrinsics& k = raster.intrinsics;
    const ImageF mirrors = d_.mirrors(view, k);
    if (mirrors.empty()) return;
    raster.cam_from_world = view.cam_from_world;
    raster.features = FeatureSet::Material;
    raster.sh_degree = layer_.sh_degree();
    raster.near_z = d_.scene.image.diffuse.near_z;
    RasterImages images;
    renderer.forward(layer_, raster, images);
    const size_t pixels = size_t(k.width) * size_t(k.height);
    const auto normals = images.plane(Aov::Normal), zsum = images.plane(Aov::ZDepth), alpha = images.plane(Aov::Alpha);
    const auto median = images.plane(Aov::MedianZ), specular = images.plane(Aov::SpecularWeight), f0 = images.plane(Aov::F0);
    const ImageF photo = resized(read_exr_rgb(linear_image_path(d_.sfm_folder, view)), k.width, k.height);
    const Rigid world_from_cam = inverse(view.cam_from_world);
    const Vec3f eye = cast<float>(world_from_cam.translation);
    for (size_t p = 0; p < pixels; ++p) {
      const float a = alpha[p], z = a >= kMinAlpha ? surface_depth(zsum[p], a, median[p]) : 0;
      const Vec3f blended{normals[p], normals[pixels + p], normals[2 * pixels + p]};
      const float size = length(blended);
      if (!(z > 0) || !std::isfinite(z) || !(size > kShortestMetalNormal)) continue;
      const Vec3d ray = k.ray(double(p % size_t(k.width)) + 0.5, double(p / size_t(k.width)) + 0.5);
      const Vec3f position = cast<float>(world_from_cam * (double(z) * ray)), n = blended / size;
      CellCount& cell = cells_[cell_of(position)];
      cell.all += 1;
      if (!(mirrors.data()[p] > 0.5f)) continue;
      cell.mirror += 1;
      const Vec3f towards = normalized(eye - position);
      const float cosine = dot(n, towards);
      Vec3f radiance;
      float brightest = 0;
      for (size_t c = 0; c < 3; ++c) {
        brightest = std::max(brightest, photo.data()[3 * p + c]);
        radiance[c] = photo.data()[3 * p + c] / float(view.gain[c]);
      }
      if (!(cosine > kMinCosine) || brightest > kBrightest) continue;
      const BlendMaterial<float> material{.f0 = {f0[p] / a, f0[pixels + p] / a, f0[2 * pixels + p] / a},
                                          .specular = specular[p] / a,
                                          .transmission = 0,
                                          .cosine = cosine};
      const Vec3f weight = layer_weights<float>(d_.scene.image.composite.blend, material, {.reflection = true}).reflection;
      samples_.origins.push_back(position);
      samples_.directions.push_back(2 * cosine * n - towards);
      samples_.photo.push_back(radiance);
      samples_.reflects.push_back((weight.x + weight.y + weight.z) / 3);
    }
  }

  // Numbers the connected cells, in the order of the samples.
  void connect() {
    for (const Vec3f& p : samples_.origins) {
      CellCount& first = cells_.at(cell_of(p));
      if (!first.is_mirror() || first.metal >= 0) continue;
      first.metal = count_;
      std::vector<Cell> open{cell_of(p)};
      while (!open.empty()) {
        const Cell c = open.back();
        open.pop_back();
        for (int64_t n = 0; n < 27; ++n) {
          const auto it = cells_.find({c[0] + n % 3 - 1, c[1] + n / 3 % 3 - 1, c[2] + n / 9 - 1});
          if (it == cells_.end() || !it->second.is_mirror() || it->second.metal >= 0) continue;
          it->second.metal = count_;
          open.push_back(it->first);
        }
      }
      ++count_;
    }
  }

  // A ray that meets the metal again, or for the first time where its place was missed, brings back the tint that is looked for.
  bool shows_metal(size_t ray, const RayValues& seen) const {
    const float coverage = 1 - seen.transmittance[ray];
    if (!(coverage > kLeastCoverage)) return false;
    const auto it = cells_.find(cell_of(samples_.origins[ray] + seen.distance[ray] / coverage * samples_.directions[ray]));
    return it != cells_.end() && it->second.metal >= 0;
  }

  std::vector<Metal> measured() {
    const std::unique_ptr<Tracer> tracer = make_tracer();
    tracer->build(layer_);
    RayValues seen;
    const std::vector<float> near(samples_.origins.size(), d_.reach);
    tracer->forward({.origins = samples_.origins, .directions = samples_.directions, .near = near},
                    {.sh_degree = layer_.sh_degree()}, seen, nullptr);
    struct Sum {
      Vec3d photo{}, light{};
      double reflects = 0, pixels = 0, sure = 0;
    };
    std::vector<Sum> sums(static_cast<size_t>(count_));
    for (size_t i = 0; i < samples_.origins.size(); ++i) {
      const int metal = cells_.at(cell_of(samples_.origins[i])).metal;
      if (metal < 0 || shows_metal(i, seen)) continue;
      Sum& s = sums[static_cast<size_t>(metal)];
      const double sure = std::pow(double(samples_.reflects[i]), kSureness);
      s.photo += sure * cast<double>(samples_.photo[i]);
      s.light += sure * cast<double>(seen.color[i] + seen.transmittance[i] * d_.environment.radiance(samples_.directions[i]));
      s.sure += sure;
      s.reflects += samples_.reflects[i];
      s.pixels += 1;
    }
    // Those that say enough, numbered anew.
    std::vector<Metal> metals;
    std::vector<int> number(sums.size(), -1);
    for (size_t m = 0; m < sums.size(); ++m) {
      const Sum& s = sums[m];
      if (s.pixels < double(kFewestPixels) || s.reflects < kLeastReflects * s.pixels) continue;
      if (s.photo.x + s.photo.y + s.photo.z == 0) continue;
      if (std::min({s.light.x, s.light.y, s.light.z}) < double(kLeastLight) * s.sure) continue;
      Metal metal{.tint = {}, .pixels = size_t(s.pixels), .reflects = float(s.reflects / s.pixels)};
      for (size_t c = 0; c < 3; ++c) metal.tint[c] = float(s.photo[c] / s.light[c]);
      metal.tint = metal.tint / luminance(metal.tint);
      number[m] = static_cast<int>(metals.size());
      metals.push_back(metal);
    }
    for (auto& [key, cell] : cells_)
      if (cell.metal >= 0) cell.metal = number[static_cast<size_t>(cell.metal)];
    return metals;
  }

  const MetalsDesc& d_;
  const SplatLayer& layer_;
  std::unordered_map<Cell, CellCount, CellHash> cells_;
  Samples samples_;
  int count_ = 0;
};

}  // namespace

Metals find_metals(const MetalsDesc& desc) { return Finder(desc).run(); }

void tint_reflection(LayerBlend blend, const Vec3f& tint, float& specular_weight, Vec3f& f0) {
  constexpr auto kFull = static_cast<float>(kFullFresnel);
  if (specular_weight < kFull) return;
  const float grey = luminance(f0);
  if (blend == LayerBlend::RtrGs) {  // k F
    for (size_t c = 0; c < 3; ++c) f0[c] = std::min(1.f, grey * tint[c]);
    return;
  }
  // k + (1 - k) F: what k has goes over to F, which can have a colour.
  const float reflects = specular_weight + (1 - specular_weight) * grey;
  specular_weight = kFull;
  for (size_t c = 0; c < 3; ++c) f0[c] = std::clamp((reflects * tint[c] - kFull) / (1 - kFull), 0.f, 1.f);
}

}  // namespace vitrine
