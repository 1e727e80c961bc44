// vitrine inspect PHOTOS|PROJECT: quality of a photo set before computing. The program vitrine-inspect analyses the photos (and
// the cameras, if there are poses); this command adds cost estimates per preset.
#include <algorithm>
#include <iostream>
#include <set>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/base/terminal.h"
#include "core/foundation/config/cli.h"
#include "core/foundation/config/text.h"
#include "pipeline/commands.h"
#include "pipeline/cost_model.h"
#include "pipeline/given_inputs.h"
#include "pipeline/graph.h"
#include "pipeline/measures_in_photos.h"
#include "pipeline/project.h"
#include "pipeline/tool.h"

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;

struct InspectArguments {
  std::string output, poses, masks, depth;
  std::vector<std::string> sets;
  int threads = 0, frames = 0;
  bool json = false, verbose = false, help = false;
};

struct Subject {
  fs::path photos;
  std::optional<fs::path> project = {};  // output folder of an earlier run
  std::string poses = {}, masks = {}, depth = {};  // of the run; "none": explicitly none
  std::string truth = {};                // input.truth of the project
  std::string frames = {};               // ingest.frames of the run; empty: the default

  bool has_depth() const { return !depth.empty() && depth != "none"; }
  bool has_masks() const { return !masks.empty() && masks != "none"; }
};

void require_given(const std::string& path, const char* name, const char* hint) {
  std::error_code ec;
  if (!path.empty() && path != "none" && !fs::exists(path, ec))
    throw Error(ErrorKind::Input, fmt::format("there are no such {}", name),
                {.where = path, .hint = hint, .code = "MISSING_INPUT"});
}

Subject subject_of(const std::string& word, const InspectArguments& a, const Graph& graph) {
  const fs::path what = fs::absolute(word).lexically_normal();
  const fs::path output = a.output.empty() ? fs::path() : fs::absolute(a.output).lexically_normal();
  Subject s{.photos = what, .poses = a.poses, .masks = a.masks, .depth = a.depth};
  require_given(a.masks, "masks", "give a folder of masks or a file of marks, as to vitrine run");
  require_given(a.depth, "depth maps", "give a folder of depth maps or a transforms.json, as to vitrine run");
  require_given(a.poses, "poses", "give a COLMAP model or a transforms.json, as to vitrine run");
  if (is_project(what))
    s.project = what;
  else if (!a.output.empty() && is_project(output))
    s.project = output;
  else if (const fs::path usual = default_project(what); is_project(usual))
    s.project = usual;
  Settings settings(graph);
  if (a.frames > 0) s.frames = std::to_string(a.frames);
  if (!s.project) {
    settings.load({.flags = {{"input.photos", what.string(), "PHOTOS"},
                             {"input.poses", a.poses, "--poses"},
                             {"input.masks", a.masks, "--masks"},
                             {"input.depth", a.depth, "--depth"}}});
    if (!a.output.empty()) check_inputs_apart(output, graph, settings);
    return s;
  }
  settings.load({.project = *s.project});
  check_measures(settings);
  if (*s.project == what) s.photos = settings.text("input.photos");
  s.truth = settings.text("input.truth");
  if (const Option* frames = settings.options.table.find("ingest.frames"); frames != nullptr && s.frames.empty())
    s.frames = frames->text();
  if (a.masks.empty()) s.masks = settings.text("input.masks");
  if (a.depth.empty() && settings.options.table.find("input.depth") != nullptr) s.depth = settings.text("input.depth");
  // Poses that a run has already accepted need no rehearsal.
  if (a.poses.empty() && !current_key(*s.project, "sfm")) s.poses = settings.text("input.poses");
  return s;
}

// Adds the rehearsal's warnings and errors to the findings.
void add_rehearsal(const Subject& subject, int threads, Json& report) {
  const std::vector<RunMessage> messages = rehearsed(
      {.photos = subject.photos, .poses = subject.poses, .masks = subject.has_masks() ? subject.masks : "", .threads = threads});
  std::vector<Json> findings = report["findings"];
  for (const RunMessage& s : messages) {
    if (std::ranges::any_of(findings, [&](const Json& f) { return f["code"] == s.code; })) continue;
    findings.push_back({{"code", s.code},
                        {"severity", s.error ? "problem" : "warning"},
                        {"what", s.what},
                        {"why", s.why.empty() ? "a run warns of it" : s.why},
                        {"try", s.hint},
                        {"photos", Json::array()}});
  }
  const auto rank = [](const Json& f) { return f["severity"] == "problem" ? 0 : f["severity"] == "warning" ? 1 : 2; };
  std::ranges::stable_sort(findings, {}, rank);
  report["verdict"] = findings.empty() || rank(findings[0]) == 2 ? "good" : rank(findings[0]) == 1 ? "usable" : "poor";
  report["findings"] = findings;
}

Json photos_report(const Subject& subject, const InspectArguments& a) {
  const TemporaryFolder folder("vitrine-inspect");
  const fs::path out = folder.path() / "report";
  Words run = {
      tool_program("inspect").string(), "--input", "photos=" + subject.photos.string(), "--output", out.string(), "--quiet"};
  if (subject.project)
    if (const auto key = current_key(*subject.project, "sfm"))
      run.insert(run.end(), {"--input", "sfm=" + (store_of(*subject.project) / "sfm" / *key).string()});
  if (subject.has_masks() && !is_yaml_file(subject.masks)) run.insert(run.end(), {"--input", "masks=" + subject.masks});
  if (subject.has_depth()) run.insert(run.end(), {"--input", "depth=" + subject.depth});
  if (!subject.frames.empty()) run.insert(run.end(), {"--set", "frames=" + subject.frames});
  for (const std::string& set : a.sets) run.insert(run.end(), {"--set", set});
  if (a.threads > 0) run.insert(run.end(), {"--threads", std::to_string(a.threads)});
  if (const int exit = run_and_tell(run); exit != 0) return {{"exit", exit}};
  Json report = Json::parse(read_file(out / "inspect" / "report.json"));
  add_rehearsal(subject, a.threads, report);
  return report;
}

CaptureSize capture_size(const Json& report, bool masks) {
  CaptureSize c{.photos = report["set"]["usable"],
                .photographed_mpx = report["set"]["pixels"].get<double>() * 1e-6,
                .texture = report["set"]["texture"],
                .masks = masks};
  std::vector<std::pair<double, double>> sides;
  for (const Json& p : report["photos"])
    if (p.contains("width")) sides.push_back(std::minmax(p["width"].get<double>(), p["height"].get<double>()));
  take_typical_size(std::move(sides), c);
  return c;
}

// --- text output: 80 columns -----------------------------------------------------------------------------------------------

constexpr size_t kColumns = 80, kIndent = 12;

// Prints "label      text"; further lines are indented to the text.
void print_row(std::string_view label, std::string_view text) {
  std::string head(label);
  for (const std::string& line : wrapped(text, kColumns - kIndent)) {
    fmt::print("{:<{}}{}\n", head, kIndent, line);
    head.clear();
  }
}

std::string some_names(const Json& photos, size_t shown) {
  std::string text;
  for (size_t i = 0; i < std::min(shown, photos.size()); ++i) text += (i ? "  " : "") + photos[i].get<std::string>();
  if (photos.size() > shown) text += fmt::format("  and {} more", photos.size() - shown);
  return text;
}

void print_photos(const Json& report) {
  const Json& set = report["set"];
  std::set<std::string> cameras;
  std::set<std::pair<int, int>> sizes;
  size_t focal = 0;
  for (const Json& p : report["photos"]) {
    if (!p.contains("width")) continue;
    cameras.insert(p["camera"].get<std::string>());
    sizes.insert({p["width"].get<int>(), p["height"].get<int>()});
    focal += !p["focal_px"].is_null();
  }
  const std::string size = sizes.size() == 1 ? fmt::format("{} x {}", sizes.begin()->first, sizes.begin()->second)
                                             : fmt::format("{} sizes", sizes.size());
  const std::string camera = cameras.size() > 1         ? fmt::format("{} cameras", cameras.size())
                             : cameras.begin()->empty() ? "camera not named"
                                                        : *cameras.begin();
  print_row("photos", fmt::format("{}  {}  {}  focal length known for {}", set["usable"].get<size_t>(), size, camera, focal));
  const Json& blur = set["blur_px_at_1600"];
  print_row("sharpness", fmt::format("{}; {:.0f} % of a picture holds something to recognise",
                                     blur.is_null() ? std::string("too few edges to measure it")
                                                    : fmt::format("edges smeared over {:.1f} px of 1600", blur.get<double>()),
                                     100 * set["texture"].get<double>()));
  print_row("exposure", fmt::format("{}, brightness ranges over {:.1f} EV; clipped {:.1f} %, black {:.1f} %",
                                    set["exposure_range_ev"].is_null()
                                        ? std::string("not in EXIF")
                                        : fmt::format("changes by {:.1f} EV", set["exposure_range_ev"].get<double>()),
                                    set["brightness_range_ev"].get<double>(), 100 * set["clipped_high"].get<double>(),
                                    100 * set["clipped_low"].get<double>()));
}

void print_findings(const Json& report) {
  constexpr size_t kNamed = 6;
  for (const Json& f : report["findings"]) {
    fmt::print("\n");
    print_row(f["severity"].get<std::string>(), f["what"].get<std::string>() + "  [" + f["code"].get<std::string>() + "]");
    print_row("  why", f["why"].get<std::string>());
    if (!f["photos"].empty()) print_row("  see", some_names(f["photos"], kNamed));
    if (!f["try"].get<std::string>().empty()) print_row("  try", f["try"].get<std::string>());
  }
}

void print_coverage(const Json& c) {
  fmt::print("\n");
  if (!c["inward"].get<bool>()) {
    print_row("cameras",
              fmt::format("{} with a pose; they do not look at one place: no ring to close", c["cameras"].get<size_t>()));
    return;
  }
  print_row("cameras",
            fmt::format("{} around one place, {:.0f} to {:.0f} degrees above it; {:.0f} % of the points are seen by two "
                        "photos only",
                        c["cameras"].get<size_t>(), c["lowest_deg"].get<double>(), c["highest_deg"].get<double>(),
                        100 * c["points_seen_by_two"].get<double>()));
  constexpr size_t kShown = 4;
  for (size_t i = 0; i < std::min(kShown, c["gaps"].size()); ++i) {
    const Json& g = c["gaps"][i];
    constexpr double kOneSided = 150;
    if (g["width_deg"].get<double>() > kOneSided) {
      print_row(
          "gap",
          fmt::format("seen from one side only: nothing from azimuth {:.0f} to {:.0f}, between {} and {}. If the back matters: "
                      "{} photos",
                      g["from_deg"].get<double>(), g["to_deg"].get<double>(), g["from"].get<std::string>(),
                      g["to"].get<std::string>(), g["photos_to_add"].get<size_t>()));
      continue;
    }
    print_row("gap", fmt::format("{:.0f} degrees at azimuth {:.0f}-{:.0f}, between {} and {}: add {} photos",
                                 g["width_deg"].get<double>(), g["from_deg"].get<double>(), g["to_deg"].get<double>(),
                                 g["from"].get<std::string>(), g["to"].get<std::string>(), g["photos_to_add"].get<size_t>()));
  }
  if (c["gaps"].empty()) print_row("", "no gap above 30 degrees all round");
  constexpr double kOneHeight = 15;
  if (c["highest_deg"].get<double>() - c["lowest_deg"].get<double>() < kOneHeight)
    print_row("gap", "all from one height: add a ring about 30 degrees higher");
}

std::string short_time(double s) {
  if (s < 99.5) return fmt::format("{:.0f} s", s);
  if (s < 99.5 * 60) return fmt::format("{:.0f} min", s / 60);
  return fmt::format("{:.1f} h", s / 3600);
}
std::string short_bytes(double bytes) {
  const double mib = bytes / (1024.0 * 1024.0);
  return mib < 999.5 ? fmt::format("{:.0f}M", mib) : fmt::format("{:.1f}G", mib / 1024);
}

void print_costs(const std::vector<PresetCost>& costs, int threads, bool masks) {
  fmt::print("\n{:<10}", "");
  for (const PresetCost& c : costs) fmt::print("  {:>21}", c.preset);
  fmt::print("\n{:<10}", "stage");
  for (size_t i = 0; i < costs.size(); ++i) fmt::print("  {:>7}{:>7}{:>7}", "time", "memory", "disk");
  for (size_t s = 0; s < costs.front().stages.size(); ++s) {
    fmt::print("\n{:<10}", costs.front().stages[s].first);
    for (const PresetCost& c : costs)
      if (const auto& stage = c.stages[s].second)
        fmt::print("  {:>7}{:>7}{:>7}", short_time(stage->seconds(threads)), short_bytes(double(stage->memory_bytes)),
                   short_bytes(double(stage->disk_bytes)));
      else
        fmt::print("  {:>7}{:>7}{:>7}", "?", "?", "?");
  }
  fmt::print("\n{:<10}", "all");
  for (const PresetCost& c : costs)
    fmt::print("  {:>7}{:>7}{:>7}", short_time(c.seconds), short_bytes(double(c.memory)), short_bytes(double(c.disk)));
  fmt::print("\n");
  if (const auto& unknown = costs.front().unknown; !unknown.empty())
    print_row("", fmt::format("? = no estimate, and not in the sum: {}", fmt::join(unknown, ", ")));
  print_row("", fmt::format(
                    "estimates for {} threads of a recent processor with AVX-512{}; poses that are hard to find take up to three "
                    "times as long",
                    threads, masks ? ", with layers" : ", without masks of yours"));
}

void print_each_photo(const Json& report) {
  fmt::print("\n{:<34}{:>8}{:>10}{:>9}{:>9}{:>9}\n", "photo", "blur px", "texture %", "clip %", "black %", "bright");
  for (const Json& p : report["photos"]) {
    const std::string name = cut_to_columns(p["name"].get<std::string>(), 33);
    if (p.contains("failure")) {
      fmt::print("{:<34}{}\n", name, cut_to_columns(p["failure"].get<std::string>(), kColumns - 34));
      continue;
    }
    const Json& blur = p["blur_px_at_1600"];
    fmt::print("{:<34}{:>8}{:>10.0f}{:>9.1f}{:>9.1f}{:>9.1f}\n", name,
               blur.is_null() ? std::string("-") : fmt::format("{:.1f}", blur.get<double>()), 100 * p["texture"].get<double>(),
               100 * p["clipped_high"].get<double>(), 100 * p["clipped_low"].get<double>(), p["brightness_ev"].get<double>());
  }
}

std::string verdict_text(const Json& report) {
  size_t problems = 0, warnings = 0;
  for (const Json& f : report["findings"]) {
    problems += f["severity"] == "problem";
    warnings += f["severity"] == "warning";
  }
  const auto count = [](size_t n, const char* what) { return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s"); };
  if (problems > 0) return "POOR: " + count(problems, "problem") + " will cost photos, or the whole reconstruction";
  if (warnings > 0) return "USABLE, with " + count(warnings, "warning");
  return "GOOD: no problem was found in these photos";
}

}  // namespace

int inspect_command(const Words& words) {
  InspectArguments a;
  CommandLine cli("vitrine inspect", "PHOTOS|PROJECT [options]",
                  "What the photos promise before anything is computed: blur, exposure, duplicates, texture, and what a run will "
                  "take. Of PROJECT, the output folder of `vitrine run`, also where its cameras leave gaps.");
  cli.value("output", 'o', "DIR", a.output, "Output folder of a run of these photos; default: the one `vitrine run` would take.");
  cli.value("poses", 0, "PATH", a.poses,
            "Poses that the run will be given: do they belong to these photos, and agree with them? Default: those of an earlier "
            "run that has no cameras yet.");
  cli.value("masks", 0, "PATH", a.masks,
            "Masks that the run will be given: would they be taken? Layers take longer. Default: those of an earlier run.");
  cli.value("depth", 0, "PATH", a.depth, "Depth maps that the run will be given. Default: those of an earlier run.");
  cli.value("frames", 0, "N", a.frames, 2, "Most frames of films that become photos; default: as in a run.");
  cli.values("set", 0, "OPTION=VALUE", a.sets, "An option of vitrine-inspect.");
  cli.value("threads", 'j', "N", a.threads, 0, "Threads, here and in the estimates; 0 = all.");
  cli.flag("json", 0, a.json, "One JSON record on stdout.");
  cli.flag("verbose", 'v', a.verbose, "A line for every photo.");
  cli.flag("help", 'h', a.help, "Print this text.");
  const Words rest = cli.parse(words);
  if (a.help) {
    std::cout << cli.help();
    return 0;
  }
  const std::string& given = only_argument(rest, "which photos?", "vitrine inspect PHOTOS");
  const Graph graph = load_graph(stage_folder());
  const Subject subject = subject_of(given, a, graph);
  if (subject.has_masks() && is_yaml_file(subject.masks)) check_marks(subject.masks, subject.photos);
  Json report = photos_report(subject, a);
  if (report.contains("exit")) return report["exit"];
  const int threads = a.threads > 0 ? a.threads : hardware_threads();
  const std::vector<PresetCost> costs =
      preset_costs(graph, {.photos = subject.photos, .truth = subject.truth}, capture_size(report, subject.has_masks()), threads);
  report["estimates"] = costs_json(costs, threads);
  if (a.json) {
    std::cout << report.dump() << "\n";
    return 0;
  }
  print_row("verdict", verdict_text(report));
  print_photos(report);
  print_findings(report);
  if (report.contains("coverage")) print_coverage(report["coverage"]);
  if (report.contains("passes")) print_row("passes", report["passes"].get<std::string>());
  if (a.verbose) print_each_photo(report);
  print_costs(costs, threads, subject.has_masks());
  if (!subject.has_masks())
    print_row("masks", "Glass, bare metal or a mirror? Without masks a run finds display cases at most. Draw them: " +
                           (gives_film_frames(given) ? "vitrine run FILM -o DIR --to ingest, then vitrine mark DIR"
                                                     : join_command({"vitrine", "mark", given})));
  return 0;
}

}  // namespace vitrine
