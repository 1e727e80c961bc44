#include "core/camera/mask_origin.h"

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/json.h"
#include "core/base/json_cause.h"

namespace vitrine {

MaskOrigin mask_origin(const fs::path& artifact, MaskClass kind) {
  const fs::path path = artifact / "masks/report.json";
  if (!fs::exists(path)) return {};
  try {
    const auto report = nlohmann::json::parse(read_file(path));
    const auto& row = report.at("classes").at(std::string(name(kind)));
    return {row.value("guessed", false), row.value("propagated", false)};
  } catch (const nlohmann::json::exception& e) {
    throw Error(ErrorKind::Input, "the report of the masks is unusable",
                {.where = path.string(), .why = cause_of(e), .hint = "run the masks stage again", .code = "BAD_MASKS_REPORT"});
  }
}

}  // namespace vitrine
