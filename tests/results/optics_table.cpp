#include "tests/results/optics_table.h"

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"

namespace vitrine {
namespace {

using OpticsJson = nlohmann::ordered_json;

struct OpticsColumn {
  const char* figure;
  const char* title;
  int digits;
};
constexpr OpticsColumn kOpticsColumns[] = {{"all", "PSNR", 1},
                                           {"glass_pooled", "glass", 1},
                                           {"mirror_pooled", "mirrors", 1},
                                           {"coated_pooled", "coats", 1},
                                           {"rest_pooled", "rest", 1},
                                           {"behind_glass", "behind glass", 1},
                                           {"relit", "relit", 1},
                                           {"normals_glass", "normals: glass", 0},
                                           {"normals_mirror", "mirrors", 0},
                                           {"normals_coated", "coats", 0}};

OpticsJson optics_document(const fs::path& file) {
  const auto refuse = [&](const std::string& why) {
    throw Error(ErrorKind::Input, why,
                {.where = file.string(), .hint = "write it with vitrine-optics --record", .code = "RESULT_INCOMPLETE"});
  };
  OpticsJson document = OpticsJson::parse(read_file(file), nullptr, false);
  if (!document.is_object() || document.value("format", "") != "vitrine-optics 1")
    refuse("it is no file of the format 'vitrine-optics 1'");
  for (const char* entry : {"commit", "machine", "seeds", "training_seeds", "settings", "scenes", "against", "gains"})
    if (!document.contains(entry)) refuse(fmt::format("it has no entry '{}'", entry));
  return document;
}

std::string optics_cell(const OpticsJson& figures, const OpticsColumn& column) {
  if (!figures.contains(column.figure)) return "";
  const OpticsJson& gain = figures.at(column.figure);
  const double mean = gain.at("mean");
  if (gain.at("scenes") < 2) return fmt::format("{:+.{}f}", mean, column.digits);
  return fmt::format("{:+.{}f} ± {:.{}f}", mean, column.digits, gain.at("deviation").get<double>(), column.digits);
}

}  // namespace

std::string optics_table(const fs::path& file) {
  const OpticsJson document = optics_document(file);
  std::string table = fmt::format("| minus `{}`, {} scenes x {} seeds, `{}` |", document.at("against").get<std::string>(),
                                  document.at("scenes").size(), document.at("training_seeds").size(),
                                  document.at("commit").get<std::string>().substr(0, 7));
  std::string rule = "|---|";
  for (const OpticsColumn& column : kOpticsColumns) table += fmt::format(" {} |", column.title), rule += "---|";
  table += "\n" + rule + "\n";
  for (const OpticsJson& arm : document.at("gains")) {
    table += fmt::format("| {} |", arm.at("arm").get<std::string>());
    for (const OpticsColumn& column : kOpticsColumns) table += fmt::format(" {} |", optics_cell(arm.at("figures"), column));
    table += "\n";
  }
  return table;
}

}  // namespace vitrine
