#include "tests/pipeline/stages/test_stages.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <new>
#include <stdexcept>
#include <thread>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/process.h"

namespace vitrine::test_stages {

void describe(Describer& d, CollectConfig& c) {
  d.option("repeat", c.repeat, "How often the list is written.").range(1, 100000);
  d.option("step_ms", c.step_ms, "Pause after each repetition.").range(0, 10000).affects_output(false);
  d.option("memory_mb", c.memory_mb, "Memory held from the middle on.").range(0, 4096).affects_output(false);
  d.option("warn", c.warn, "Whether it warns, at length.").affects_output(false);
  d.option("fail", c.fail, "How to fail half way.")
      .choices({"no", "input", "memory", "exception", "check", "crash"})
      .affects_output(false);
  d.option("label", c.label, "First line of the list.");
  d.option("foot", c.foot, "File with the last lines of the list.").file();
}
void describe(Describer& d, UpperConfig& c) {
  d.option("reverse", c.reverse, "Whether lines are reversed.");
  d.option("word", c.word, "A word added to the end.");
}
void describe(Describer& d, JoinConfig& c) {
  d.option("separator", c.separator, "Line between the parts.");
  d.option("weights", c.weights, "Figures written behind the parts.").range(0, 10);
}

namespace {

void fail_as_told(const std::string& how) {
  if (how == "input")
    throw Error(ErrorKind::SfmFailed, "9 of 52 images have poses",
                {.where = "photos", .why = "no texture", .hint = "more photos", .code = "SFM_TOO_FEW"});
  if (how == "memory") throw std::bad_alloc();
  if (how == "exception") throw std::runtime_error("something odd");
  if (how == "check") VITRINE_CHECK(how.empty(), "told to fail by {}", how);
  if (how == "crash") std::raise(SIGKILL);
}

void run_collect(const CollectConfig& c, StageContext& context) {
  std::vector<std::string> names;
  const fs::path photos = context.input("photos");
  for (const auto& e : fs::directory_iterator(photos))
    if (e.is_regular_file()) names.push_back(e.path().filename().string());
  std::sort(names.begin(), names.end());
  if (names.empty())
    throw Error(ErrorKind::Input, "no photos in the folder",
                {.where = photos.string(), .hint = "put some in", .code = "NO_PHOTOS"});
  const fs::path checkpoint = context.scratch() / "checkpoint.txt";
  std::string text = c.label + "\n";
  int step = 0;
  if (fs::exists(checkpoint)) {
    const std::string saved = read_file(checkpoint);
    step = std::stoi(saved);
    text = saved.substr(saved.find('\n') + 1);
    log_info("continuing at step {}", step);
  }
  if (const auto notes = context.optional_input("notes"); notes && step == 0) text += read_file(*notes);
  if (c.warn)
    context.warning("LONG", "what the stage has to say is long enough to need a second line on a console of eighty columns");
  std::vector<char> held;
  for (; step < c.repeat; ++step) {
    for (const std::string& name : names) text += fmt::format("{} {}\n", name, fs::file_size(photos / name));
    if (step == c.repeat / 2) fail_as_told(c.fail);
    if (step == c.repeat / 2) held.assign(size_t(c.memory_mb) << 20, 'x');
    context.progress({.fraction = double(step + 1) / c.repeat,
                      .text = fmt::format("step {}/{}", step + 1, c.repeat),
                      .values = {{"step", step}}});
    if (c.step_ms > 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(c.step_ms));
      write_file(checkpoint, fmt::format("{}\n{}", step + 1, text));
      context.checkpoint(double(step + 1) / c.repeat);
    }
    throw_if_interrupted();
  }
  if (!c.foot.empty()) text += read_file(c.foot);
  write_file(context.output() / "collect/list.txt", text);
  for (const std::string& name : names) write_file(context.output() / "names" / (name + ".txt"), name);
  context.metric("files", static_cast<double>(names.size()));
  context.timing("listing", 0.25);
  if (names.size() < 2) context.warning("FEW_FILES", "only one file");
  context.summary(fmt::format("{} files", names.size()));
}

void run_upper(const UpperConfig& c, StageContext& context) {
  std::string text = read_file(context.input("collect") / "collect/list.txt");
  for (char& ch : text) ch = static_cast<char>(std::toupper(static_cast<unsigned char>(ch)));
  if (c.reverse) std::reverse(text.begin(), text.end());
  write_file(context.output() / "upper/list.txt", text + c.word);
  context.metric("bytes", static_cast<double>(text.size()));
  context.summary(fmt::format("{} bytes", text.size()));
}

void run_join(const JoinConfig& c, StageContext& context) {
  std::string text = read_file(context.input("collect") / "collect/list.txt") + c.separator +
                     read_file(context.input("upper") / "upper/list.txt");
  for (double w : c.weights) text += fmt::format("{}\n", w);
  write_file(context.output() / "join/joined.txt", text);
  context.summary(fmt::format("{} bytes", text.size()));
}

std::string numerics = "cpu-1";

std::string choose_device(Device device) {
  numerics = device == Device::Cuda ? "cuda-1" : "cpu-1";
  return device == Device::Auto ? "the slot is empty" : "";
}

std::string collect_problem(const CollectConfig& c) {
  return c.label == "forbidden" ? "collect.label must not be \"forbidden\": the list would be misread" : "";
}

}  // namespace

Stage collect_stage() {
  return make_stage<CollectConfig>(
      {.name = "collect",
       .version = 2,
       .summary = "Lists the files of a folder.",
       .inputs = {{.name = "photos", .artifact = false, .doc = "Folder of files."},
                  {.name = "notes", .artifact = false, .optional = true, .doc = "Text put first.", .skips = {".yaml", ".yml"}}}},
      run_collect,
      [] {
        return std::map<std::string, std::string>{{"lister", "1.0"}};
      },
      collect_problem);
}
Stage upper_stage() {
  return make_stage<UpperConfig>({.name = "upper",
                                  .version = 1,
                                  .summary = "Capital letters.",
                                  .inputs = {{.name = "collect", .doc = "The list."}},
                                  .device = {choose_device, [] { return true; }}},
                                 run_upper, [] {
                                   return std::map<std::string, std::string>{{"numerics", numerics}};
                                 });
}
Stage join_stage() {
  return make_stage<JoinConfig>(
      {.name = "join",
       .version = 1,
       .summary = "Both lists.",
       .inputs = {{.name = "collect", .doc = "The list."}, {.name = "upper", .doc = "The list in capitals."}}},
      run_join);
}

}  // namespace vitrine::test_stages
