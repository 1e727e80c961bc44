#include <algorithm>
#include <map>

#include "core/foundation/base/error.h"
#include "core/foundation/base/folder_files.h"
#include "core/foundation/base/process.h"
#include "core/intake/photos/photo_files.h"
#include "core/scene/image/probe.h"
#include "pipeline/cost_model.h"
#include "pipeline/farm/tasks.h"
#include "pipeline/graph.h"
#include "pipeline/settings.h"

namespace vitrine {

namespace {

constexpr size_t kFilmPhotos = 120;  // of films, without --frames
constexpr size_t kProbed = 8;        // photos whose size is read
constexpr size_t kHeaderBytes = 1 << 16;

bool is_folder(const fs::path& path) {
  std::error_code ec;
  return fs::is_directory(path, ec);
}

// What lies next to a folder `photos` is given to the run.
Words options_beside(const fs::path& capture) {
  std::error_code ec;
  if (fs::exists(capture / "marks.yaml", ec)) return {"--masks", (capture / "marks.yaml").string()};
  if (is_folder(capture / "masks")) return {"--masks", (capture / "masks").string()};
  return {};
}

// `film_photos`: how many frames of films become photos.
CaptureSize size_of(const PhotoFolder& folder, size_t film_photos) {
  CaptureSize c{.texture = kUsualTexture};
  std::vector<std::pair<double, double>> sides;
  const size_t n = folder.photos.size();
  for (size_t k = 0; k < std::min(n, kProbed); ++k) {
    const Probe p = probe_photo(read_file(folder.photos[k * n / std::min(n, kProbed)].path).substr(0, kHeaderBytes));
    if (p.width > 0 && p.height > 0) sides.push_back(std::minmax(double(p.width), double(p.height)));
  }
  if (sides.empty()) sides.emplace_back(1080, 1920);  // films, formats without a readable header
  double mpx = 0;
  for (const auto& [shorter, longer] : sides) mpx += shorter * longer * 1e-6 / double(sides.size());
  c.photos = std::max(n, folder.films.empty() ? size_t(1) : film_photos);
  c.photographed_mpx = mpx * double(c.photos);
  take_typical_size(std::move(sides), c);
  return c;
}

// Sets cores, memory and hours by the estimates of the stages.
void estimate(const Graph& graph, const PhotoFolder& folder, FarmTask& task) {
  Settings settings(graph);
  SettingsDesc desc{.flags = {{"input.photos", task.photos.string(), "PHOTOS"}}};
  size_t film_photos = kFilmPhotos;
  for (size_t i = 0; i + 1 < task.options.size(); ++i) {
    if (task.options[i] == "--preset") desc.flags.push_back({"preset", task.options[i + 1], "--preset"});
    if (task.options[i] == "--masks") desc.flags.push_back({"input.masks", task.options[i + 1], "--masks"});
    if (task.options[i] == "--frames") film_photos = std::strtoul(task.options[i + 1].c_str(), nullptr, 10);
    if (task.options[i] == "--set") desc.sets.push_back(task.options[i + 1]);
    if (task.options[i] == "-c" || task.options[i] == "--config") desc.configs.push_back(task.options[i + 1]);
  }
  settings.load(desc);
  CaptureSize capture = size_of(folder, film_photos);
  capture.masks = gives_masks(settings);
  const CostTerms terms = cost_terms(settings, capture, task.cores);
  double seconds = 0;
  for (const StageNode& node : graph.nodes) {
    const CostAnswer answer = stage_costs(node, {terms});
    if (answer.costs.empty()) continue;
    seconds += answer.costs[0].seconds(task.cores);
    task.memory_bytes = std::max(task.memory_bytes, size_t(kUsualCostError * double(answer.costs[0].memory_bytes)));
  }
  task.memory_bytes = std::max(task.memory_bytes, kLeastTaskMemory);
  task.hours = kUsualCostError * seconds / 3600;
}

// All tasks have the same options: `vitrine run` checks them once.
void check_options(const FarmTask& task) {
  Words words = run_words(task);
  words.push_back("--dry-run");
  const ProcessResult result = run_process({.arguments = words});
  if (result.ok()) return;
  throw Error(ErrorKind::Usage, "vitrine run refuses a task",
              {.where = join_command(words), .why = result.tail, .hint = "vitrine run --help", .code = "BAD_TASK"});
}

}  // namespace

FarmPlan plan_farm(const FarmPlanDesc& desc) {
  const Graph graph = load_graph(stage_folder());
  FarmPlan plan;
  std::map<std::string, fs::path> named;
  for (const fs::path& root : desc.captures) {
    if (!is_folder(root))
      throw Error(
          ErrorKind::Input, "there is no such folder of captures",
          {.where = root.string(), .hint = "give a folder that has one folder of photos an object", .code = "MISSING_INPUT"});
    std::vector<fs::path> folders;
    for (const auto& entry : fs::directory_iterator(root))
      if (entry.is_directory() && !entry.path().filename().string().starts_with('.')) folders.push_back(entry.path());
    std::ranges::sort(folders);
    for (const fs::path& folder : folders) {
      if (lies_in(folder, desc.results)) continue;  // an earlier plan
      if (lies_in(desc.results, folder))
        throw Error(ErrorKind::Usage, "the folder of results lies inside a capture",
                    {.where = desc.results.string(), .hint = "choose another one with -o", .code = "USAGE"});
      const bool inner = is_folder(folder / "photos");
      FarmTask task{.capture = folder.filename().string(), .photos = inner ? folder / "photos" : folder, .cores = desc.cores};
      PhotoFolder photos;
      try {
        photos = find_photos(task.photos, FilmsAre::Photos);
      } catch (const Error& e) {
        plan.notes.push_back(fmt::format("{} is left out: {}", task.capture, e.message()));
        continue;
      }
      if (const auto [other, fresh] = named.emplace(task.capture, folder); !fresh)
        throw Error(ErrorKind::Input, fmt::format("two captures have the name '{}'", task.capture),
                    {.where = folder.string(),
                     .why = fmt::format("the other one is {}; both would write {}", other->second.string(),
                                        (desc.results / task.capture).string()),
                     .hint = "rename one of them",
                     .code = "SAME_NAME"});
      task.project = desc.results / task.capture;
      task.photo_count = photos.photos.size();
      if (inner) task.options = options_beside(folder);
      task.options.insert(task.options.end(), desc.options.begin(), desc.options.end());
      estimate(graph, photos, task);
      plan.tasks.push_back(std::move(task));
    }
  }
  if (plan.tasks.empty())
    throw Error(ErrorKind::Input, "there is no capture",
                {.where = desc.captures.empty() ? "" : desc.captures[0].string(),
                 .why = plan.notes.empty() ? "it has no folders" : plan.notes[0],
                 .hint = "each object needs a folder of photos of its own",
                 .code = "NO_CAPTURES"});
  std::ranges::sort(plan.tasks, {}, &FarmTask::capture);
  check_options(plan.tasks[0]);
  return plan;
}

}  // namespace vitrine
