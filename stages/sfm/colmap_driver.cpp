#include "stages/sfm/colmap_driver.h"

#include <fmt/ranges.h>

#include <cctype>
#include <cstdlib>

#include "core/foundation/base/error.h"
#include "core/foundation/base/log.h"

namespace vitrine {

namespace {

constexpr std::string_view kInstallHint =
    "apt-get install --no-install-recommends colmap   (or set VITRINE_COLMAP to the program)";

// Option name of ours -> its COLMAP names, newest last. If COLMAP renames an option, add its new name here.
const std::map<std::string, std::vector<std::string>, std::less<>>& alternatives() {
  static const std::map<std::string, std::vector<std::string>, std::less<>> table{
      {"seed", {"--random_seed", "--default_random_seed"}},
      {"database", {"--database_path"}},
      {"images", {"--image_path"}},
      {"image_list", {"--image_list_path"}},
      {"input", {"--input_path"}},
      {"output", {"--output_path"}},
      {"clear_points", {"--clear_points"}},
      {"camera_model", {"--ImageReader.camera_model"}},
      {"camera_params", {"--ImageReader.camera_params"}},
      {"single_camera", {"--ImageReader.single_camera"}},
      {"extract_gpu", {"--SiftExtraction.use_gpu", "--FeatureExtraction.use_gpu"}},
      {"extract_threads", {"--SiftExtraction.num_threads", "--FeatureExtraction.num_threads"}},
      {"extract_max_size", {"--SiftExtraction.max_image_size", "--FeatureExtraction.max_image_size"}},
      {"max_features", {"--SiftExtraction.max_num_features"}},
      {"peak_threshold", {"--SiftExtraction.peak_threshold"}},
      {"match_list", {"--match_list_path"}},
      {"match_type", {"--match_type"}},
      {"match_gpu", {"--SiftMatching.use_gpu", "--FeatureMatching.use_gpu"}},
      {"match_threads", {"--SiftMatching.num_threads", "--FeatureMatching.num_threads"}},
      {"verify_inlier_ratio", {"--SiftMatching.min_inlier_ratio", "--TwoViewGeometry.min_inlier_ratio"}},
      {"verify_min_inliers", {"--SiftMatching.min_num_inliers", "--TwoViewGeometry.min_num_inliers"}},
      {"map_threads", {"--Mapper.num_threads"}},
      {"map_min_model_size", {"--Mapper.min_model_size"}},
      {"map_init_min_inliers", {"--Mapper.init_min_num_inliers"}},
      {"map_init_min_angle", {"--Mapper.init_min_tri_angle"}},
      {"map_pose_min_inliers", {"--Mapper.abs_pose_min_num_inliers"}},
      {"map_min_focal_ratio", {"--Mapper.min_focal_length_ratio"}},
      {"map_min_angle", {"--Mapper.filter_min_tri_angle"}},
      {"map_refine_focal", {"--Mapper.ba_refine_focal_length"}},
      {"map_refine_extra", {"--Mapper.ba_refine_extra_params"}},
      {"map_refine_principal", {"--Mapper.ba_refine_principal_point"}},
  };
  return table;
}

fs::path program_or_throw() {
  const char* named = std::getenv("VITRINE_COLMAP");
  const std::string name = named != nullptr && *named != 0 ? named : "colmap";
  if (const auto found = find_program(name)) return *found;
  throw Error(ErrorKind::Dependency, fmt::format("COLMAP is missing: no program '{}'", name),
              {.where = named != nullptr ? "VITRINE_COLMAP" : "PATH",
               .why = "camera poses come from COLMAP, which runs as a separate program",
               .hint = std::string(kInstallHint),
               .code = "COLMAP_MISSING"});
}

// The number after "COLMAP" in the first help lines: "COLMAP 3.8 -- Structure-from-Motion ..." -> "3.8".
std::string version_in(std::string_view line) {
  const size_t at = line.find("COLMAP ");
  if (at == std::string_view::npos) return {};
  std::string_view rest = line.substr(at + 7);
  size_t n = 0;
  while (n < rest.size() && (std::isalnum(static_cast<unsigned char>(rest[n])) || rest[n] == '.')) ++n;
  return n > 0 && std::isdigit(static_cast<unsigned char>(rest[0])) ? std::string(rest.substr(0, n)) : std::string();
}

// Option words of one help line: "  --SiftExtraction.use_gpu arg (=1)" -> "--SiftExtraction.use_gpu".
void collect_options(std::string_view line, std::set<std::string>& out) {
  for (size_t at = line.find("--"); at != std::string_view::npos; at = line.find("--", at + 2)) {
    size_t end = at + 2;
    while (end < line.size() && (std::isalnum(static_cast<unsigned char>(line[end])) || line[end] == '_' || line[end] == '.'))
      ++end;
    if (end > at + 2) out.emplace(line.substr(at, end - at));
  }
}

// COLMAP 3.8 links Qt even for its commands: never open a display. One BLAS thread keeps the order of summation fixed.
std::vector<std::pair<std::string, std::string>> child_environment() {
  return {{"QT_QPA_PLATFORM", "offscreen"}, {"OPENBLAS_NUM_THREADS", "1"}};
}

// COLMAP converts every '\\' of a path to '/'. Paths relative to its working folder contain only names of ours.
std::string from_there(const std::string& value, const fs::path& working_folder) {
  const std::string folder = working_folder.string() + "/";
  return !working_folder.empty() && value.size() > folder.size() && value.starts_with(folder) ? value.substr(folder.size())
                                                                                              : value;
}

}  // namespace

Colmap::Colmap() : Colmap(program_or_throw()) {}

Colmap::Colmap(fs::path program) : program_(std::move(program)) {
  const ProcessResult result = run_process(
      {.arguments = {program_.string(), "-h"}, .environment = child_environment(), .on_line = [&](std::string_view line) {
         if (version_.empty()) version_ = version_in(line);
       }});
  throw_if_interrupted();
  if (version_.empty())
    throw Error(ErrorKind::Dependency, fmt::format("'{}' does not answer like COLMAP", program_.string()),
                {.where = program_.string(),
                 .why = result.tail.empty() ? "'-h' prints nothing" : "'-h' prints: " + result.tail.substr(0, 300),
                 .hint = std::string(kInstallHint),
                 .code = "COLMAP_UNUSABLE"});
}

const std::set<std::string>& Colmap::options_of(const std::string& command) {
  const auto known = help_.find(command);
  if (known != help_.end()) return known->second;
  std::set<std::string> found;
  run_process({.arguments = {program_.string(), command, "-h"},
               .environment = child_environment(),
               .on_line = [&](std::string_view line) { collect_options(line, found); }});
  throw_if_interrupted();
  if (!found.contains("--help") || found.size() < 3)
    throw Error(ErrorKind::Dependency, fmt::format("COLMAP {} has no command '{}'", version_, command),
                {.where = program_.string(), .hint = std::string(kInstallHint), .code = "COLMAP_COMMAND_MISSING"});
  return help_.emplace(command, std::move(found)).first->second;
}

std::optional<std::string> Colmap::option(const std::string& command, const std::string& word) {
  const std::set<std::string>& shown = options_of(command);
  if (word.starts_with("--")) return shown.contains(word) ? std::optional(word) : std::nullopt;
  const auto row = alternatives().find(word);
  VITRINE_CHECK(row != alternatives().end(), "no COLMAP option is called '{}' here", word);
  for (const std::string& name : row->second)
    if (shown.contains(name)) return name;
  return std::nullopt;
}

std::vector<std::string> Colmap::arguments(const ColmapCommand& call) {
  options_of(call.command);  // a command that this version lacks is an error even without settings
  std::vector<std::string> out{program_.string(), call.command};
  for (const ColmapSetting& s : call.settings) {
    const std::optional<std::string> name = option(call.command, s.word);
    if (name) {
      out.push_back(*name);
      out.push_back(s.value);
    } else if (s.required) {
      const auto row = alternatives().find(s.word);
      std::string tried = s.word;
      if (row != alternatives().end()) tried = fmt::format("{}", fmt::join(row->second, " or "));
      throw Error(ErrorKind::Dependency, fmt::format("COLMAP {} does not offer {} for '{}'", version_, tried, call.command),
                  {.where = program_.string(),
                   .why = fmt::format("'colmap {} -h' lists none of these names", call.command),
                   .hint = "install a version between 3.8 and 4.1, or set VITRINE_COLMAP to one",
                   .code = "COLMAP_OPTION_MISSING"});
    }
  }
  return out;
}

ProcessResult Colmap::run(const ColmapCommand& call) {
  std::vector<std::string> words = arguments(call);
  for (size_t i = 1; i < words.size(); ++i) words[i] = from_there(words[i], call.working_folder);
  ProcessResult result = run_process({.arguments = std::move(words),
                                      .environment = child_environment(),
                                      .working_folder = call.working_folder,
                                      .log = call.log,
                                      .on_line = call.on_line});
  throw_if_interrupted();
  log_debug("colmap {}: exit {} signal {} in {:.1f} s, {} MiB", call.command, result.exit_code, result.signal, result.seconds,
            result.peak_memory_bytes >> 20);
  if (result.signal == SIGKILL)
    throw Error(ErrorKind::Resource, fmt::format("COLMAP '{}' was killed", call.command),
                {.where = call.log.string(),
                 .why = "SIGKILL: most often the machine ran out of memory",
                 .hint = "--set sfm.max_image_size=1200, or --threads 1",
                 .code = "COLMAP_KILLED"});
  return result;
}

std::string colmap_fingerprint() {
  try {
    return Colmap().version();
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Dependency) throw;
    return "none";  // poses may be given; a run that needs COLMAP reports the error itself
  }
}

}  // namespace vitrine
