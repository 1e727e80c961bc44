// The file that describes a scan (README.md): geometry, angles, and where the pictures are.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/scene/image/image.h"
#include "stages/tomography/scan_geometry.h"

namespace vitrine {

// A level of the detector without object or without light: a picture, or one number, as a share of white.
struct DetectorLevel {
  std::filesystem::path file = {};
  double value = 0;
  std::string where = {};  // file:line:col
};

struct ScanFile {
  ScanGeometry geometry;                           // without the size of the projections
  std::vector<std::filesystem::path> projections;  // one for each angle
  // Pixels are line integrals times 1 / full_scale (`absorption`), or intensities between dark and flat.
  bool absorption = false;
  double full_scale = 1;
  DetectorLevel flat{.value = 1}, dark;
  std::string where;  // of the projections, for messages
};

// Throws Error{Usage} with every mistake at its line, Error{Input} for missing files and angles that do not fit them.
ScanFile read_scan(const std::filesystem::path& file);
// Every picture that the file names: their content enters the key. Mistakes are left to read_scan().
std::vector<std::filesystem::path> scan_pictures(const std::filesystem::path& file);

// Line integrals of all projections, one channel, in the order of the angles; sets width and height of the geometry. Throws
// Error{Input} for pictures of different sizes, or without information.
std::vector<ImageF> read_projections(ScanFile& scan);

}  // namespace vitrine
