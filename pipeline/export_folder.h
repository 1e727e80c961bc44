// PROJECT/export has two hands in it: `vitrine run` links the files of its export stage there, `vitrine export` adds what the
// user asks for with other options. What was asked for stays: a run leaves a format alone when `vitrine export` wrote one of its
// files, until those files are deleted. .cache/exported.json remembers them; export/formats.json tells of both.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/artifact/manifest.h"
#include "core/base/file.h"

namespace vitrine {

inline constexpr std::string_view kExportStage = "export";

struct ExportDesc {
  fs::path project, target;
  bool overwrite = false;
};
// Links the files of an artifact of the export stage into `target`. Throws Error{Input} and touches nothing when other files are
// in the way.
void put_export(const fs::path& entry, const Manifest& manifest, const ExportDesc& desc);

// As publish(), for the export stage of a run. Returns the formats that stay as `vitrine export` wrote them.
std::vector<std::string> publish_export(const fs::path& entry, const Manifest& manifest, const fs::path& project,
                                        const Manifest* before);

}  // namespace vitrine
