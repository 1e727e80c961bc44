// The page of a volume, page.html: slices and a picture of the volume in a browser, in one file without network (README).
//
// The page holds at most kPageCells cells; a larger volume is averaged. Densities have kPageSteps steps from the lowest to the
// highest one, so that a decoded density differs from that of its cell by at most half a step.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "stages/stage.h"
#include "stages/tomography/scan_geometry.h"

namespace vitrine {

constexpr size_t kPageCells = size_t{256} * 256 * 256;
constexpr int kPageSteps = 4095;  // 12 bits

// Means over cubes of equal size, the smallest with which there are at most `most` cells; cubes at the far border are means of
// the part that the volume has. The same volume if it has no more cells.
VoxelGrid<float> averaged_volume(const VoxelGrid<float>& volume, size_t most);

struct PageVolume {
  VoxelGrid<uint16_t> steps;  // density = low + step (high - low) / kPageSteps
  float low = 0, high = 0;
};
PageVolume page_volume(const VoxelGrid<float>& volume);

// All low bytes, then all high bytes.
std::string packed_steps(const VoxelGrid<uint16_t>& steps);

struct VolumePageDesc {
  std::string unit = "mm";                // of lengths; densities are 1/unit
  double iso = 0;                         // density of the surface
  std::optional<SeenCylinder> seen = {};  // what the scan shows; all without it
  size_t most_cells = kPageCells;
};

// `page`: HTML without data (stages/page_text.h). Returns the size of the file, bytes.
size_t write_volume_page(const std::filesystem::path& path, const std::string& page, const VoxelGrid<float>& volume,
                         const VolumePageDesc& desc);
// The same with the page of this build; without one there is a warning, and no file.
void write_volume_page(const std::filesystem::path& path, const VoxelGrid<float>& volume, const VolumePageDesc& desc,
                       StageContext& context);

}  // namespace vitrine
