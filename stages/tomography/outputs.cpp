#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/math/quantile.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/mesh/tsdf_volume.h"
#include "stages/tomography/tomography.h"

namespace vitrine {

namespace {

constexpr double kBright = 0.999;  // quantile of the densities that is white in pictures

float bright(const VoxelGrid<float>& volume) {
  std::vector<float> values = volume.values;
  return std::max(quantile_of(values, kBright), 1e-30f);
}

// Layer `at` across axis 0, 1 or 2; the last remaining axis goes up.
ImageF slice(const VoxelGrid<float>& volume, int axis, int at) {
  const int right = axis == 0 ? 1 : 0, up = axis == 2 ? 1 : 2;
  const int w = volume.size[size_t(right)], h = volume.size[size_t(up)];
  ImageF out(w, h, 1);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      std::array<int, 3> cell{};
      cell[size_t(axis)] = at, cell[size_t(right)] = x, cell[size_t(up)] = h - 1 - y;
      out.at(x, y) = volume.at(cell[0], cell[1], cell[2]);
    }
  return out;
}

}  // namespace

double otsu_threshold(const VoxelGrid<float>& volume) {
  constexpr size_t kSteps = 256;
  const double top = double(bright(volume));
  std::array<double, kSteps> count{};
  for (const float v : volume.values) ++count[std::min(kSteps - 1, size_t(std::max(0., double(v) / top) * double(kSteps)))];
  double all = 0, sum = 0;
  for (size_t i = 0; i < kSteps; ++i) all += count[i], sum += count[i] * double(i);
  double below = 0, sum_below = 0, best = -1;
  size_t at = kSteps / 2;
  for (size_t i = 0; i + 1 < kSteps; ++i) {
    below += count[i], sum_below += count[i] * double(i);
    if (below <= 0 || below >= all) continue;
    const double difference = sum_below / below - (sum - sum_below) / (all - below);
    const double between = below * (all - below) * difference * difference;
    if (between > best) best = between, at = i;
  }
  return top * double(at + 1) / double(kSteps);
}

TriMesh density_surface(const VoxelGrid<float>& volume, double iso) {
  const Vec3d half = 0.5 * volume.cell * Vec3d{1, 1, 1};
  TsdfDesc desc{.bounds = {volume.origin - half, volume.high() + half}, .voxel = volume.cell};  // one empty layer around
  TsdfVolume field(desc);
  field.touch_all();
  field.allocate();
  const double scale = std::max(double(bright(volume)), iso);
  parallel_for(field.block_count(), 16, [&](size_t b) {
    const BlockCoord& c = field.coord(b);
    TsdfBlock& block = field.block(b);
    for (int i = 0; i < TsdfBlock::kVoxels; ++i) {
      constexpr int kSide = TsdfBlock::kSide;
      const int x = c.x * kSide + i % kSide - 1, y = c.y * kSide + i / kSide % kSide - 1, z = c.z * kSide + i / kSide / kSide - 1;
      block.distance[size_t(i)] = float(std::clamp((iso - double(volume.at(x, y, z))) / scale, -1., 1.));
      block.weight[size_t(i)] = 1;
    }
  });
  TriMesh mesh = iso_surface(field);
  mesh.colors.clear();
  return mesh;
}

void write_nrrd(const fs::path& path, const VoxelGrid<float>& volume, const std::string& unit) {
  static_assert(std::endian::native == std::endian::little);
  const Vec3d first = volume.centre(0, 0, 0);
  std::string bytes = fmt::format(
      "NRRD0004\n# density, 1/{4}\ntype: float\ndimension: 3\nspace dimension: 3\nsizes: {0} {1} {2}\n"
      "space directions: ({3},0,0) (0,{3},0) (0,0,{3})\nspace units: \"{4}\" \"{4}\" \"{4}\"\n"
      "space origin: ({5},{6},{7})\nkinds: domain domain domain\nendian: little\nencoding: raw\n\n",
      volume.size[0], volume.size[1], volume.size[2], volume.cell, unit, first.x, first.y, first.z);
  const size_t header = bytes.size();
  bytes.resize(header + volume.values.size() * sizeof(float));
  std::memcpy(bytes.data() + header, volume.values.data(), volume.values.size() * sizeof(float));
  write_file(path, bytes);
}

void write_slices(const fs::path& folder, const VoxelGrid<float>& volume, const std::string& unit) {
  make_folders(folder / "slices");
  parallel_for(size_t(volume.size[2]), 4, [&](size_t layer) {
    const int z = int(layer);
    write_exr(folder / "slices" / fmt::format("slice_{:04d}.exr", z),
              {slice(volume, 2, z),
               {"Y"},
               {{"vitrine:spacing", fmt::format("{} {}", volume.cell, unit)},
                {"vitrine:z", fmt::format("{} {}", volume.centre(0, 0, z).z, unit)},
                {"vitrine:density", "1/" + unit}}},
              ExrPrecision::Float);
  });
  const float white = bright(volume);
  for (int axis = 0; axis < 3; ++axis) {
    ImageF picture = slice(volume, axis, volume.size[size_t(axis)] / 2);
    for (float& v : picture.data()) v /= white;
    write_ldr(folder / fmt::format("middle_{}.png", "xyz"[axis]), bytes_of(picture));
  }
}

}  // namespace vitrine
