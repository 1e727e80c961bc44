#include "stages/view/page_surfels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/render/model/opened_scene.h"
#include "core/render/model/sheet_pass.h"
#include "core/scene/light/environment.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {

namespace {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kMostAlbedo = 8;               // behind glass: maximum radiance over received light; 1 in the page's format
constexpr float kLeastIrradiance = 1e-3f;      // relative to the unoccluded light
constexpr int kByteZero = 128, kByteOne = 63;  // signed values in bytes: codes of 0 and 1
constexpr int kTurnStep = 8;                   // of 65536; sufficient for normals, and the rounding compresses better
constexpr uint8_t kNoSide = 255;               // code for no normal; normals use 0 to 254
constexpr int kBouncedDegree = 1;              // light from the scene is smooth
constexpr float kTransferSteps = 48;           // coefficients are multiples of 1/48 of the constant one
constexpr int kSpanBits = 7, kScaleBits = 6, kTransferBits = 6;  // mantissa bits: relative error 0.4, 0.8 and 0.8 %
constexpr float kColorSteps = 1023;                              // quantisation of the square root of a colour

// Relative size of a surfel in the pictures.
float extent(const SplatLayer& layer, size_t i, std::span<const Vec3d> eyes) {
  const float *m = layer.at(Attribute::Mean, i), *s = layer.at(Attribute::LogScale, i);
  double nearest = 1e30;
  for (const Vec3d& eye : eyes) nearest = std::min(nearest, squared_length(Vec3d{m[0], m[1], m[2]} - eye));
  return sigmoid(*layer.at(Attribute::Opacity, i)) * std::exp(s[0] + s[1]) / static_cast<float>(std::max(nearest, 1e-6));
}

// Joins the layers with all SH coefficients up to the maximum degree; missing ones are 0.
SplatLayer joined(const SplatScene& scene, std::span<const uint32_t> solid, std::span<const uint32_t> glass) {
  const SplatLayer &diffuse = scene.diffuse, &mirrored = scene.reflection, &inside = scene.transmittance;
  SplatLayer out(LayerKind::Diffuse, std::max({diffuse.sh_degree(), inside.sh_degree(), mirrored.sh_degree()}),
                 solid.size() + inside.size() + glass.size() + mirrored.size());
  const auto copy = [&](const SplatLayer& from, size_t i, size_t to) {
    for (const AttributeRow& r : kAttributes) {
      std::copy_n(from.at(r.id, i), from.width(r.id), out.at(r.id, to));
      if (from.width(r.id) == 0 && r.id != Attribute::ShRest) {
        // The transmittance layer has no such attribute: diffuse and opaque (core/render/model/opened_scene.h).
        const bool none = r.id == Attribute::SpecularWeight || r.id == Attribute::Transmission;
        std::fill_n(out.at(r.id, to), out.width(r.id), raw_value(r.activation, none ? 1e-4f : r.initial));
      }
    }
  };
  size_t to = 0;
  for (const uint32_t i : solid) copy(diffuse, i, to++);
  for (size_t i = 0; i < inside.size(); ++i) copy(inside, i, to++);
  for (const uint32_t i : glass) copy(diffuse, i, to++);
  for (size_t i = 0; i < mirrored.size(); ++i) copy(mirrored, i, to++);
  return out;
}

// Quantises signed values to bytes 128 + 63 v / scale; scale is the largest magnitude of the item (`per_item` values).
void add_scaled(std::string_view name, std::span<const float> values, size_t per_item, PageBlocks& blocks) {
  const size_t items = per_item == 0 ? 0 : values.size() / per_item;
  std::vector<uint8_t> bytes(values.size());
  std::vector<float> scales(items);
  for (size_t i = 0; i < items; ++i) {
    const auto item = values.subspan(i * per_item, per_item);
    float most = 0;
    for (const float v : item) most = std::max(most, std::abs(v));
    scales[i] = rounded_half(most * 1.01f, kScaleBits);  // not below `most`
    for (size_t k = 0; k < per_item; ++k)
      bytes[i * per_item + k] = static_cast<uint8_t>(kByteZero + (most > 0 ? std::lround(kByteOne * item[k] / scales[i]) : 0));
  }
  blocks.bytes(name, bytes, static_cast<int>(per_item));
  blocks.halves(std::string(name) + "_scale", scales, 1, kScaleBits);
}

// Quantises [0, 1] with a square root, which resolves small values.
uint8_t root_byte(float value) { return static_cast<uint8_t>(std::lround(255 * std::sqrt(std::clamp(value, 0.f, 1.f)))); }

// Contracts a coordinate to 16 bits: the resolution decreases with the squared distance from the cameras.
uint16_t contracted(float x) {
  return static_cast<uint16_t>(std::lround(32767.5 + 32767.5 * double(x) / (1 + std::abs(double(x)))));
}
uint64_t spread_bits(uint64_t x) {  // inserts two zeros between bits
  uint64_t out = 0;
  for (int bit = 0; bit < 16; ++bit) out |= (x >> bit & 1) << (3 * bit);
  return out;
}
// Morton code: neighbours in space are neighbours in the file, which compresses better.
uint64_t curve_place(const float* mean) {
  return spread_bits(contracted(mean[0])) | spread_bits(contracted(mean[1])) << 1 | spread_bits(contracted(mean[2])) << 2;
}

// x, y, z of the unit quaternion with w >= 0.
std::vector<uint16_t> turns(const SplatLayer& layer) {
  std::vector<uint16_t> out;
  for (size_t i = 0; i < layer.size(); ++i) {
    const float* q = layer.at(Attribute::Rotation, i);
    const Quatf unit = normalized(Quatf{q[0], q[1], q[2], q[3]});
    const float sign = unit.w < 0 ? -1.f : 1.f;
    for (const float v : {unit.x, unit.y, unit.z})
      out.push_back(static_cast<uint16_t>(kTurnStep * std::lround((32768 + 32760 * sign * v) / kTurnStep)));
  }
  return out;
}

// Quantises the constant colour 0.5 + Y_0 h_0 as signed square roots: green, red minus green, blue minus green.
std::vector<uint16_t> constants(const SplatLayer& layer) {
  std::vector<uint16_t> out;
  const auto root = [&](float dc) {
    const float color = 0.5f + kShDc * dc;
    return static_cast<int>(std::lround(std::copysign(kColorSteps * std::sqrt(std::abs(color)), color)));
  };
  for (size_t i = 0; i < layer.size(); ++i) {
    const float* dc = layer.at(Attribute::ShDc, i);
    const int green = root(dc[1]);
    for (const int v : {green, root(dc[0]) - green, root(dc[2]) - green}) out.push_back(static_cast<uint16_t>(v));
  }
  return out;
}

PageSurfels chosen(const PageSurfels& from, std::span<const uint32_t> which) {
  PageSurfels out;
  out.layer = SplatLayer(from.layer.kind(), from.layer.sh_degree(), which.size());
  for (size_t to = 0; to < which.size(); ++to) {
    const uint32_t k = which[to];
    for (const AttributeRow& r : kAttributes) std::copy_n(from.layer.at(r.id, k), from.layer.width(r.id), out.layer.at(r.id, to));
    out.of_diffuse.push_back(from.of_diffuse[k]);
    out.of_inside.push_back(from.of_inside[k]);
    out.flags.push_back(from.flags[k]);
    out.solid += k < from.solid;
    out.drawn += k < from.drawn;
  }
  out.left_out = from.layer.size() - which.size();  // the reflection layer is kept completely
  return out;
}

}  // namespace

PageSurfels page_surfels(const TrainedScene& scene, std::span<const Vec3d> eyes, size_t most) {
  const SplatLayer &diffuse = scene.surfels.diffuse, &inside = scene.surfels.transmittance;
  const bool sheets = draws_sheets(scene.image), opened = sheets || inside.size() > 0;
  std::vector<uint32_t> solid, glass;
  for (uint32_t i = 0; i < diffuse.size(); ++i) {
    if (!opened || !is_glass(diffuse, i))
      solid.push_back(i);
    else if (!sheets)
      glass.push_back(i);
  }
  PageSurfels out;
  out.layer = joined(scene.surfels, solid, glass);
  out.solid = solid.size() + inside.size();
  out.drawn = out.solid + glass.size();
  out.of_diffuse.assign(out.layer.size(), UINT32_MAX);
  out.of_inside.assign(out.layer.size(), UINT32_MAX);
  std::iota(out.of_inside.begin() + static_cast<std::ptrdiff_t>(solid.size()),
            out.of_inside.begin() + static_cast<std::ptrdiff_t>(out.solid), 0u);
  out.flags.assign(out.layer.size(), 0);
  std::ranges::copy(solid, out.of_diffuse.begin());
  std::ranges::copy(glass, out.of_diffuse.begin() + static_cast<std::ptrdiff_t>(out.solid));
  for (size_t k = 0; k < out.layer.size(); ++k) {
    if (k >= solid.size() && k < out.solid) out.flags[k] |= kInsideSurfel;
    if (out.of_diffuse[k] != UINT32_MAX && out.of_diffuse[k] >= scene.image.panes.mirrored) out.flags[k] |= kGuessedSurfel;
  }
  std::vector<uint32_t> order(out.drawn);
  std::iota(order.begin(), order.end(), 0u);
  if (order.size() > most) {
    std::vector<float> extents(order.size());
    for (const uint32_t k : order) extents[k] = extent(out.layer, k, eyes);
    std::ranges::stable_sort(order, std::greater<>(), [&](uint32_t k) { return extents[k]; });
    order.resize(most);
  }
  for (size_t k = out.drawn; k < out.layer.size(); ++k) order.push_back(static_cast<uint32_t>(k));
  struct Rank {
    int kind;
    uint64_t place;
    auto operator<=>(const Rank&) const = default;
  };
  std::vector<Rank> rank(out.layer.size());
  for (const uint32_t k : order)
    rank[k] = {k < out.solid ? 0 : k < out.drawn ? 1 : 2, curve_place(out.layer.at(Attribute::Mean, k))};
  std::ranges::sort(order, {}, [&](uint32_t k) { return std::pair(rank[k], k); });
  return chosen(out, order);
}

std::vector<uint16_t> page_places(const SplatLayer& layer, std::span<const uint32_t> which) {
  std::vector<uint16_t> out;
  std::array<uint16_t, 3> before{};
  for (const uint32_t i : which)
    for (size_t c = 0; c < 3; ++c) {
      const uint16_t at = contracted(layer.at(Attribute::Mean, i)[c]);
      out.push_back(static_cast<uint16_t>(at - before[c]));
      before[c] = at;
    }
  return out;
}

void sort_along_curve(const SplatLayer& layer, std::vector<uint32_t>& which) {
  std::ranges::sort(which, {}, [&](uint32_t i) { return std::pair(curve_place(layer.at(Attribute::Mean, i)), i); });
}

void mark_sky(const DecomposedMaterials& materials, PageSurfels& surfels) {
  for (size_t k = 0; k < surfels.drawn; ++k)
    if (const uint32_t i = surfels.of_diffuse[k]; i != UINT32_MAX && materials.shows_sky(i)) surfels.flags[k] |= kSkySurfel;
}

PageLight page_light(const RelitScene& scene, const LightTransfer& transfer, const PageSurfels& surfels) {
  const size_t n = surfels.layer.size();
  SplatLayer drawn = surfels.layer;
  drawn.resize(surfels.drawn);
  PageLight out{.albedo = std::vector<Vec3f>(n),
                .f0 = std::vector<Vec3f>(n),
                .roughness = std::vector<float>(n, 1.f),
                .specular = std::vector<float>(n, 0.f),
                .transmission = std::vector<float>(n, 0.f),
                .received = transfer.of_surfels(drawn)};
  out.received.resize(n);
  const LightHarmonics captured = light_harmonics(scene.captured);
  const CellLight cells = cell_light(scene.captured);
  const Vec3f open = scene.captured.mean();
  const float least = kLeastIrradiance * kPi * (open.x + open.y + open.z) / 3 + 1e-12f;
  for (size_t k = 0; k < surfels.drawn; ++k) {
    const uint32_t i = surfels.of_diffuse[k];
    if (i != UINT32_MAX) {
      const RelitMaterial m = scene.material(i);
      out.albedo[k] = m.albedo, out.f0[k] = m.f0;
      out.roughness[k] = m.roughness, out.specular[k] = m.specular, out.transmission[k] = m.transmission;
      continue;
    }
    // Baked radiance relative to the light of the photos (core/render/relight/README.md 5); the page scales it with the light.
    const Vec3f before = irradiance(out.received[k], cells, captured);
    const float* dc = surfels.layer.at(Attribute::ShDc, k);
    for (size_t c = 0; c < 3; ++c)
      out.albedo[k][c] = std::clamp(kPi * std::max(0.5f + kShDc * dc[c], 0.f) / (before[c] + least), 0.f, kMostAlbedo);
  }
  return out;
}

void add_transfers(std::string_view name, std::span<const Transfer> transfers, int degree, PageBlocks& blocks) {
  const size_t size = sh_coefficient_count(degree);
  std::vector<float> constant;
  std::vector<uint8_t> shape;
  for (const Transfer& t : transfers) {
    const float grey = t[0].x + t[0].y + t[0].z;
    constant.insert(constant.end(), {t[0].x, t[0].y, t[0].z});
    for (size_t k = 1; k < size; ++k) {
      const float share = grey > 0 ? (t[k].x + t[k].y + t[k].z) / grey : 0.f;
      shape.push_back(static_cast<uint8_t>(std::clamp<long>(kByteZero + std::lround(kTransferSteps * share), 0, 255)));
    }
  }
  blocks.halves(std::string(name) + "_constant", constant, 3, kTransferBits);
  blocks.bytes(name, shape, static_cast<int>(size) - 1);
}

void add_surfels(const PageSurfels& surfels, const std::optional<PageLight>& light, PageBlocks& blocks) {
  const SplatLayer& layer = surfels.layer;
  std::vector<float> spans;
  std::vector<uint8_t> opacity, material;
  for (size_t i = 0; i < layer.size(); ++i) {
    for (size_t c = 0; c < 2; ++c) spans.push_back(std::exp(layer.at(Attribute::LogScale, i)[c]));
    opacity.push_back(static_cast<uint8_t>(std::lround(255 * sigmoid(*layer.at(Attribute::Opacity, i)))));
    for (size_t c = 0; c < 3; ++c) material.push_back(root_byte(sigmoid(layer.at(Attribute::F0, i)[c])));
    for (const Attribute a : {Attribute::Roughness, Attribute::SpecularWeight, Attribute::Transmission})
      material.push_back(root_byte(sigmoid(*layer.at(a, i))));
  }
  std::vector<uint32_t> all(layer.size());
  std::iota(all.begin(), all.end(), 0u);
  blocks.words("place", page_places(layer, all), 3);
  blocks.words("turn", turns(layer), 3);
  blocks.halves("span", spans, 2, kSpanBits);
  blocks.bytes("opacity", opacity, 1);
  blocks.words("constant", constants(layer), 3);
  add_scaled("sh", layer.values(Attribute::ShRest), layer.width(Attribute::ShRest), blocks);
  blocks.bytes("material", material, 6);
  blocks.bytes("flags", surfels.flags, 1);
  if (!light) return;
  std::vector<uint8_t> albedo, lit;
  for (size_t i = 0; i < layer.size(); ++i) {
    for (size_t c = 0; c < 3; ++c)
      albedo.push_back(root_byte(light->albedo[i][c] / ((surfels.flags[i] & kInsideSurfel) != 0 ? kMostAlbedo : 1)));
    for (const float v :
         {light->f0[i].x, light->f0[i].y, light->f0[i].z, light->roughness[i], light->specular[i], light->transmission[i]})
      lit.push_back(root_byte(v));
  }
  blocks.bytes("albedo", albedo, 3);
  blocks.bytes("lit_material", lit, 6);
  std::vector<uint32_t> open;
  std::vector<uint8_t> side;
  std::vector<Transfer> bounced;
  for (const ReceivedLight& r : light->received) {
    open.insert(open.end(), r.open.begin(), r.open.end());
    bounced.push_back(r.bounced);
    const bool none = squared_length(r.normal) == 0;
    const Vec2f place = none ? Vec2f{} : octahedral_place(r.normal);
    for (const float v : {place.x, place.y}) side.push_back(none ? kNoSide : static_cast<uint8_t>(std::lround(127 + 127 * v)));
  }
  blocks.indices("open", open, int(kCells / 32));
  blocks.bytes("side", side, 2);
  add_transfers("bounced", bounced, kBouncedDegree, blocks);
}

std::vector<PhotoCoverage> page_coverage(const PageSurfels& surfels, std::span<const View> photos, float near_z) {
  SplatLayer drawn = surfels.layer;
  drawn.resize(surfels.drawn);
  return photo_coverage(drawn, surfels.solid, photos, near_z);
}

uint8_t coverage_byte(const PhotoCoverage& coverage) {
  constexpr int kMostPhotos = 12;    // counts above this are clamped
  constexpr double kAngleStep = 10;  // degrees
  constexpr int kMostAngleSteps = 6;
  const int steps = std::min(static_cast<int>(coverage.widest_deg / kAngleStep), kMostAngleSteps);
  return static_cast<uint8_t>(8 * std::min(coverage.photos, kMostPhotos) + steps);
}

void add_coverage(std::span<const PhotoCoverage> coverage, PageBlocks& blocks) {
  std::vector<uint8_t> bytes(coverage.size());
  std::ranges::transform(coverage, bytes.begin(), coverage_byte);
  blocks.bytes("seen", bytes, 1);
}

}  // namespace vitrine
