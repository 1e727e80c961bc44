// What an export format is: a name, what it can hold, what is lost on the way, and a writer. The list is formats/registry.cpp,
// one line per format; each format is one file beside it. The strings are the documentation (README, export/formats.json,
// `vitrine export --list`).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stages/export/formats/source.h"

namespace vitrine {

struct ExportFormat {
  std::string_view name;     // the word in --set formats=[...]
  std::string_view summary;  // one line
  std::string_view holds;    // what the files carry
  std::string_view loses;    // what the scene has and the files have not
  bool of_albedo = false;    // needs the decompose stage: without it left out where all formats are written, else an error
  // Writes below `folder` and returns the paths written, relative to it.
  std::vector<std::string> (*write)(ExportSource& source, const std::filesystem::path& folder);
};

std::span<const ExportFormat> export_formats();
std::vector<std::string> export_format_names();
const ExportFormat* find_export_format(std::string_view name);

}  // namespace vitrine
