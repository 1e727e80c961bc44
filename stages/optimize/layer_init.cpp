#include "stages/optimize/layer_init.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/foundation/math/rigid.h"
#include "core/learn/optim/adam.h"
#include "core/render/model/layered_model.h"
#include "core/render/model/opened_scene.h"
#include "core/render/model/surface_pass.h"
#include "core/render/raster/raster_desc.h"
#include "core/scene/camera/projection.h"
#include "core/scene/surfels/activation.h"
#include "stages/optimize/flat_mirrors.h"
#include "stages/optimize/initialise.h"

namespace vitrine {

namespace {

enum : uint64_t { kCopyStream = 0x1a01, kShellStream = 0x1a02, kHullStream = 0x1a03 };

constexpr size_t kEvidenceLevel = 0;
constexpr double kInitialLayerShare = 0.7;         // of a layer's cap, which leaves room for densification
constexpr double kShellShare = 0.25;               // of the reflection layer: surfels beyond everything that the photos show
constexpr double kShellNear = 1.5, kShellFar = 4;  // scene radii
constexpr float kFaint = 0.1f;                     // opacity of surfels without evidence
constexpr float kKnownReach = 2;                   // of the hull spacing: surfels this near to a known point represent it
constexpr float kMostlyInside = 0.5f;
// Surfels with a larger share of pixels on glass leave the diffuse layer.
constexpr float kBehindGlass = 0.9f;
constexpr double kMirrorDepth = 0.5;  // of its size: approximate depth of the virtual images in a convex mirror
// Minimum number of mirror pixels in all photos for starting as a mirror. A mirror shows only its reflections, which are black in
// directions without training rays, so too few pixels do not determine them. A glossy solid in 36 photos of 320x240 gains up to
// 1.4 dB, a ball in fifteen photos of 48x36 loses 3.
constexpr size_t kTellingPixels = 20000;
constexpr size_t kFewestShapePoints = 500;  // minimum on mirror shapes, even if photos show little of them
constexpr float kHullOpacity = 0.97f, kHullScale = 0.7f;
constexpr float kLargestGrowth = 2.5f;  // largest scale of copies that are fewer than the copied surfels

// Glass scatters hardly any light: nearly black diffuse colour.
const Vec3f kGlassColor = (0.02f - 0.5f) / kShDc * Vec3f{1, 1, 1};

void set(SplatLayer& layer, Attribute a, size_t i, double value) {
  std::fill_n(layer.at(a, i), layer.width(a), raw_value(row(a).activation, static_cast<float>(value)));
}

// Mask types that a survey sums up.
enum class Surveyed { Specular, Transparent, Coat };
const std::vector<uint8_t>& surveyed(const TargetLevel& level, Surveyed what) {
  if (what == Surveyed::Coat) return level.coat;
  return level.masks[size_t(what == Surveyed::Specular ? MaskClass::Specular : MaskClass::Transparent)];
}

// Sums over the training photos for each of `masks`, and the per-photo depths.
struct Survey {
  std::vector<MaskEvidence> evidence;      // [mask]
  std::vector<std::vector<float>> depths;  // [photo] empty where held out
};

Survey survey(const LayerInitDesc& desc, const SplatScene& scene, std::initializer_list<Surveyed> masks) {
  const size_t n = scene.diffuse.size();
  Survey found{{masks.size(), {std::vector<float>(n, 0.f), std::vector<float>(n, 0.f)}}, {}};
  found.depths.resize(desc.capture.photos.size());
  ImageModel model({.diffuse = {.sh_degree = desc.sh_degree, .near_z = desc.capture.near_z}});
  model.emplace<DiffusePass>();
  const SplatScene diffuse{.diffuse = scene.diffuse};
  SplatScene ignored{.diffuse = scene.diffuse.zeros_like()};
  Frame frame;
  for (uint32_t photo : desc.capture.train) {
    model.forward(diffuse, desc.capture.photos[photo].levels[kEvidenceLevel].view, frame);
    const size_t pixels = frame.pixel_count();
    const auto z = frame.diffuse.plane(Aov::ZDepth), alpha = frame.diffuse.plane(Aov::Alpha),
               median = frame.diffuse.plane(Aov::MedianZ);
    found.depths[photo].resize(pixels);
    for (size_t i = 0; i < pixels; ++i) found.depths[photo][i] = alpha[i] > 0.5f ? surface_depth(z[i], alpha[i], median[i]) : 0;
    for (size_t m = 0; m < masks.size(); ++m) {
      const auto& inside = surveyed(desc.targets.photos[photo][kEvidenceLevel], masks.begin()[m]);
      if (inside.empty()) continue;
      frame.error_image.resize(pixels);
      for (size_t i = 0; i < pixels; ++i) frame.error_image[i] = float(inside[i]) / 255.f;
      frame.grad_linear.assign(3 * pixels, 0.f);
      model.backward(diffuse, frame, ignored);
      for (size_t i = 0; i < n; ++i) {
        found.evidence[m].weight[i] += frame.statistics.weight[i];
        found.evidence[m].inside[i] += frame.statistics.error[i];
      }
    }
  }
  return found;
}

// `count` random elements of `from`, ascending.
std::vector<uint32_t> drawn(std::vector<uint32_t> from, size_t count, uint64_t seed, uint64_t stream) {
  if (from.size() <= count) return from;
  Rng rng(seed, stream);
  for (size_t i = from.size() - 1; i > 0; --i) std::swap(from[i], from[rng.below(static_cast<uint32_t>(i + 1))]);
  from.resize(count);
  std::sort(from.begin(), from.end());
  return from;
}

// Copies appearance and shape of a surfel to another layer, with the smaller spherical harmonics degree of both.
void copy_between(const SplatLayer& from, size_t i, SplatLayer& to, size_t j, float growth) {
  for (Attribute a :
       {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity, Attribute::ShDc, Attribute::ShRest})
    std::copy_n(from.at(a, i), std::min(from.width(a), to.width(a)), to.at(a, j));
  for (size_t c = 0; c < 2; ++c) to.at(Attribute::LogScale, j)[c] += std::log(growth);
}

// Standard deviation of the rasteriser's screen-space low-pass (core/render/raster/kernels/scalar_ops.h: exp(-d^2)), in world
// units at `p`: the mean over the photos that show it. Rays have no low-pass, so smaller copies would appear smaller than in the
// rasterised picture.
float pixel_footprint(const Capture& capture, const Vec3d& p) {
  constexpr double kLowPass = 0.70710678;
  double sum = 0, count = 0;
  for (uint32_t photo : capture.train) {
    const View& view = capture.photos[photo].levels[0].view;
    const auto q = image_point(p, view, 1e-6);
    if (!q) continue;
    sum += kLowPass * q->z / view.intrinsics.fx;
    count += 1;
  }
  return count > 0 ? static_cast<float>(sum / count) : 0.f;
}

// Appends at most `count` copies of the surfels at `indices` to `layer`; fewer copies are larger.
void append_copies(const Capture& capture, const SplatLayer& from, const std::vector<uint32_t>& indices, size_t count,
                   uint64_t seed, SplatLayer& layer) {
  const std::vector<uint32_t> taken = drawn(indices, count, seed, kCopyStream);
  if (taken.empty()) return;
  const float growth = std::min(kLargestGrowth, std::sqrt(float(indices.size()) / float(taken.size())));
  const size_t first = layer.size();
  layer.resize(first + taken.size());
  parallel_for(taken.size(), 256, [&](size_t k) {
    copy_between(from, taken[k], layer, first + k, growth);
    const float* mean = layer.at(Attribute::Mean, first + k);
    const float smallest = pixel_footprint(capture, {mean[0], mean[1], mean[2]});
    for (size_t c = 0; c < 2 && smallest > 0; ++c) {
      float& scale = layer.at(Attribute::LogScale, first + k)[c];
      scale = std::max(scale, std::log(smallest));
    }
  });
}

Vec3f mean_color(const SplatLayer& layer, const std::vector<uint32_t>& indices) {
  Vec3f sum{};
  for (uint32_t i : indices)
    for (size_t c = 0; c < 3; ++c) sum[c] += layer.at(Attribute::ShDc, i)[c] / float(indices.size());
  return sum;
}

// Appends far surfels that face the scene, uniform over directions and over the logarithm of the distance.
void append_shell(size_t count, const Vec3f& sh_dc, uint64_t seed, SplatLayer& layer) {
  const size_t first = layer.size();
  layer.resize(first + count);
  for (size_t k = 0; k < count; ++k) {
    Rng rng(seed, mix64(kShellStream, k));
    const double z = 2 * rng.uniform_double() - 1, azimuth = 2 * std::numbers::pi * rng.uniform_double();
    const double radius = kShellNear * std::pow(kShellFar / kShellNear, rng.uniform_double());
    const Vec3d out{std::sqrt(1 - z * z) * std::cos(azimuth), std::sqrt(1 - z * z) * std::sin(azimuth), z};
    const size_t i = first + k;
    const Quatf q = rotation_facing(cast<float>(-out));
    const float rotation[] = {q.w, q.x, q.y, q.z};
    std::copy_n(rotation, 4, layer.at(Attribute::Rotation, i));
    const double spacing = radius * std::sqrt(4 * std::numbers::pi / double(count));
    for (size_t c = 0; c < 3; ++c) {
      layer.at(Attribute::Mean, i)[c] = float(radius * out[c]);
      layer.at(Attribute::ShDc, i)[c] = sh_dc[c];
    }
    set(layer, Attribute::LogScale, i, spacing / 2);
    set(layer, Attribute::Opacity, i, kFaint);
  }
}

// Appends diffuse surfels on the visual hull to the layer. Returns the indices of their seed points.
std::vector<uint32_t> append_hull(const LayerInitDesc& desc, const SurfaceSeeds& hull, size_t limit, const Vec3f& sh_dc,
                                  SplatLayer& layer) {
  std::vector<uint32_t> all(hull.points.size());
  std::iota(all.begin(), all.end(), 0u);
  const std::vector<uint32_t> taken = drawn(all, limit, static_cast<uint64_t>(desc.config.seed), kHullStream);
  if (taken.empty()) return taken;
  const double spacing = hull.spacing * std::sqrt(double(all.size()) / double(taken.size()));
  const size_t first = layer.size();
  layer.resize(first + taken.size());
  for (size_t k = 0; k < taken.size(); ++k) {
    const SurfaceSeed& point = hull.points[taken[k]];
    const size_t i = first + k;
    const Quatf q = rotation_facing(point.normal);
    const float rotation[] = {q.w, q.x, q.y, q.z};
    std::copy_n(rotation, 4, layer.at(Attribute::Rotation, i));
    for (size_t c = 0; c < 3; ++c) {
      layer.at(Attribute::Mean, i)[c] = point.position[c];
      layer.at(Attribute::ShDc, i)[c] = sh_dc[c];
    }
    set(layer, Attribute::LogScale, i, kHullScale * spacing * double(point.apart));
    set(layer, Attribute::Opacity, i, kHullOpacity);
    for (Attribute a : {Attribute::F0, Attribute::Roughness, Attribute::SpecularWeight, Attribute::Transmission})
      set(layer, a, i, row(a).initial);
  }
  return taken;
}

void make_glass(const TransmittancePhase& phase, SplatLayer& layer, size_t i) {
  set(layer, Attribute::F0, i, phase.f0);
  set(layer, Attribute::SpecularWeight, i, phase.specular_weight);
  set(layer, Attribute::Transmission, i, phase.transmission);
}

// Creates the transmittance layer of thin glass: moves the surfels seen only through glass out of the diffuse layer, at most
// `cap` and at least one, so that the layer exists. The picture does not change.
void move_behind_glass(const MaskEvidence& seen, size_t cap, SplatScene& scene) {
  SplatLayer& diffuse = scene.diffuse;
  std::vector<uint32_t> by_share(diffuse.size());
  std::iota(by_share.begin(), by_share.end(), 0u);
  std::stable_sort(by_share.begin(), by_share.end(), [&](uint32_t a, uint32_t b) { return seen.share(a) > seen.share(b); });
  size_t count = 0;
  while (count < std::min(cap, by_share.size()) && (count == 0 || seen.share(by_share[count]) >= kBehindGlass)) ++count;
  std::vector<uint32_t> moved(by_share.begin(), by_share.begin() + static_cast<ptrdiff_t>(count));
  std::vector<uint32_t> stay(by_share.begin() + static_cast<ptrdiff_t>(count), by_share.end());
  for (auto* indices : {&moved, &stay}) std::sort(indices->begin(), indices->end());
  scene.transmittance.resize(count);
  for (size_t k = 0; k < count; ++k) copy_between(diffuse, moved[k], scene.transmittance, k, 1);
  keep_surfels(diffuse, stay);
}

// Pixel counts over all training photos; `mirror`: inside the specular and outside the transparent mask.
struct MirrorPixels {
  size_t mirror = 0, all = 0;
};
MirrorPixels mirror_pixels(const LayerInitDesc& desc) {
  MirrorPixels out;
  for (uint32_t photo : desc.capture.train) {
    const Intrinsics& k = desc.capture.photos[photo].levels[kEvidenceLevel].view.intrinsics;
    out.all += k.pixel_count();
    const auto& masks = desc.targets.photos[photo][kEvidenceLevel].masks;
    const auto &specular = masks[size_t(MaskClass::Specular)], &transparent = masks[size_t(MaskClass::Transparent)];
    for (size_t i = 0; i < specular.size(); ++i)
      out.mirror += specular[i] >= 128 && (transparent.empty() || transparent[i] < 128);
  }
  return out;
}

}  // namespace

HullCounts begin_reflection(const LayerInitDesc& start, size_t cap, size_t diffuse_cap, SplatScene& scene) {
  const ReflectionPhase& phase = start.config.phases.reflection;
  const auto seed = static_cast<uint64_t>(start.config.seed);
  SplatLayer& diffuse = scene.diffuse;
  const Survey found = survey(start, scene, {Surveyed::Specular, Surveyed::Transparent, Surveyed::Coat});
  const MaskEvidence &specular = found.evidence[0], &transparent = found.evidence[1], &coat = found.evidence[2];
  const FlatMirrors mirrors(start, specular, diffuse);
  const ShapeSet shapes = mirrors.registered();
  const LayerInitDesc desc{start.config, start.capture, start.targets, shapes, start.glass, start.sh_degree};
  const std::vector<uint8_t> reflected = mirrors.reflect_into_scene(shapes, diffuse);
  // Specular and transparent masks determine the mirrors; without masks any surfel may reflect.
  const bool marked = desc.targets.any(MaskClass::Specular), masked = marked || desc.targets.any(MaskClass::Transparent);
  SurfaceSeeds hull;
  if (marked && phase.hull_points > 0) hull = surface_seeds(desc.shapes.no_glass().without(ShapeRole::Coat));

  // Virtual images lie in and behind the mirror. Surfels farther away are room that a single photo shows next to the mirror.
  Bounds3 around;
  for (const SurfaceSeed& p : hull.points) around.extend(cast<double>(p.position));
  if (!around.empty())
    around = {around.low - kMirrorDepth * (around.high - around.low), around.high + kMirrorDepth * (around.high - around.low)};
  std::vector<uint32_t> dull, stay, gone;
  for (size_t i = 0; i < diffuse.size(); ++i) {
    const auto index = static_cast<uint32_t>(i);
    const float share = reflected[i] ? 0 : specular.share(i);
    const float* mean = diffuse.at(Attribute::Mean, i);
    const bool far_off = !around.empty() && !around.contains(Vec3f{mean[0], mean[1], mean[2]});
    const float mirror_share = !masked ? 1.f : far_off ? 0.f : std::max(share - transparent.share(i), 0.f);
    const float painted = masked ? coat.share(i) : 0.f;
    const auto mixed = [&](Attribute a, double outside, double inside, double under_coat) {
      set(diffuse, a, i, outside + mirror_share * (inside - outside) + painted * (under_coat - outside));
    };
    if (!is_glass(diffuse, i)) {  // glass placed earlier has its materials
      mixed(Attribute::SpecularWeight, kDull, phase.specular_weight, phase.coat_specular_weight);
      mixed(Attribute::F0, row(Attribute::F0).initial, phase.f0, phase.coat_f0);
    }
    if (!masked || share + painted < kMostlyInside) dull.push_back(index);
    (hull.points.empty() || mirror_share < kBehindGlass ? stay : gone).push_back(index);
  }
  const auto count = std::min(static_cast<size_t>(phase.initial_surfels), static_cast<size_t>(kInitialLayerShare * double(cap)));
  const auto far = static_cast<size_t>(kShellShare * double(count));
  append_copies(desc.capture, diffuse, dull, count - far, seed, scene.reflection);
  append_shell(far, mean_color(diffuse, dull), seed, scene.reflection);

  HullCounts counts;
  counts.shapes = desc.shapes.no_glass().without(ShapeRole::Mirror);  // coats keep their surfels
  if (hull.points.empty()) return counts;
  // Diffuse surfels there are virtual images, at their virtual depths.
  counts.moved = gone.size();
  const Vec3f color = mean_color(diffuse, gone.empty() ? dull : gone);
  keep_surfels(diffuse, stay);
  const size_t room = diffuse_cap > diffuse.size() ? diffuse_cap - diffuse.size() : 0, first = diffuse.size();
  const MirrorPixels pictured = mirror_pixels(desc);
  const bool determined = pictured.mirror >= kTellingPixels;
  const bool shaped = determined && std::ranges::any_of(hull.points, &SurfaceSeed::known);
  // Same number of surfels per pixel as in the rest of the scene.
  const auto fair =
      std::max(kFewestShapePoints,
               static_cast<size_t>(double(pictured.mirror) / double(std::max<size_t>(pictured.all, 1)) * double(diffuse_cap)));
  const size_t wanted =
      shaped ? std::min(static_cast<size_t>(phase.known_hull_points), fair) : static_cast<size_t>(phase.hull_points);
  const auto taken = append_hull(desc, hull, std::min(room, wanted), color, diffuse);
  counts.hull = taken.size();
  if (determined) {
    for (const SurfaceSeed& p : hull.points)
      if (p.known) counts.known_points.push_back(p.position);
    counts.known_reach = kKnownReach * hull.spacing;
    counts.shapes = desc.shapes.no_glass();
  }
  for (size_t k = 0; k < taken.size(); ++k) {
    const bool known = determined && hull.points[taken[k]].known;
    set(diffuse, Attribute::SpecularWeight, first + k, known ? phase.known_specular_weight : phase.specular_weight);
    set(diffuse, Attribute::F0, first + k, known ? phase.known_f0 : phase.f0);
  }
  return counts;
}

bool trains_sheets(const OptimizeConfig& config, const ShapeSet& shapes) {
  return config.shading.glass == Glass::Thin && config.shading.panes && shapes.has_glass();
}

ShapeSet known_sheets(const LayerInitDesc& desc, SplatScene& scene) {
  const Survey found = survey(desc, scene, {});
  ShapeSet sheets = desc.shapes.glass();
  for (ShapeSet::Entry& sheet : sheets.entries)
    sheet = with_clear_panes(std::move(sheet), desc.capture, desc.targets, found.depths, kEvidenceLevel);
  for (size_t i = 0; i < scene.diffuse.size(); ++i) set(scene.diffuse, Attribute::Transmission, i, kDull);
  return sheets;
}

HullCounts begin_transmittance(const LayerInitDesc& desc, size_t cap, size_t diffuse_cap, SplatScene& scene) {
  const TransmittancePhase& phase = desc.config.phases.transmittance;
  const auto seed = static_cast<uint64_t>(desc.config.seed);
  const Survey found = survey(desc, scene, {Surveyed::Transparent});
  const MaskEvidence& seen = found.evidence[0];
  const SurfaceSeeds hull = surface_seeds(desc.glass);
  const bool closed = !hull.points.empty() && phase.hull_points > 0;

  SplatLayer& diffuse = scene.diffuse;
  HullCounts counts;
  const auto place_glass = [&] {
    const size_t room = diffuse_cap > diffuse.size() ? diffuse_cap - diffuse.size() : 0, first = diffuse.size();
    counts.hull = append_hull(desc, hull, std::min(room, static_cast<size_t>(phase.hull_points)), kGlassColor, diffuse).size();
    for (size_t i = first; i < diffuse.size(); ++i) make_glass(phase, diffuse, i);
  };
  if (desc.config.shading.glass == Glass::Thin) {
    for (size_t i = 0; i < diffuse.size(); ++i) set(diffuse, Attribute::Transmission, i, kDull);
    // Without placed glass, content moved behind it would disappear from every picture.
    move_behind_glass(seen, closed ? std::min(static_cast<size_t>(phase.initial_surfels), cap) : 1, scene);
    counts.moved = scene.transmittance.size();
    if (closed) place_glass();
    if (closed) counts.shapes = desc.shapes.glass();
    for (ShapeSet::Entry& sheet : counts.shapes.entries)
      sheet = with_clear_panes(std::move(sheet), desc.capture, desc.targets, found.depths, kEvidenceLevel);
    return counts;
  }
  // All surfels: held-out views may see through the glass what no training photo shows.
  std::vector<uint32_t> through(diffuse.size()), stay;
  std::iota(through.begin(), through.end(), 0u);
  for (size_t i = 0; i < diffuse.size(); ++i) {
    const auto index = static_cast<uint32_t>(i);
    set(diffuse, Attribute::Transmission, i, kDull);
    if (!closed || seen.share(i) < kBehindGlass) stay.push_back(index);
    if (!closed && seen.share(i) > kMostlyInside) make_glass(phase, diffuse, i);
  }
  append_copies(desc.capture, diffuse, through, std::min(static_cast<size_t>(phase.initial_surfels), cap), seed,
                scene.transmittance);

  if (!closed) return counts;
  counts.moved = diffuse.size() - stay.size();
  keep_surfels(diffuse, stay);
  place_glass();
  return counts;
}

}  // namespace vitrine
