#include "tests/bench/optics/programs.h"

#include <unistd.h>

#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/foundation/base/hash.h"
#include "core/foundation/base/process.h"
#include "core/scene/camera/mask_class.h"
#include "pipeline/plan.h"

namespace vitrine {
namespace {

using nlohmann::json;

constexpr const char* kTrainingStage = "optimize";
constexpr const char* kMeasuringStage = "evaluate";
constexpr const char* kPreset = "preview";
constexpr const char *kMarksFile = "marks.yaml", *kMarkedStage = "masks";  // sfm takes folders alone
constexpr int kSurfelsPerFirstPoint = 3;  // as in the preset: surfels to end with for one point inside the frustums to start with

// Inputs that are optional and nevertheless computed: what `vitrine run` gives to training. The others are for other figures.
const std::set<std::string> kWantedInputs = {"masks", "objects", "normals"};
const std::set<std::string> kRelitInputs = {"mesh", "refine", "decompose"};

std::vector<std::string> common_options(const ProgramsDesc& desc) {
  std::vector<std::string> words = {fmt::format("ingest.max_side={}", desc.max_side),
                                    fmt::format("optimize.iterations={}", desc.steps),
                                    fmt::format("optimize.max_gaussians={}", desc.surfels),
                                    fmt::format("optimize.initial.frustum_points={}", desc.surfels / kSurfelsPerFirstPoint),
                                    fmt::format("optimize.max_side={}", desc.max_side),
                                    "evaluate.score_train_views=false",
                                    "evaluate.write_layers=false"};
  if (!desc.relit) words.emplace_back("evaluate.relit_samples=0");
  return words;
}

void add_stage(const Graph& graph, const std::string& name, bool relit, std::set<std::string>& wanted) {
  if (!wanted.insert(name).second) return;
  for (const NodeInput& input : graph.at(name).inputs)
    if (input.artifact && (!input.optional || kWantedInputs.contains(input.name) || (relit && kRelitInputs.contains(input.name))))
      add_stage(graph, input.name, relit, wanted);
}

// Empties the folder of what other settings left; `mark` is a file there that says which they were.
void claim(const fs::path& folder, const char* mark, const json& settings, const std::vector<fs::path>& leftovers) {
  const fs::path file = folder / mark;
  if (fs::exists(file) && json::parse(read_file(file), nullptr, false) == settings) return;
  for (const fs::path& leftover : leftovers) fs::remove_all(leftover);
  make_folders(folder);
  write_file(file, settings.dump(1) + "\n");
}

// A training that goes on from a checkpoint has used time that nobody knows.
bool has_checkpoint(const fs::path& store) {
  std::error_code ec;
  for (const auto& e : fs::directory_iterator(store / kTrainingStage, ec))
    if (e.path().filename().string().ends_with(".scratch")) return true;
  return false;
}

}  // namespace

Programs::Programs(ProgramsDesc desc) : desc_(std::move(desc)), graph_(load_graph(desc_.programs)) {
  std::set<std::string> wanted;
  add_stage(graph_, kMeasuringStage, desc_.relit, wanted);
  training_ = graph_.ancestors(graph_.at(kTrainingStage));
  training_.insert(kTrainingStage);
  Hasher preparing;
  for (const StageNode& stage : graph_.nodes) {
    if (!wanted.contains(stage.name)) continue;
    stages_.push_back(&stage);
    program_digests_[stage.name] = digest_file(stage.executable).short_hex();
    if (is_training(stage.name) && stage.name != kTrainingStage) preparing.add(program_digests_[stage.name]);
  }
  preparing_digest_ = preparing.digest().short_hex();
}

OpticsRun Programs::run_of(const OpticsScene& scene, const Arm& arm, int training_seed) {
  SettingsDesc desc{.flags = {{"preset", kPreset, "vitrine-optics"}}, .sets = common_options(desc_)};
  desc.sets.push_back(fmt::format("optimize.seed={}", training_seed));
  for (const auto& [path, value] : arm.options)
    if (!path.starts_with("input.")) desc.sets.push_back(path + "=" + value);
  Settings settings(graph_);
  try {
    settings.load(desc);
  } catch (const Error& e) {
    throw Error(
        e.kind(), fmt::format("arm '{}': {}", arm.name, e.message()),
        {.where = "--arms", .why = e.detail().why, .hint = "`vitrine config reference STAGE` lists options", .code = "USAGE"});
  }
  Given here{
      .scene = scene.folder, .poses = arm.source("poses"), .masks = arm.source("masks"), .options = {}, .preparing = nullptr};
  if (here.masks == "truth" && !fs::is_directory(scene.folder / "truth/mask")) here.masks = "none";
  if (here.masks == "marks" && !fs::is_regular_file(scene.folder / kMarksFile))
    throw Error(ErrorKind::Input, fmt::format("arm '{}' wants the marks of a scene that has none", arm.name),
                {.where = (scene.folder / kMarksFile).string(),
                 .hint = "vitrine-generate gallery writes marks; input.masks=none",
                 .code = "MASKS_MISSING"});
  OpticsRun run{scene.name, arm.name, training_seed, json::object(), json::object()};
  run.training["inputs"] = {{"poses", here.poses}, {"masks", here.masks}};
  run.training["scene"] = digest_of_training_inputs(scene.folder);
  if (here.masks == "marks") run.training["marks"] = digest_file(scene.folder / kMarksFile).short_hex();
  run.measuring["truth"] = digest_of_truth(scene.folder);
  for (const StageNode* stage : stages_) {
    here.options[stage->name] = settings.stage_arguments(*stage);
    json& part = is_training(stage->name) ? run.training : run.measuring;
    part["programs"][stage->name] = program_digests_[stage->name];
    const std::string stem = stage->name + ".";
    for (const Option& o : settings.options.table.options)
      if (o.path.starts_with(stem) && o.text() != o.default_text && o.affects_result) part["options"][o.path] = o.text();
  }
  auto& mutex = preparing_[scene.name];
  if (!mutex) mutex = std::make_unique<std::mutex>();
  here.preparing = mutex.get();
  given_[{run.scene, run.arm, training_seed}] = std::move(here);
  return run;
}

OpticsWork Programs::work() {
  return {.train = [this](const OpticsRun& run) { return train(run); },
          .measure = [this](const OpticsRun& run, const json& trained) { return measure(run, trained); }};
}

// The folders of truth/mask that are classes of masks: what else stands there is for the evaluation.
fs::path Programs::masks_of(const OpticsRun& run) const {
  const fs::path to = desc_.work / "given" / run.scene / "masks";
  for (const MaskClass kind : kMaskClasses) {
    const fs::path from = given(run).scene / "truth/mask" / name(kind);
    fs::remove_all(to / name(kind));
    if (!fs::is_directory(from)) continue;
    make_folders(to / name(kind));
    fs::copy(from, to / name(kind), fs::copy_options::recursive);
  }
  return to;
}

fs::path Programs::run_stage(const StageNode& stage, const OpticsRun& run, const fs::path& store,
                             const Artifacts& artifacts) const {
  const Given& here = given(run);
  const fs::path folder = folder_of_run(desc_.work, run);
  std::vector<std::string> words = {stage.executable.string(),    "--store", store.string(), "--log-format", "json", "--log-file",
                                    (folder / "log.txt").string()};
  if (stage.name == kMeasuringStage) words.insert(words.end(), {"--output", folder.string()});
  const auto add_input = [&](const std::string& input, const fs::path& path) {
    words.insert(words.end(), {"--input", input + "=" + path.string()});
  };
  for (const NodeInput& input : stage.inputs) {
    if (const auto it = artifacts.find(input.name); input.artifact && it != artifacts.end()) add_input(input.name, it->second);
    if (input.artifact) continue;
    if (input.name == "photos" || input.name == "truth")
      add_input(input.name, here.scene / input.name);
    else if (input.name == "poses" && here.poses == "truth")
      add_input(input.name, here.scene / "truth/transforms.json");
    else if (input.name == "masks" && here.masks == "marks" && stage.name == kMarkedStage)
      add_input(input.name, here.scene / kMarksFile);
    else if (input.name == "masks" && here.masks == "truth")
      add_input(input.name, desc_.work / "given" / run.scene / "masks");
  }
  const std::vector<std::string>& options = here.options.at(stage.name);
  words.insert(words.end(), options.begin(), options.end());
  if (desc_.threads > 0) words.insert(words.end(), {"--threads", std::to_string(desc_.threads)});
  std::string error_record;
  fs::path entry;
  const ProcessResult result = run_process({.arguments = words,
                                            .environment = {{"VITRINE_PARENT_PID", std::to_string(getpid())}},
                                            .on_line = [&](std::string_view line) {
                                              const json record = json::parse(line, nullptr, false);
                                              if (!record.is_object()) return;
                                              const std::string type = record.value("type", "");
                                              if (type == "error") error_record = record.dump();
                                              if (type == "artifact") entry = record.value("path", "");
                                            }});
  if (!result.ok()) {
    throw_if_interrupted();
    throw_stage_failure(stage, error_record, result);
  }
  VITRINE_CHECK(!entry.empty(), "stage '{}' ended well and named no result", stage.name);
  return entry;
}

json Programs::train(const OpticsRun& run) const {
  const fs::path folder = folder_of_run(desc_.work, run), store = folder / "store";
  claim(folder, "training.json", run.training, {store, folder / "log.txt", folder / "eval"});
  Artifacts artifacts;
  {
    const std::scoped_lock lock(*given(run).preparing);
    if (given(run).masks == "truth") masks_of(run);
    const fs::path shared = desc_.work / "stages" / preparing_digest_ / run.scene;
    for (const StageNode* stage : stages_)
      if (is_training(stage->name) && stage->name != kTrainingStage)
        artifacts[stage->name] = run_stage(*stage, run, shared, artifacts);
  }
  const bool goes_on = has_checkpoint(store);
  const fs::path entry = run_stage(graph_.at(kTrainingStage), run, store, artifacts);
  artifacts[kTrainingStage] = entry;
  json trained;
  if (const json timing = json::parse(read_file(entry / "timing.json"), nullptr, false); timing.is_object() && !goes_on)
    trained[kCpuFigure] = timing.value("cpu_seconds", 0.0);
  for (const auto& [stage, path] : artifacts) trained["artifacts"][stage] = fs::relative(path, desc_.work).string();
  return trained;
}

Figures Programs::measure(const OpticsRun& run, const json& trained) const {
  const fs::path folder = folder_of_run(desc_.work, run), store = folder / "store";
  Artifacts artifacts;
  for (const auto& [stage, path] : trained.at("artifacts").items()) {
    artifacts[stage] = desc_.work / path.get<std::string>();
    if (!fs::exists(artifacts[stage]))
      throw Error(ErrorKind::Input, "what was trained is no longer there",
                  {.where = artifacts[stage].string(),
                   .why = "it is needed to measure again",
                   .hint = fmt::format("remove {}: the run is done again", file_of_run(desc_.work, run).string()),
                   .code = "MISSING_INPUT"});
  }
  std::vector<const StageNode*> measuring;
  std::vector<fs::path> leftovers = {folder / "eval"};
  for (const StageNode* stage : stages_)
    if (!is_training(stage->name)) measuring.push_back(stage), leftovers.push_back(store / stage->name);
  claim(folder, "measuring.json", run.measuring, leftovers);
  fs::path entry;
  for (const StageNode* stage : measuring) entry = artifacts[stage->name] = run_stage(*stage, run, store, artifacts);
  const fs::path file = entry / "eval/metrics.json";
  const json metrics = json::parse(read_file(file), nullptr, false);
  Figures figures = figures_of(metrics);
  if (figures.empty())
    throw Error(ErrorKind::Input, "the evaluation measured nothing",
                {.where = file.string(), .hint = "its log.txt says why", .code = "NOT_MEASURED"});
  return figures;
}

}  // namespace vitrine
