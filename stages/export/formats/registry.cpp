#include <algorithm>

#include "stages/export/formats/source.h"

// The export formats, one line each: <name>_format().
#define VITRINE_EXPORT_FORMATS(FORMAT) \
  FORMAT(ply_2dgs)                     \
  FORMAT(ply_3dgs)                     \
  FORMAT(ply_albedo)                   \
  FORMAT(colmap)                       \
  FORMAT(mesh_ply)                     \
  FORMAT(mesh_obj)                     \
  FORMAT(mesh_glb)                     \
  FORMAT(mesh_usd)                     \
  FORMAT(preview_3dgs)                 \
  FORMAT(gaussians_glb)                \
  FORMAT(gaussians_spz)                \
  FORMAT(environment)

namespace vitrine {

#define VITRINE_DECLARE(format) ExportFormat format##_format();
VITRINE_EXPORT_FORMATS(VITRINE_DECLARE)
#undef VITRINE_DECLARE

std::span<const ExportFormat> export_formats() {
#define VITRINE_CALL(format) format##_format(),
  static const ExportFormat formats[] = {VITRINE_EXPORT_FORMATS(VITRINE_CALL)};
#undef VITRINE_CALL
  return formats;
}

std::vector<std::string> export_format_names() {
  std::vector<std::string> names;
  for (const ExportFormat& f : export_formats()) names.emplace_back(f.name);
  return names;
}

const ExportFormat* find_export_format(std::string_view name) {
  const auto formats = export_formats();
  const auto it = std::find_if(formats.begin(), formats.end(), [&](const ExportFormat& f) { return f.name == name; });
  return it == formats.end() ? nullptr : &*it;
}

}  // namespace vitrine
