// Interface of an export format: name, contents, losses and writer. The list is formats/registry.cpp, one line per format; each
// format has its own file in this folder. The strings are the documentation (README, export/formats.json, `vitrine export
// --list`).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stages/export/formats/source.h"

namespace vitrine {

struct ExportFormat {
  std::string_view name;     // name in --set formats=[...]
  std::string_view summary;  // one line
  std::string_view holds;    // contents of the files
  std::string_view loses;    // scene data missing in the files
  bool of_albedo = false;    // requires the decompose stage: without it skipped if all formats are written, else an error
  // Writes to `folder` and returns the written paths, relative to it.
  std::vector<std::string> (*write)(ExportSource& source, const std::filesystem::path& folder);
};

std::span<const ExportFormat> export_formats();
std::vector<std::string> export_format_names();
const ExportFormat* find_export_format(std::string_view name);

}  // namespace vitrine
