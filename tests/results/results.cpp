#include "tests/results/results.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "tests/results/optics_table.h"

namespace vitrine {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kBegin = "<!-- results: written by `vitrine-results table` -->\n";
constexpr std::string_view kEnd = "<!-- end of results -->\n";

// Those of eval/metrics.json that are kept.
constexpr const char* kFigures[] = {
    "heldout.psnr",
    "heldout.ssim",
    "heldout.flip",
    "heldout.views",
    "train.psnr",
    "regions.transparent.psnr",
    "regions.reflective.psnr",
    "regions.object.psnr",
    "regions.rest.psnr",
    "truth.pose.rotation_deg",
    "truth.pose.centre_rel",
    "truth.normal_mae_deg",
    "truth.regions.transparent.normal_mae_deg",
    "truth.depth_rel",
    "truth.transmitted.psnr",
    "truth.albedo.psnr",
    "truth.relit.psnr",
    "truth.mesh.fscore",
    "surfels",
};

[[noreturn]] void fail(const fs::path& file, const std::string& why) {
  throw Error(ErrorKind::Input, why,
              {.where = file.string(),
               .hint = "record it from the folder of a finished run: vitrine-results record",
               .code = "RESULT_INCOMPLETE"});
}

Json parsed(const fs::path& file) {
  Json json = Json::parse(read_file(file), nullptr, false);
  if (!json.is_object()) fail(file, "it is no JSON object");
  return json;
}

// The number at "a.b.c"; null where there is none. Six digits are more than any figure repeats to.
Json figure(const Json& metrics, std::string_view name) {
  const Json* at = &metrics;
  while (!name.empty()) {
    const size_t dot = std::min(name.find('.'), name.size());
    const std::string key(name.substr(0, dot));
    if (!at->is_object() || !at->contains(key)) return nullptr;
    at = &at->at(key);
    name.remove_prefix(std::min(dot + 1, name.size()));
  }
  if (at->is_number_integer()) return *at;
  return at->is_number() ? Json(std::stod(fmt::format("{:.6g}", at->get<double>()))) : Json(nullptr);
}

std::string without_place(const std::string& word) {
  if (const size_t at = word.find("sample_data/"); at != std::string::npos) return word.substr(at);
  return word.starts_with('/') ? fs::path(word).filename().string() : word;
}

std::string command_line(const Json& words) {
  std::string line;
  bool output = false;
  for (const Json& word : words) {
    const std::string text = word.get<std::string>();
    line += (line.empty() ? "" : " ") + (output ? "out" : without_place(text));
    output = text == "-o" || text == "--output";
  }
  return line;
}

double cpu_seconds(const Json& run) {
  double sum = 0;
  for (const Json& stage : run.at("stages")) sum += stage.value("cpu_seconds", 0.0);
  return sum;
}

std::string cell(const Json& result, const char* name, int digits, double factor = 1) {
  const Json& figures = result.at("figures");
  if (!figures.contains(name)) return "";
  return fmt::format("{:.{}f}", factor * figures.at(name).get<double>(), digits);
}

std::string row(const Json& r) {
  return fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.0f} min | `{}` |\n",
                     r.at("title").get<std::string>(), cell(r, "heldout.psnr", 1), cell(r, "heldout.ssim", 3),
                     cell(r, "regions.transparent.psnr", 1), cell(r, "regions.reflective.psnr", 1),
                     cell(r, "regions.rest.psnr", 1), cell(r, "truth.normal_mae_deg", 1), cell(r, "truth.mesh.fscore", 3),
                     cell(r, "truth.albedo.psnr", 1), cell(r, "truth.relit.psnr", 1),
                     std::ceil(r.at("cpu_seconds").get<double>() / 60), r.at("commit").get<std::string>().substr(0, 7));
}

constexpr const char* kEntries[] = {"title",   "scene", "preset",  "command",     "seeds",  "commit",
                                    "machine", "date",  "seconds", "cpu_seconds", "figures"};

Json result(const fs::path& file) {
  Json json = parsed(file);
  for (const char* entry : kEntries)
    if (!json.contains(entry)) fail(file, fmt::format("it has no entry '{}'", entry));
  return json;
}

}  // namespace

std::string recorded_run(const fs::path& folder, const RunLabel& label) {
  const Json run = parsed(folder / "run.json"), metrics = parsed(folder / "eval/metrics.json");
  if (run.value("exit", 1) != 0) fail(folder / "run.json", "the run did not end well");
  for (const Json& stage : run.at("stages"))
    if (stage.value("state", "") != "ran") fail(folder / "run.json", "a stage was taken from the store: its time is not known");
  const YAML::Node config = YAML::LoadFile((folder / "config.resolved.yaml").string());

  Json out;
  out["format"] = "vitrine-result 1";
  out["title"] = label.title;
  out["scene"] = without_place(config["input"]["photos"].as<std::string>());
  out["preset"] = config["preset"].as<std::string>();
  out["command"] = command_line(run.at("command"));
  out["seeds"] = {config["optimize"]["seed"].as<int>()};
  out["commit"] = label.commit;
  out["machine"] = {{"cpu", label.cpu}, {"cores", label.cores}, {"threads", run.at("machine").at("threads")}};
  out["date"] = run.at("finished").get<std::string>().substr(0, 10);
  out["seconds"] = std::round(run.at("seconds").get<double>());
  out["cpu_seconds"] = std::round(cpu_seconds(run));
  out["peak_memory_bytes"] = run.at("peak_rss_bytes");
  for (const char* name : kFigures)
    if (Json value = figure(metrics, name); !value.is_null()) out["figures"][name] = std::move(value);
  if (!out.contains("figures")) fail(folder / "eval/metrics.json", "it has no figure");
  return out.dump(1) + "\n";
}

std::string results_table(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& e : fs::directory_iterator(folder))
    if (e.path().extension() == ".json" && e.path().filename() != kOpticsFile) files.push_back(e.path());
  std::sort(files.begin(), files.end());
  std::string rows;
  std::set<std::string> machines;
  for (const fs::path& file : files) {
    const Json r = result(file);
    rows += row(r);
    machines.insert(
        fmt::format("{}, {} cores", r.at("machine").at("cpu").get<std::string>(), r.at("machine").at("cores").get<int>()));
  }
  return "| run | PSNR | SSIM | glass | specular | rest | normals | F-score | albedo | relit | CPU time | commit |\n"
         "|---|---|---|---|---|---|---|---|---|---|---|---|\n" +
         rows + (fs::exists(folder / kOpticsFile) ? fmt::format("\n{}", optics_table(folder / kOpticsFile)) : "") +
         fmt::format("\nMachines: {}.\n", fmt::join(machines, "; "));
}

std::string with_table(const std::string& page, const std::string& table) {
  const size_t begin = page.find(kBegin), end = page.find(kEnd);
  if (begin == std::string::npos || end == std::string::npos || end < begin)
    fail("README.md", "it has not both marks of the table");
  return page.substr(0, begin + kBegin.size()) + table + page.substr(end);
}

}  // namespace vitrine
