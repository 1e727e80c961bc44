// vitrine-optics: trains the scenes of a family in several ways and compares their figures, per region.
#include <ctime>
#include <exception>
#include <fstream>
#include <sstream>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/config/cli.h"
#include "pipeline/project.h"
#include "tests/bench/optics/programs.h"
#include "tests/bench/optics/record.h"

namespace {

using namespace vitrine;

struct OpticsArguments {
  std::string seeds, training_seeds = "1,2", arms = "diffuse,full", work, programs, record, commit;
  std::vector<std::string> scenes;
  int steps = 1000, surfels = 30000, max_side = 320, jobs = 1, threads = 0;
  bool automatic = false, relit = false, help = false;
};

constexpr const char* kTail =
    "\nexamples:\n"
    "  vitrine-optics --seeds 1-12 --work DIR\n"
    "  vitrine-optics --seeds 1-12 --work DIR --arms "
    "'diffuse,full,soft:optimize.layers=full;optimize.loss.specular_mask=0'\n"
    "  vitrine-optics --scenes sample_data/cabinet --work DIR --training-seeds 1 --steps 300\n"
    "\narms: diffuse (one opaque layer), full (the layers that the masks ask for), layers (without the\n"
    "opaque twin), auto (no masks), or\n"
    "NAME:stage.option=value;...; input.masks=none and input.poses=none leave these out, input.masks=marks\n"
    "takes the boxes of the scene's marks.yaml. Everything else is as in the preset 'preview'. Work that was\n"
    "interrupted goes on with the same command. Tune on seeds 1-12; seeds 101-112 are run once, at the end of a piece of work.\n"
    "Exit codes: 0 done, 1 a run failed (the table has the others), 2 usage, or runs there have other settings, 3 input, 130 "
    "stopped.\n";

CommandLine optics_command_line(OpticsArguments& a) {
  CommandLine cli("vitrine-optics", "--seeds LIST --work DIR [options]",
                  "Trains generated scenes with glass, mirrors and coats in several ways and prints the figures of each, and by "
                  "how much each way differs from the first, per region.");
  cli.section("what");
  cli.value("seeds", 0, "LIST", a.seeds, "Seeds of scenes: 1-12, or 1,2,7. Missing scenes are generated.");
  cli.values("scenes", 0, "DIR", a.scenes,
             "A folder with seed_<N>/, or a capture with photos/ and truth/ that joins the seeds; may be repeated.");
  cli.value("arms", 0, "LIST", a.arms, "Ways of training (below); the first is the one compared with. Default: diffuse,full.");
  cli.flag("auto", 0, a.automatic, "Adds the arm 'auto': photos and poses, no masks.");
  cli.value("training-seeds", 0, "LIST", a.training_seeds, "Seeds of the training. Default: 1,2.");
  cli.value("steps", 0, "N", a.steps, 1, "Steps of a training. Default: 1000.");
  cli.value("surfels", 0, "N", a.surfels, 100, "Most surfels of a training. Default: 30000.");
  cli.value("max-side", 0, "N", a.max_side, 32, "Longest side of the photos, pixels. Default: 320.");
  cli.flag("relit", 0, a.relit, "Albedo and pictures under other lights, too: needs mesh and decompose, which takes longer.");
  cli.section("where");
  cli.value("work", 0, "DIR", a.work, "Scenes, trainings and their figures; what is done there is not done again.");
  cli.value("programs", 0, "DIR", a.programs,
            "Folder of the stages' programs and vitrine.stages. Default: that of this program.");
  cli.value("record", 0, "FILE", a.record, "Writes the figures as JSON: tests/results/optics.json; needs --commit.");
  cli.value("commit", 0, "HASH", a.commit, "Of the sources that the programs were built from: 40 hexadecimal digits.");
  cli.section("machine");
  cli.value("jobs", 0, "N", a.jobs, 1,
            "Trainings at a time, which share the threads. Default: 1. Seconds are CPU time of a training.");
  cli.value("threads", 'j', "N", a.threads, 0, "Threads of all jobs together; 0 = all.");
  cli.flag("help", 'h', a.help, "Print this text.");
  return cli;
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  char text[16];
  std::strftime(text, sizeof text, "%Y-%m-%d", std::gmtime(&now));
  return text;
}

std::string processor() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown";
}

void check_record(const OpticsArguments& a) {
  if (a.record.empty()) return;
  if (a.commit.size() != 40 || a.commit.find_first_not_of("0123456789abcdef") != std::string::npos)
    throw Error(ErrorKind::Usage, "--record needs the commit that the programs were built from",
                {.where = "--commit", .hint = "--commit $(git rev-parse HEAD)", .code = "USAGE"});
}

void make_gallery(const fs::path& programs, int seed, const fs::path& folder, int threads) {
  const fs::path beside = programs / "vitrine-generate";
  const fs::path generator = fs::exists(beside) ? beside : own_folder() / "vitrine-generate";
  fmt::print("seed_{}: generating\n", seed);
  std::fflush(stdout);
  const ProcessResult r = run_process({.arguments = {generator.string(), "gallery", "--seed", std::to_string(seed), "-o",
                                                     folder.string(), "-j", std::to_string(threads)}});
  if (r.ok()) return;
  throw_if_interrupted();
  throw Error(ErrorKind::Input, fmt::format("scene {} was not generated", seed),
              {.where = "vitrine-generate gallery",
               .why = r.tail,
               .hint = "--scenes DIR with the scenes as seed_<N>/",
               .code = "NO_SCENE"});
}

int compare(const OpticsArguments& a) {
  if (a.work.empty()) throw Error(ErrorKind::Usage, "where to?", {.hint = "--work DIR", .code = "USAGE"});
  check_record(a);
  const std::vector<int> seeds = a.seeds.empty() ? std::vector<int>() : seed_list(a.seeds, "--seeds");
  const std::vector<int> training_seeds = seed_list(a.training_seeds, "--training-seeds");
  const std::vector<Arm> arms = arm_list(a.arms + (a.automatic ? ",auto" : ""));
  const fs::path work = fs::absolute(a.work).lexically_normal();
  const int threads = a.threads > 0 ? a.threads : hardware_threads();
  const fs::path binaries = a.programs.empty() ? own_folder() : fs::absolute(a.programs).lexically_normal();
  Programs programs({.programs = binaries,
                     .work = work,
                     .steps = a.steps,
                     .surfels = a.surfels,
                     .max_side = a.max_side,
                     .relit = a.relit,
                     .threads = std::max(1, threads / a.jobs)});
  make_folders(store_of(work));
  const ProjectLock lock(work);
  std::vector<fs::path> places;
  for (const std::string& place : a.scenes) places.push_back(fs::absolute(place).lexically_normal());
  const auto scenes = optics_scenes(seeds, places, work / "scenes",
                                    [&](int seed, const fs::path& folder) { make_gallery(binaries, seed, folder, threads); });
  // All arms of a scene one after the other: whoever looks early sees whole rows.
  std::vector<OpticsRun> runs;
  for (const OpticsScene& scene : scenes)
    for (const int seed : training_seeds)
      for (const Arm& arm : arms) runs.push_back(programs.run_of(scene, arm, seed));
  const OpticsOutcome outcome = run_optics(runs, work, a.jobs, programs.work(), [](const std::string& line) {
    fmt::print("{}\n", line);
    std::fflush(stdout);
  });
  const OpticsSummary summary = summary_of(outcome.results, arms.front().name);
  fmt::print("\n{}", summary_text(summary));
  for (const std::string& failure : outcome.failures) fmt::print(stderr, "\nfailed: {}\n", failure);
  if (!outcome.failures.empty()) {
    if (!a.record.empty()) fmt::print(stderr, "\nnote: {} is not written: not all runs are there\n", a.record);
    return 1;
  }
  if (!a.record.empty())
    write_file(a.record, optics_record({.commit = a.commit,
                                        .cpu = processor(),
                                        .date = today(),
                                        .cores = hardware_threads(),
                                        .seeds = seeds,
                                        .training_seeds = training_seeds,
                                        .arms = arms,
                                        .steps = a.steps,
                                        .surfels = a.surfels,
                                        .max_side = a.max_side},
                                       summary));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    install_interrupt_handlers();
    set_log_console(LogLevel::Warning, false);
    OpticsArguments a;
    const CommandLine cli = optics_command_line(a);
    cli.parse({argv + 1, argv + argc}, 0);
    if (a.help) {
      fmt::print("{}", cli.help(kTail));
      return 0;
    }
    return compare(a);
  } catch (const Error& e) {
    fmt::print(stderr, "{}\n", e.with_prefix());
    return exit_code(e.kind());
  } catch (const std::exception& e) {
    fmt::print(stderr, "error: {}\n", e.what());
    return exit_code(ErrorKind::Internal);
  }
}
