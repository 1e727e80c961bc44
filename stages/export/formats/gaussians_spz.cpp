// Export format gaussians-spz: the merged preview (preview-3dgs) as SPZ version 4 (github.com/nianticlabs/spz, README.md and
// src/cc/load-spz.cc). Little endian:
//   header  u32 "NGSP", u32 4, u32 surfels, u8 SH degree, u8 fraction bits, u8 flags, u8 streams, u32 offset of the table, 12
//   zeros table   {u64 bytes compressed, u64 bytes} for each stream, then the streams, each a Zstandard frame of all surfels:
//   position     3 x 24-bit signed fixed point       opacity  u8 of 0 to 1
//   f_dc         3 x u8 of 0.5 + 0.15 f_dc           scales   3 x u8 of 16 (ln s + 10)
//   rotation     u32: index of the largest of x y z w, then the others as sign and 9 bits of |q| / sqrt(1/2)
//   f_rest       u8 of 128 + 128 h, [k][rgb]; absent for degree 0
// Axes are those of glTF: x right, y up, z back. No antialiasing (flag 1), no extensions (flag 2).
#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include <zstd.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/math/rigid.h"
#include "core/scene/surfels/activation.h"
#include "stages/export/formats/gaussian_ply.h"
#include "stages/export/formats/source.h"

namespace vitrine {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they lie in memory");

constexpr int kMostFraction = 20;  // bits: steps of 1e-6 file units
constexpr int kZstdLevel = 12;     // that of the reference implementation
constexpr float kLargestLogScale = 255 / 16.f - 10;

uint8_t to_byte(float v) { return uint8_t(std::clamp(std::round(v), 0.f, 255.f)); }

template <class T>
void append(std::string& out, T v) {
  out.append(reinterpret_cast<const char*>(&v), sizeof v);
}

// The most bits after the point with which all positions fit into 24 bits.
int fraction_bits(const SplatLayer& layer) {
  float farthest = 0;
  for (const float v : layer.values(Attribute::Mean)) farthest = std::max(farthest, std::abs(v));
  for (int bits = kMostFraction; bits >= 0; --bits)
    if (std::ldexp(farthest, bits) < float((1 << 23) - 1)) return bits;
  throw Error(
      ErrorKind::Input, "the scene does not fit into an SPZ file",
      {.why = fmt::format("a surfel is {:.3g} file units from the origin; positions of 24 bits reach {}", farthest, 1 << 23),
       .hint = "give a smaller --scale, or leave out gaussians-spz",
       .code = kFormatRange});
}

// -q is the same rotation as q, so the largest component needs no sign.
uint32_t packed_rotation(const Quatf& q) {
  const float v[] = {q.x, q.y, q.z, q.w};
  uint32_t largest = 0;
  for (uint32_t i = 1; i < 4; ++i)
    if (std::abs(v[i]) > std::abs(v[largest])) largest = i;
  uint32_t out = largest;
  for (uint32_t i = 0; i < 4; ++i) {
    if (i == largest) continue;
    const uint32_t negative = (v[i] < 0) != (v[largest] < 0);
    const auto size = uint32_t(std::lround(511 * std::min(std::abs(v[i]) * std::numbers::sqrt2_v<float>, 1.f)));
    out = out << 10 | negative << 9 | size;
  }
  return out;
}

// 8 bits of which the lower ones are zero, so that they compress: 5 bits of degree 1, 4 bits of higher degrees.
uint8_t packed_sh(float h, size_t k) {
  const int step = k < 4 ? 8 : 16, value = to_byte(128 * h + 128);
  return uint8_t(std::min((value + step / 2) / step * step, 255));
}

std::array<std::string, 6> attribute_streams(const SplatLayer& layer, int bits, float thickness) {
  std::array<std::string, 6> streams;
  auto& [positions, opacities, colors, scales, rotations, rest] = streams;
  const size_t coefficients = layer.width(Attribute::ShRest);
  for (size_t i = 0; i < layer.size(); ++i) {
    for (size_t c = 0; c < 3; ++c) {
      const auto fixed = int32_t(std::lround(std::ldexp(layer.at(Attribute::Mean, i)[c], bits)));
      positions.append(reinterpret_cast<const char*>(&fixed), 3);
      append(colors, to_byte(255 * (0.5f + 0.15f * layer.at(Attribute::ShDc, i)[c])));
      append(scales, to_byte(16 * ((c < 2 ? layer.at(Attribute::LogScale, i)[c] : std::log(thickness)) + 10)));
    }
    append(opacities, to_byte(255 * sigmoid(*layer.at(Attribute::Opacity, i))));
    const float* q = layer.at(Attribute::Rotation, i);
    append(rotations, packed_rotation(normalized(Quatf{q[0], q[1], q[2], q[3]})));
    for (size_t k = 0; k < coefficients; ++k) append(rest, packed_sh(layer.at(Attribute::ShRest, i)[k], 1 + k / 3));
  }
  return streams;
}

std::string compressed(const std::string& bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  const size_t size = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), kZstdLevel);
  VITRINE_CHECK(!ZSTD_isError(size), "zstd: {}", ZSTD_getErrorName(size));
  out.resize(size);
  return out;
}

std::vector<std::string> write_gaussians_spz(ExportSource& source, const std::filesystem::path& folder) {
  const ExportFrame frame = source.frame(ExportAxes::Rhyu);
  const SplatLayer layer = in_frame(source.preview(), frame);
  const int bits = fraction_bits(layer);
  const auto streams = attribute_streams(layer, bits, disk_thickness(frame));
  const auto written = size_t(std::ranges::count_if(streams, [](const std::string& s) { return !s.empty(); }));
  std::string out = "NGSP", bodies;
  append<uint32_t>(out, 4);
  append(out, uint32_t(layer.size()));
  for (const size_t byte : {size_t(layer.sh_degree()), size_t(bits), size_t(0), written}) append(out, uint8_t(byte));
  append<uint32_t>(out, 32);
  out.resize(32, '\0');
  for (const std::string& stream : streams) {
    if (stream.empty()) continue;
    const std::string body = compressed(stream);
    append(out, uint64_t(body.size()));
    append(out, uint64_t(stream.size()));
    bodies += body;
  }
  const auto sizes = layer.values(Attribute::LogScale);
  if (const auto n = std::ranges::count_if(sizes, [](float s) { return s > kLargestLogScale; }); n > 0)
    source.add_note(
        fmt::format("{} axes of surfels are shortened to {:.0f} file units, the largest of SPZ", n, std::exp(kLargestLogScale)));
  const std::string file = "gaussians.spz";
  write_file(folder / file, out + bodies);
  return {file};
}

}  // namespace

ExportFormat gaussians_spz_format() {
  return {
      .name = "gaussians-spz",
      .summary = "the merged preview as SPZ version 4, +Y up: about a tenth of the size of preview-3dgs",
      .holds = "what preview-3dgs holds, with spherical harmonics of the trained degree, in 8 to 24 bits a number and compressed",
      .loses =
          "what preview-3dgs loses; precision: positions to a 24-bit step, colours and opacities to 1/255, scales to 6 %, "
          "view dependence to 4 or 5 bits; the third scale is 4.5e-5 file units",
      .write = write_gaussians_spz};
}

}  // namespace vitrine
