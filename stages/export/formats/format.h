// What an export format is: a name, what it can hold, what is lost on the way, and a writer. The list is formats/registry.cpp,
// one line per format; each format is one file beside it. The strings are the documentation (README, export/formats.json).
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/tri_mesh.h"
#include "core/scene/layers.h"

namespace vitrine {

// The artifacts to export from; files are read when a format first asks, and once.
class ExportSource {
 public:
  ExportSource(std::filesystem::path sfm, std::filesystem::path optimize, std::filesystem::path mesh)
      : sfm_(std::move(sfm)), optimize_(std::move(optimize)), mesh_folder_(std::move(mesh)) {}
  const std::filesystem::path& sfm() const { return sfm_; }
  const SplatLayer& diffuse();
  const TriMesh& mesh();

 private:
  std::filesystem::path sfm_, optimize_, mesh_folder_;
  std::optional<SplatLayer> diffuse_;
  std::optional<TriMesh> mesh_;
};

struct ExportFormat {
  std::string_view name;     // the word in --set formats=[...]
  std::string_view summary;  // one line
  std::string_view holds;    // what the files carry
  std::string_view loses;    // what the scene has and the files have not
  // Writes below `folder` and returns the paths written, relative to it.
  std::vector<std::string> (*write)(ExportSource& source, const std::filesystem::path& folder);
};

std::span<const ExportFormat> export_formats();
const ExportFormat* find_export_format(std::string_view name);

}  // namespace vitrine
