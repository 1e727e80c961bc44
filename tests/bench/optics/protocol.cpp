#include "tests/bench/optics/protocol.h"

#include <atomic>
#include <mutex>
#include <optional>
#include <thread>

#include "core/foundation/base/error.h"
#include "core/foundation/base/process.h"

namespace vitrine {
namespace {

using nlohmann::json;

constexpr const char* kRunFormat = "vitrine-optics-run 1";
constexpr size_t kConflictsShown = 3;

json record_of(const OpticsRun& run) {
  return {{"format", kRunFormat},
          {"scene", run.scene},
          {"arm", run.arm},
          {"training_seed", run.training_seed},
          {"training", run.training}};
}

// nullopt: not there yet.
std::optional<json> kept_record(const fs::path& file) {
  if (!fs::exists(file)) return std::nullopt;
  json record = json::parse(read_file(file), nullptr, false);
  if (!record.is_object() || record.value("format", "") != kRunFormat || !record.contains("training"))
    throw Error(ErrorKind::Input, "this is no record of a run",
                {.where = file.string(), .hint = "remove the file: the run is done again", .code = "BAD_RECORD"});
  return record;
}

std::string word_of(const json& value) {
  return value.is_null() ? "not given" : value.is_string() ? value.get<std::string>() : value.dump();
}

// "optimize.iterations: 1000, now 500; ..."
std::string differences(const json& before, const json& now) {
  const json a = before.flatten(), b = now.flatten();
  std::vector<std::string> all;
  const auto add = [&](const std::string& key, const json& was, const json& is) {
    if (was != is) all.push_back(fmt::format("{}: {}, now {}", key.substr(1), word_of(was), word_of(is)));
  };
  for (const auto& [key, value] : b.items()) add(key, a.value(key, json()), value);
  for (const auto& [key, value] : a.items())
    if (!b.contains(key)) add(key, value, json());
  return fmt::format("{}", fmt::join(all, "; "));
}

void refuse_other_settings(const std::vector<OpticsRun>& runs, const fs::path& work) {
  std::string where, why;
  size_t conflicts = 0;
  for (const OpticsRun& run : runs) {
    const auto record = kept_record(file_of_run(work, run));
    if (!record || record->at("training") == run.training) continue;
    if (++conflicts == 1) {
      where = file_of_run(work, run).string();
      why = differences(record->at("training"), run.training);
    } else if (conflicts <= kConflictsShown) {
      where += "\n         " + file_of_run(work, run).string();
    }
  }
  if (conflicts == 0) return;
  throw Error(ErrorKind::Usage,
              fmt::format("{} of {} runs there were trained with other settings or programs: one table cannot hold both",
                          conflicts, runs.size()),
              {.where = where,
               .why = why,
               .hint = "another --work, or remove these files: then the runs are done again",
               .code = "OTHER_SETTINGS"});
}

std::string line_of(const Figures& figures) {
  std::string line;
  for (const FigureKind& kind : figure_kinds())
    if (const auto it = figures.find(kind.name); it != figures.end() && kind.column)
      line += fmt::format("{}{} {:.{}f}", line.empty() ? "" : ", ", kind.title, it->second, kind.digits);
  return line;
}

Figures done_run(const OpticsRun& run, const fs::path& work, const OpticsWork& what, bool& anything_done) {
  const fs::path file = file_of_run(work, run);
  json record = kept_record(file).value_or(record_of(run));
  anything_done = !record.contains("figures") || record.value("measuring", json()) != run.measuring;
  if (!anything_done) return record.at("figures").get<Figures>();
  make_folders(file.parent_path());
  if (!record.contains("trained")) {
    record["trained"] = what.train(run);
    write_file(file, record.dump(1) + "\n");
  }
  Figures figures = what.measure(run, record["trained"]);
  if (const json& cpu = record["trained"].value(kCpuFigure, json()); cpu.is_number()) figures[kCpuFigure] = cpu.get<double>();
  record["measuring"] = run.measuring;
  record["figures"] = figures;
  write_file(file, record.dump(1) + "\n");
  return figures;
}

bool stops_all(const Error& e) {
  return e.kind() == ErrorKind::Interrupted || e.kind() == ErrorKind::Preempted || e.kind() == ErrorKind::Terminated;
}

}  // namespace

std::string OpticsRun::name() const { return fmt::format("{} {} seed {}", scene, arm, training_seed); }

fs::path folder_of_run(const fs::path& work, const OpticsRun& run) {
  return work / "runs" / run.scene / run.arm / fmt::format("seed_{}", run.training_seed);
}

fs::path file_of_run(const fs::path& work, const OpticsRun& run) { return folder_of_run(work, run).string() + ".json"; }

OpticsOutcome run_optics(const std::vector<OpticsRun>& runs, const fs::path& work, int jobs, const OpticsWork& what,
                         const std::function<void(const std::string&)>& say) {
  refuse_other_settings(runs, work);
  std::vector<std::optional<Figures>> figures(runs.size());
  std::vector<std::string> failures(runs.size());
  std::optional<Error> stopped;
  std::mutex mutex;
  std::atomic<size_t> next = 0;
  const auto worker = [&] {
    for (size_t i; (i = next++) < runs.size();) {
      const std::string title = fmt::format("[{}/{}] {}", i + 1, runs.size(), runs[i].name());
      try {
        throw_if_interrupted();
        bool anything_done = false;
        Figures mine = done_run(runs[i], work, what, anything_done);
        const std::scoped_lock lock(mutex);
        say(fmt::format("{}: {}{}", title, line_of(mine), anything_done ? "" : "  (kept)"));
        figures[i] = std::move(mine);
      } catch (const Error& e) {
        const std::scoped_lock lock(mutex);
        if (stops_all(e)) {
          stopped = e;
          next = runs.size();
          return;
        }
        failures[i] = fmt::format("{}: {}", runs[i].name(), e.what());
        say(fmt::format("{}: failed: {}", title, e.message()));
      } catch (const std::exception& e) {
        const std::scoped_lock lock(mutex);
        failures[i] = fmt::format("{}: {}", runs[i].name(), e.what());
        say(fmt::format("{}: failed: {}", title, e.what()));
      }
    }
  };
  std::vector<std::thread> threads;
  for (int j = 1; j < jobs; ++j) threads.emplace_back(worker);
  worker();
  for (std::thread& t : threads) t.join();
  if (stopped) throw Error(*stopped);
  OpticsOutcome outcome;
  for (size_t i = 0; i < runs.size(); ++i) {
    if (figures[i]) outcome.results.push_back({runs[i].scene, runs[i].arm, runs[i].training_seed, std::move(*figures[i])});
    if (!failures[i].empty()) outcome.failures.push_back(std::move(failures[i]));
  }
  return outcome;
}

}  // namespace vitrine
