// vitrine run PHOTOS|PROJECT
#include <algorithm>
#include <iostream>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/folder_files.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/base/terminal.h"
#include "core/foundation/base/timer.h"
#include "core/foundation/config/cli.h"
#include "pipeline/commands.h"
#include "pipeline/cost_model.h"
#include "pipeline/given_inputs.h"
#include "pipeline/measures_in_photos.h"
#include "pipeline/plan.h"
#include "pipeline/project.h"
#include "pipeline/report.h"
#include "pipeline/tool.h"

namespace vitrine {

namespace {

struct RunArguments {
  std::string what, output, preset, poses, masks, objects, normals, depth, truth, grey_card, scale_bar, max_memory, device,
      log_format = "text";
  std::vector<std::string> configs, sets;
  Selection selection;
  int threads = 0, max_gaussians = 0, frames = 0, blocks = 0;
  bool dry_run = false, no_preflight = false, no_progress = false, quiet = false, verbose = false, help = false;
};

CommandLine run_command_line(RunArguments& a) {
  CommandLine cli("vitrine run", "PHOTOS|PROJECT [-o DIR] [options]",
                  "Photos in, scene out. PHOTOS is a folder of photos, with films or without, or one film; PROJECT is the output "
                  "folder of an earlier run, which "
                  "remembers its photos "
                  "and settings. Stages whose inputs and options did not change are not computed again.");
  cli.section("what");
  cli.value("output", 'o', "DIR", a.output, "Output folder; default: a folder named after the photos.");
  cli.value("preset", 0, "NAME", a.preset, "Quality: preview, standard or high.");
  cli.values("config", 'c', "FILE", a.configs, "YAML file with options; later files win.");
  cli.values("set", 0, "STAGE.OPTION=VALUE", a.sets, "One option; wins over files.");
  cli.value("poses", 0, "PATH", a.poses,
            "Known camera poses: a COLMAP model, a transforms.json, or a file of Metashape, OpenSfM or OpenMVG.");
  cli.value("masks", 0, "PATH", a.masks,
            "Masks of the photos: a folder per class (object, transparent, specular, ignore), masks of the object alone, or a "
            "YAML file that "
            "marks objects in a few photos (vitrine mark).");
  cli.value(
      "objects", 0, "FILE", a.objects,
      "The table of glass, mirrors and coats: objects/objects.json of an earlier run, corrected by hand; instead of one that "
      "is found.");
  cli.value("normals", 0, "DIR", a.normals, "Normal maps of the photos, named like them: PNG or EXR, in any frame.");
  cli.value("depth", 0, "PATH", a.depth,
            "Depth maps of the photos, named like them: 16-bit PNG in millimetres, EXR or TIFF of floats in metres; or a "
            "transforms.json with depth_file_path.");
  cli.value("truth", 0, "DIR", a.truth,
            "Ground truth to evaluate against; a folder 'truth' next to the photos is found by itself, \"none\" leaves it out.");
  cli.value(
      "grey-card", 0, "PHOTO:X,Y,W,H", a.grey_card,
      "A card of known albedo (decompose.grey_albedo, 0.18), which sets the scale of all albedos and the colour of the light: a "
      "box in one photo, in pixels of that photo in the output folder's `images`.");
  cli.value(
      "scale-bar", 0, "MARKS", a.scale_bar,
      "A scale bar in the picture, which sets the unit of exported files: its two ends in two or more photos and its length, "
      "\"PHOTO:X1,Y1,X2,Y2 PHOTO:X1,Y1,X2,Y2 = 5cm\", in pixels of the output folder's `images`.");
  cli.value("frames", 0, "N", a.frames, 2, "Most frames of films that become photos (ingest.frames, 120).");
  cli.section("which stages");
  cli.value("from", 0, "STAGE", a.selection.from, "Leave the stages before this one as they are.");
  cli.value("to", 0, "STAGE", a.selection.to, "Stop after this stage.");
  cli.value("only", 0, "STAGE", a.selection.only, "Only this stage.");
  cli.flag("force", 0, a.selection.force, "Compute the chosen stages even if nothing changed.");
  cli.flag("dry-run", 'n', a.dry_run, "Print what would be done, and why; do nothing.");
  cli.section("machine");
  cli.value("threads", 'j', "N", a.threads, 0, "Threads; 0 = all. Results do not depend on it.");
  cli.value("max-memory", 0, "SIZE", a.max_memory, "Memory to stay below: 4GiB, 80%.");
  cli.value("device", 0, "cpu|cuda|auto", a.device,
            "Where pictures are computed in training and evaluation; auto: a GPU where one is usable.");
  cli.value("max-gaussians", 0, "N", a.max_gaussians, 1, "Most Gaussians (the option max_gaussians of the stage that has it).");
  cli.value("blocks", 0, "N", a.blocks, 1,
            "For scenes larger than memory: split by place into N blocks, which are trained one after the other and joined.");
  cli.flag("no-preflight", 0, a.no_preflight, "Begin although the disk looks too small.");
  cli.section("reports");
  cli.value("log-format", 0, "text|json", a.log_format, "json: one record per line on stdout.");
  cli.flag("no-progress", 0, a.no_progress, "No progress bar, no progress lines.");
  cli.flag("quiet", 'q', a.quiet, "Errors only.");
  cli.flag("verbose", 'v', a.verbose, "More detail.");
  cli.flag("help", 'h', a.help, "Print this text.");
  return cli;
}

struct Target {
  fs::path project;
  std::string photos;  // empty: the photos stored in the project
  bool fresh = true;   // replaces the project's settings; false: they are a settings layer
};

void refuse_composition(const fs::path& project) {
  if (!is_composition(project)) return;
  throw Error(ErrorKind::Usage, "this folder is a composition: it has no photos to compute it from",
              {.where = project.string(),
               .hint = "vitrine compose SCENE.yaml -o " + join_command({project.string()}),
               .code = "COMPOSITION"});
}

Target target_of(const RunArguments& a) {
  const fs::path what = fs::absolute(a.what).lexically_normal();
  std::error_code ec;
  if (!fs::exists(what, ec))
    throw Error(ErrorKind::Input, "there is no such folder",
                {.where = what.string(),
                 .hint = "give a folder of photos, or the output folder of an earlier run",
                 .code = "MISSING_INPUT"});
  if (is_project(what)) {
    refuse_composition(what);
    if (!a.output.empty() && !(lies_in(a.output, what) && lies_in(what, a.output)))
      throw Error(ErrorKind::Usage, "this is the output folder of an earlier run: it cannot have another one",
                  {.where = what.string(), .hint = "leave out -o, or give the folder of photos", .code = "USAGE"});
    return {what, {}, false};
  }
  const fs::path project = a.output.empty() ? default_project(what) : fs::absolute(a.output).lexically_normal();
  if (fs::is_directory(what, ec) && lies_in(project, what))
    throw Error(ErrorKind::Usage, "the output folder lies inside the folder of photos",
                {.where = project.string(), .hint = "choose another one with -o", .code = "USAGE"});
  refuse_composition(project);
  return {project, what.string(), !is_project(project) || settings_untouched(project)};
}

SettingsDesc settings_desc(const RunArguments& a, const Target& target, const Settings& settings) {
  SettingsDesc desc{.project = target.project, .read_project = !target.fresh, .configs = a.configs, .sets = a.sets};
  const auto flag = [&](const std::string& path, const std::string& value, const std::string& origin) {
    if (value.empty()) return;
    if (settings.options.table.find(path) == nullptr)
      throw Error(ErrorKind::Usage,
                  fmt::format("{} is of no use here: no stage reads '{}'", origin, path.substr(path.find('.') + 1)),
                  {.hint = "leave it out", .code = "USAGE"});
    desc.flags.push_back({path, value, origin});
  };
  flag("preset", a.preset, "--preset");
  flag("input.photos", target.photos, "command line");
  flag("input.poses", a.poses, "--poses");
  flag("input.masks", a.masks, "--masks");
  flag("input.objects", a.objects, "--objects");
  flag("input.normals", a.normals, "--normals");
  flag("input.depth", a.depth, "--depth");
  flag("input.truth", a.truth, "--truth");
  flag("decompose.grey_card", a.grey_card, "--grey-card");
  flag("export.scale_bar", a.scale_bar, "--scale-bar");
  if (a.frames > 0) flag("ingest.frames", std::to_string(a.frames), "--frames");
  if (a.threads > 0) flag("limits.threads", std::to_string(a.threads), "--threads");
  flag("limits.memory", a.max_memory, "--max-memory");
  flag("limits.device", a.device, "--device");
  // Of the stage that has the option.
  const auto flag_of_stage = [&](const std::string& name, int value, const std::string& origin) {
    if (value <= 0) return;
    const auto& all = settings.options.table.options;
    const auto option = std::find_if(all.begin(), all.end(), [&](const Option& o) { return o.path.ends_with("." + name); });
    if (option == all.end())
      throw Error(ErrorKind::Usage, fmt::format("{} is of no use here: no stage has the option", origin),
                  {.hint = "leave it out", .code = "USAGE"});
    flag(option->path, std::to_string(value), origin);
  };
  flag_of_stage("max_gaussians", a.max_gaussians, "--max-gaussians");
  flag_of_stage("blocks", a.blocks, "--blocks");
  return desc;
}

// A failure to write a page does not fail the run.
void write_view(Report& report, const fs::path& project) {
  const ViewPageOutcome outcome = write_view_page(project);
  if (outcome.what == ViewPage::Written) report.line(fmt::format("view: {}", view_page_path(project).string()));
  if (outcome.what == ViewPage::Failed) report.line(fmt::format("note: there is no view.html of this run: {}", outcome.why));
}

void write_page(Report& report, const fs::path& project, bool only_if_changed) {
  const auto why_not = write_html_report(project, only_if_changed);
  report.line(why_not ? fmt::format("note: there is no report.html of this run: {}", *why_not)
                      : fmt::format("report: {}", html_report_path(project).string()));
}

// Runs once, before the first stage with an estimate; ingest must have read the photos.
class PreflightOnce {
 public:
  PreflightOnce(const Planner& planner, const Settings& settings, const fs::path& project, Report& report)
      : planner_(planner), settings_(settings), project_(project), report_(report) {}

  void operator()(size_t next) {
    const auto capture = told_ || next == 0 ? std::nullopt : ingested_capture(project_, settings_);
    if (!capture) return;
    told_ = true;
    std::vector<const StageNode*> stages;
    for (size_t i = next; i < planner_.graph().nodes.size(); ++i)
      if (planner_.chosen(planner_.graph().nodes[i])) stages.push_back(&planner_.graph().nodes[i]);
    const int threads = std::stoi(settings_.text("limits.threads"));
    const std::string limit = settings_.text("limits.memory");
    const Resources there{
        .memory_bytes = limit.empty() ? available_memory_bytes() : parse_bytes(limit, machine_memory_bytes(), "limits.memory"),
        .disk_bytes = free_disk_bytes(project_),
        .memory_is_limit = !limit.empty()};
    const Preflight p = preflight(stages, settings_, *capture, threads > 0 ? threads : hardware_threads(), there);
    report_.note(preflight_line(p, there));
    for (const std::string& note : p.notes) report_.note(note);
  }

 private:
  const Planner& planner_;
  const Settings& settings_;
  const fs::path& project_;
  Report& report_;
  bool told_ = false;
};

// Settings of an earlier run that `vitrine run PHOTOS` replaces by those of this command line. Empty: nothing is lost.
std::string replaced_settings(const Graph& graph, const Settings& settings, const Target& target) {
  if (!target.fresh || !is_project(target.project)) return {};
  Settings before(graph);
  try {
    before.load({.project = target.project});
  } catch (const Error&) {
    return {};  // a damaged vitrine.yaml is replaced
  }
  const std::string changes = changed_settings(before, settings);
  if (changes.empty()) return {};
  return fmt::format("note: the settings of this folder change: {} (`vitrine run {}` would keep them)", changes,
                     target.project.string());
}

int dry_run(Planner& planner, const fs::path& project) {
  int to_run = 0;
  for (const Step& step : planner.all()) {
    if (step.state == StepState::Skipped) continue;
    const bool run = to_be_run(step.state);
    to_run += run;
    fmt::print("{:<5} {:<10} {}\n", run ? "run" : "keep", step.node->name,
               run ? "because " + step.why : std::string(name(step.state)));
    for (size_t i = 1; i < step.changes.size(); ++i) fmt::print("      {:<10} and {}\n", "", step.changes[i]);
  }
  if (to_run == 0) fmt::print("everything up to date in {}\n", project.string());
  return 0;
}

// `opened`: set once the report is open and records errors itself.
// Why --device auto takes the CPU; empty: it does not, or nothing wants a device. Throws Error{Device} before anything is
// computed if `cuda` cannot be had.
std::string why_no_wanted_device(const Graph& graph, const Settings& settings) {
  const std::string device = settings.text("limits.device");
  const std::string why = device == "cpu" ? std::string() : why_no_device(graph);
  if (device == "cuda" && !why.empty())
    throw Error(ErrorKind::Device, "no GPU is usable here",
                {.where = "--device cuda",
                 .why = why,
                 .hint = "--device cpu, or --device auto; `vitrine doctor` describes the card",
                 .code = "NO_DEVICE"});
  return why;
}

int run(const RunArguments& a, const Words& words, bool& opened) {
  set_log_console(a.quiet ? LogLevel::Warning : LogLevel::Info, colour_wanted(2));
  const Target target = target_of(a);
  const Graph graph = load_graph(stage_folder());
  Settings settings(graph);
  settings.load(settings_desc(a, target, settings));
  if (const std::string limit = settings.text("limits.memory"); !limit.empty())
    parse_bytes(limit, machine_memory_bytes(), settings.options.table.find("limits.memory")->origin);
  const std::vector<std::string> measured = check_measures(settings);
  check_inputs_apart(target.project, graph, settings);
  Planner planner(graph, settings, target.project, a.selection);
  check_given_inputs(planner, settings);
  const std::string replaced = replaced_settings(graph, settings, target);
  if (a.dry_run) {
    if (!replaced.empty()) fmt::print("{}\n", replaced);
    return dry_run(planner, target.project);
  }

  const std::string no_device = why_no_wanted_device(graph, settings);
  make_folders(store_of(target.project));
  const ProjectLock lock(target.project);
  Words command = {"vitrine", "run"};
  command.insert(command.end(), words.begin(), words.end());
  Report report({.project = target.project,
                 .json = a.log_format == "json",
                 .quiet = a.quiet,
                 .show_progress = !a.no_progress,
                 .command = command});
  report.open();
  opened = true;
  if (!replaced.empty()) report.note(replaced);
  for (const std::string& note : measured) report.note(note);
  if (!no_device.empty()) report.note("note: --device auto takes the CPU: " + no_device);
  if (target.fresh)
    write_project_settings(target.project, settings);
  else if (std::any_of(settings.from_command.begin(), settings.from_command.end(),
                       [](const std::string& p) { return p != "input.photos" && !p.starts_with("limits."); }))
    report.line("note: options on the command line hold for this run; to keep them, write them into vitrine.yaml");
  const Timer clock;
  PreflightOnce preflight_once(planner, settings, target.project, report);
  MeasuresOnce measures_once(planner, settings, target.project);
  try {
    const int computed = run_stages(planner, settings, target.project, report,
                                    {.threads = std::stoi(settings.text("limits.threads")),
                                     .memory = settings.text("limits.memory"),
                                     .verbose = a.verbose,
                                     .quiet = a.quiet,
                                     .before_computing = [&](size_t next) {
                                       measures_once(next);
                                       if (!a.no_preflight) preflight_once(next);
                                     }});
    report.line(computed == 0 ? fmt::format("everything up to date in {}", target.project.string())
                              : fmt::format("done in {}: {}", duration_text(clock.seconds()), target.project.string()));
  } catch (const Error& e) {
    report.untold_error(e);
    try {
      report.finish(settings, exit_code(e.kind()));
      write_page(report, target.project, false);
    } catch (const Error& unwritten) {  // a full disk prevents the report, too; the original error is reported
      report.line(fmt::format("note: there is no report of this run: {}", unwritten.detail().why));
    }
    if (e.kind() == ErrorKind::Interrupted || e.kind() == ErrorKind::Preempted)
      throw Error(e.kind(), "stopped; what was finished and the last checkpoint are kept",
                  {.hint = "continue with: " + join_command(command), .code = e.detail().code});
    throw;
  }
  report.finish(settings, 0);
  write_view(report, target.project);
  write_page(report, target.project, true);
  return 0;
}

}  // namespace

int run_command(const Words& words) {
  RunArguments a;
  const CommandLine cli = run_command_line(a);
  const Words rest = cli.parse(words, 1);
  if (a.help) {
    std::cout << cli.help(
        "Exit codes: 0 done, 1 internal error, 2 usage, 3 input, 4 no camera poses,\n"
        "5 quality gate, 6 memory or disk, 7 missing program, 8 device, 9 folder in use,\n"
        "10 diverged, 75 stopped by SIGTERM with a checkpoint, 130 interrupted.\n");
    return 0;
  }
  if (rest.empty()) throw Error(ErrorKind::Usage, "which photos?", {.hint = "vitrine run PHOTOS -o DIR", .code = "USAGE"});
  if (a.log_format != "text" && a.log_format != "json")
    throw Error(ErrorKind::Usage, fmt::format("--log-format must be text or json, got \"{}\"", a.log_format),
                {.hint = "--log-format json", .code = "USAGE"});
  a.what = rest[0];
  bool opened = false;
  try {
    return run(a, words, opened);
  } catch (const Error& e) {
    if (a.log_format == "json" && !opened) std::cout << early_error_record(e) << std::endl;
    throw;
  }
}

}  // namespace vitrine
