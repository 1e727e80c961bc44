// Runs a stage: command line, key, cache hit, lock, temporary folder, commit, reports, and the single catch block.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <new>
#include <thread>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/artifact/store.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/folder_files.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/base/terminal.h"
#include "core/foundation/base/timer.h"
#include "core/foundation/config/text.h"
#include "stages/reporter.h"
#include "stages/stage.h"
#include "stages/stage_cli.h"

namespace vitrine {

using json = nlohmann::ordered_json;

namespace {

// A file that an option names counts by its content, as inputs do; one that is missing is reported by the stage itself.
std::string key_value(const Option& option, DigestCache& digests) {
  if (option.names_file) {
    const fs::path file = *std::get<std::string*>(option.target);
    std::error_code ec;
    if (fs::is_regular_file(file, ec)) return digests.digest(fs::absolute(file));
  }
  return canonical_value(option);
}

KeyTerms key_terms(const Stage& stage, const std::map<std::string, ResolvedInput>& inputs, DigestCache& digests) {
  KeyTerms terms = {{"stage", stage.info.name}, {"version", std::to_string(stage.info.version)}};
  for (const Option& o : stage.options.options)
    if (o.affects_result) terms["option." + o.path] = key_value(o, digests);
  for (const auto& [name, input] : inputs) terms["input." + name] = input.content_digest;
  if (stage.fingerprints)
    for (const auto& [name, value] : stage.fingerprints()) terms["tool." + name] = value;
  return terms;
}

// Locks a key for one process: a second one would write into the same scratch folder. The system releases the lock when the
// process ends.
class ScratchLock {
 public:
  ScratchLock(const fs::path& scratch, const std::string& stage) {
    // A stage whose pipeline was killed needs a moment to stop.
    constexpr int kTries = 150;
    constexpr auto kPause = std::chrono::milliseconds(200);
    make_folders(scratch);
    const fs::path file = scratch / ".lock";
    fd_ = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (fd_ < 0) throw_write_error(file, errno);
    for (int i = 0; i < kTries; ++i) {
      if (flock(fd_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
      if (i == 0) log_info("waiting for another vitrine-{} that works on the same key", stage);
      throw_if_interrupted();
      std::this_thread::sleep_for(kPause);
    }
    close(fd_);
    throw Error(
        ErrorKind::Locked, fmt::format("another vitrine-{} works on the same key", stage),
        {.where = scratch.string(), .hint = "wait for it, or stop it, then run the same command again", .code = "LOCKED"});
  }
  ~ScratchLock() { close(fd_); }
  ScratchLock(const ScratchLock&) = delete;
  ScratchLock& operator=(const ScratchLock&) = delete;

 private:
  int fd_ = -1;
};

class Run : public StageContext {
 public:
  Run(Stage& stage, const StageArguments& arguments, Reporter& reporter)
      : stage_(stage), arguments_(arguments), reporter_(reporter) {}

  int execute() {
    apply_stage_config(arguments_, stage_.info, stage_.options);
    if (const std::string problem = stage_.problem ? stage_.problem() : std::string(); !problem.empty())
      throw Error(ErrorKind::Usage, problem,
                  {.where = "options of stage '" + stage_.info.name + "'",
                   .hint = fmt::format("vitrine-{} --help", stage_.info.name),
                   .code = "USAGE"});
    if (!arguments_.max_memory.empty()) max_memory_ = parse_bytes(arguments_.max_memory, machine_memory_bytes(), "--max-memory");
    set_thread_limit(arguments_.threads);
    choose_device();
    if (arguments_.output.empty() && arguments_.store.empty())
      throw Error(ErrorKind::Usage, "no place for the result", {.hint = "--output DIR", .code = "USAGE"});
    const fs::path root =
        fs::absolute(arguments_.store.empty() ? fs::path(arguments_.output) / ".cache" : fs::path(arguments_.store));
    ArtifactStore store(root.lexically_normal());
    inputs_ = resolve_inputs(stage_.info, arguments_.inputs, store.digests());
    keep_apart();
    fit_into_memory();
    manifest_.stage = stage_.info.name;
    manifest_.version = stage_.info.version;
    manifest_.tool_version = VITRINE_VERSION;
    manifest_.terms = key_terms(stage_, inputs_, store.digests());
    manifest_.key = key_of(manifest_.terms);
    for (const Option& o : stage_.options.options) manifest_.options.push_back({o.path, o.text(), o.origin});
    if (arguments_.print_key) {
      std::cout << json{{"key", manifest_.key}, {"terms", manifest_.terms}}.dump(1) << "\n";
      return 0;
    }
    if (!arguments_.force && reuse(store)) return 0;
    compute(store);
    return 0;
  }

  fs::path input(std::string_view name) const override {
    const auto found = optional_input(name);
    if (!found)
      throw Error(ErrorKind::Usage, fmt::format("stage '{}' needs the input '{}'", stage_.info.name, name),
                  {.hint = fmt::format("--input {}=PATH", name), .code = "MISSING_INPUT"});
    return *found;
  }
  std::optional<fs::path> optional_input(std::string_view name) const override {
    const auto found = inputs_.find(std::string(name));
    return found == inputs_.end() ? std::nullopt : std::optional<fs::path>(found->second.path);
  }
  const fs::path& output() const override { return output_; }
  const fs::path& scratch() const override { return scratch_; }
  int threads() const override { return thread_limit(); }
  size_t max_memory_bytes() const override { return max_memory_; }
  void progress(const Progress& p) override { reporter_.progress(p); }
  void metric(std::string_view name, double value) override {
    manifest_.metrics[std::string(name)] = value;
    reporter_.record("metric", {{"name", name}, {"value", value}});
  }
  void warning(std::string_view code, std::string_view text) override {
    manifest_.warnings.push_back({std::string(code), std::string(text)});
    reporter_.record("warning", {{"code", code}, {"text", text}});
    if (!reporter_.json_console) log_warning("warning: {}", text);
  }
  void checkpoint(double fraction) override { reporter_.record("checkpoint", {{"fraction", fraction}}); }
  void summary(std::string_view text) override { manifest_.summary = std::string(text); }
  void timing(std::string_view name, double seconds) override {
    timings_[std::string(name)] = seconds;
    reporter_.record("timing", {{"name", name}, {"seconds", seconds}});
    log_debug("{}: {}", name, duration_text(seconds));
  }

 private:
  // Results inside the photo folder would be read as photos by the next run.
  void keep_apart() const {
    for (const StageInput& input : stage_.info.inputs) {
      const auto given = inputs_.find(input.name);
      std::error_code ec;
      if (input.artifact || given == inputs_.end() || !fs::is_directory(given->second.path, ec)) continue;
      for (const std::string& place : {arguments_.output, arguments_.store})
        if (!place.empty() && lies_in(place, given->second.path))
          throw Error(ErrorKind::Usage, fmt::format("the output folder lies inside the folder of {}", input.name),
                      {.where = fs::absolute(place).string(), .hint = "choose another one with --output", .code = "USAGE"});
    }
  }

  // Before the key, which has the numerics of the device.
  void choose_device() const {
    if (stage_.info.device.choose == nullptr) return;
    const auto word = std::ranges::find(kDeviceWords, arguments_.device);
    const std::string why_cpu = stage_.info.device.choose(static_cast<Device>(word - kDeviceWords.begin()));
    if (!why_cpu.empty() && !arguments_.print_key && !reporter_.json_console)
      log_info("note: --device auto takes the CPU: {}", why_cpu);
  }

  void fit_into_memory() {
    if (max_memory_ == 0 || !stage_.fit) return;
    InputPaths paths;
    for (const auto& [name, input] : inputs_) paths[name] = input.path;
    fitted_ = stage_.fit(stage_, max_memory_, paths);
    for (const FittedOption& f : fitted_) {
      Option* option = stage_.options.find(f.path);
      VITRINE_CHECK(option != nullptr, "stage '{}' fits an option '{}' that it does not have", stage_.info.name, f.path);
      option->assign(f.value, "--max-memory");
    }
  }

  // Reuses a finished artifact of the same key if all its files are intact.
  bool reuse(ArtifactStore& store) {
    const fs::path entry = store.entry(stage_.info.name, manifest_.key);
    if (!fs::exists(entry / kManifestName)) return false;
    if (const std::string damage = store.damage(entry); !damage.empty()) {
      log_warning("warning: the stored result of '{}' is damaged ({}): computed anew", stage_.info.name, damage);
      return false;
    }
    finish(entry, *store.find(stage_.info.name, manifest_.key), true);
    return true;
  }

  void compute(ArtifactStore& store) {
    store.sweep(stage_.info.name);
    scratch_ = store.scratch(stage_.info.name, manifest_.key);
    const ScratchLock lock(scratch_, stage_.info.name);
    const std::optional<Manifest> before = earlier(store);
    PendingArtifact pending(store, stage_.info.name, manifest_.key);
    output_ = pending.path();
    reporter_.record("stage_start", {{"key", manifest_.key}});
    const std::string started = utc_time_text();
    for (const FittedOption& f : fitted_) warning(f.code, f.text);
    {
      const MemoryWatch watch(max_memory_, stage_.info.name);
      stage_.run(*this);
    }
    reporter_.finish_progress();
    const json timing = {{"started", started},       {"seconds", clock_.seconds()}, {"cpu_seconds", cpu()},
                         {"peak_rss_bytes", peak()}, {"threads", thread_limit()},   {"parts", timings_}};
    const fs::path entry = pending.commit(manifest_, timing.dump(1) + "\n");
    if (before && before->content_digest != manifest_.content_digest)
      log_warning("warning: '{}' gave other bytes than before for the same key: it is not reproducible", stage_.info.name);
    std::error_code ignored;
    fs::remove_all(scratch_, ignored);
    finish(entry, manifest_, false);
  }

  std::optional<Manifest> earlier(ArtifactStore& store) const {
    if (!store.damage(store.entry(stage_.info.name, manifest_.key)).empty()) return std::nullopt;
    return store.find(stage_.info.name, manifest_.key);
  }

  void finish(const fs::path& entry, const Manifest& m, bool cached) {
    if (!arguments_.output.empty()) publish(entry, m, arguments_.output);
    reporter_.record("artifact", {{"path", entry.string()}, {"content_digest", m.content_digest}});
    reporter_.record("stage_end", {{"ok", true},
                                   {"cached", cached},
                                   {"key", m.key},
                                   {"content_digest", m.content_digest},
                                   {"seconds", clock_.seconds()},
                                   {"cpu_seconds", cpu()},
                                   {"peak_rss_bytes", peak()},
                                   {"summary", m.summary},
                                   {"metrics", m.metrics}});
    if (!reporter_.json_console)
      log_info("{:<10} {}  {}  {}", m.stage, m.summary, cached ? "up to date" : duration_text(clock_.seconds()),
               m.key.substr(0, 12));
  }

  double cpu() const { return cpu_seconds() + cpu_seconds(RUSAGE_CHILDREN); }
  size_t peak() const { return std::max(peak_memory_bytes(), peak_memory_bytes(RUSAGE_CHILDREN)); }

  Stage& stage_;
  const StageArguments& arguments_;
  Reporter& reporter_;
  Timer clock_;
  std::map<std::string, ResolvedInput> inputs_;
  Manifest manifest_;
  std::map<std::string, double> timings_;
  fs::path output_, scratch_;
  size_t max_memory_ = 0;
  std::vector<FittedOption> fitted_;
};

int failed(Reporter& reporter, const Error& e) {
  reporter.error(e);
  return exit_code(e.kind());
}

Error out_of_memory(const std::string& stage, std::string why) {
  return {ErrorKind::Resource,
          fmt::format("out of memory in stage '{}'", stage),
          {.why = std::move(why), .hint = less_memory_hint(stage), .code = "OUT_OF_MEMORY"}};
}

Error internal_error(const std::string& stage, const std::exception& e) {
  return {ErrorKind::Internal,
          fmt::format("internal error in stage '{}': {}", stage, e.what()),
          {.hint = "this is a bug in vitrine: please report it with run.json", .code = "INTERNAL"}};
}

// The pipeline passes its process id: when it is killed, the stage stops with a checkpoint.
void stop_with_parent() {
  const char* parent = std::getenv("VITRINE_PARENT_PID");
  if (parent == nullptr) return;
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (std::to_string(getppid()) != parent) raise(SIGTERM);  // the parent died before prctl
}

}  // namespace

int stage_main(Stage stage, int argc, char** argv) {
  Reporter reporter(stage.info.name);
  try {
    install_interrupt_handlers();
    stop_with_parent();
    const StageArguments arguments = parse_stage_arguments(stage.info, std::vector<std::string>(argv + 1, argv + argc));
    reporter.json_console = arguments.log_format == "json";
    reporter.show_progress = !arguments.no_progress && !arguments.quiet;
    set_log_console(arguments.quiet ? LogLevel::Warning : arguments.verbose ? LogLevel::Debug : LogLevel::Info, colour_wanted(2));
    if (arguments.help) std::cout << stage_help(stage.info, stage.options);
    if (arguments.describe) std::cout << stage_description(stage.info, stage.options) << "\n";
    if (arguments.version)
      std::cout << fmt::format("vitrine-{} {} (stage version {})\n", stage.info.name, VITRINE_VERSION, stage.info.version);
    if (!arguments.cost.empty()) std::cout << stage_cost_answer(stage.info, arguments.cost) << "\n";
    if (arguments.help || arguments.describe || arguments.version || !arguments.cost.empty()) return 0;
    require_current_folder();
    if (!arguments.log_file.empty()) {
      make_folders(fs::path(arguments.log_file).parent_path());
      set_log_file(arguments.log_file);
    }
    if (!arguments.events.empty()) reporter.write_events_to(arguments.events);
    return Run(stage, arguments, reporter).execute();
  } catch (const Error& e) {
    return failed(reporter, e);
  } catch (const std::bad_alloc&) {
    return failed(reporter, out_of_memory(stage.info.name, "the system gave no more memory"));
  } catch (const fs::filesystem_error& e) {
    return failed(reporter, error_of_file_system(e));
  } catch (const std::system_error& e) {
    if (e.code() == std::errc::resource_unavailable_try_again || e.code() == std::errc::not_enough_memory)
      return failed(reporter, out_of_memory(stage.info.name, "the system gave no memory for another thread"));
    return failed(reporter, internal_error(stage.info.name, e));
  } catch (const std::exception& e) {
    return failed(reporter, internal_error(stage.info.name, e));
  }
}

}  // namespace vitrine
