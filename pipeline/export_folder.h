// PROJECT/export has two writers: `vitrine run` links the files of its export stage, `vitrine export` adds formats or options on
// request. Requested files stay: a run does not touch a format while any file that `vitrine export` wrote for it exists.
// .cache/exported.json lists the requested files; export/formats.json lists all formats.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/artifact/manifest.h"
#include "core/foundation/base/file.h"

namespace vitrine {

inline constexpr std::string_view kExportStage = "export";

struct ExportDesc {
  fs::path project, target;
  bool overwrite = false;
};
// Links the files of an export artifact into `target`. Throws Error{Input} and changes nothing if other files would be replaced.
void put_export(const fs::path& entry, const Manifest& manifest, const ExportDesc& desc);

// Like publish(), for the export stage of a run. Returns the formats kept as `vitrine export` wrote them.
std::vector<std::string> publish_export(const fs::path& entry, const Manifest& manifest, const fs::path& project,
                                        const Manifest* before);

}  // namespace vitrine
