// vitrine-bench [--compare=baseline.json] [--slower=1.15] [google-benchmark flags]
// Rows come from the bench_<area>.cpp beside this file; each checks its result before it is timed and is an error otherwise.
// --benchmark_out=new.json writes rows as JSON; --compare reads such a file, prints CPU time against it row by row and fails
// when a row is slower by more than the given factor or no longer runs.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/base/json.h"

namespace {

// Version 1.8 of the library replaced the flag by a state, of which 0 is "not skipped".
bool is_error(const auto& run) {
  if constexpr (requires { run.error_occurred; })
    return run.error_occurred;
  else
    return run.skipped != decltype(run.skipped){};
}

// Forwards to the console and remembers CPU nanoseconds per iteration.
class RememberingReporter : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (is_error(run))
        failed_.push_back(run.benchmark_name());
      else if (run.run_type == Run::RT_Iteration && run.iterations > 0)
        cpu_ns_[run.benchmark_name()] = run.cpu_accumulated_time * 1e9 / double(run.iterations);
    }
    ConsoleReporter::ReportRuns(runs);
  }
  const std::map<std::string, double>& cpu_ns() const { return cpu_ns_; }
  const std::vector<std::string>& failed() const { return failed_; }

 private:
  std::map<std::string, double> cpu_ns_;
  std::vector<std::string> failed_;
};

double nanoseconds(const nlohmann::json& row) {
  const std::string unit = row.value("time_unit", "ns");
  const double factor = unit == "s" ? 1e9 : unit == "ms" ? 1e6 : unit == "us" ? 1e3 : 1;
  return row.at("cpu_time").get<double>() * factor;
}

// Number of rows that are too slow.
int compare(const std::string& path, double slower, const std::map<std::string, double>& now) {
  std::ifstream in(path);
  if (!in) {
    std::cerr << "cannot read the baseline " << path << "\n";
    return 1;
  }
  int worse = 0;
  std::printf("\n%-60s %12s %12s %7s\n", "against the baseline (CPU time)", "baseline ms", "now ms", "ratio");
  const nlohmann::json baseline = nlohmann::json::parse(in);
  for (const auto& row : baseline.at("benchmarks")) {
    if (row.value("error_occurred", false) || row.value("run_type", "iteration") != "iteration") continue;
    const auto it = now.find(row.at("name").get<std::string>());
    if (it == now.end()) continue;
    const double before = nanoseconds(row), ratio = it->second / before;
    worse += ratio > slower;
    std::printf("%-60s %12.3f %12.3f %6.2fx%s\n", it->first.c_str(), before * 1e-6, it->second * 1e-6, ratio,
                ratio > slower ? "  SLOWER" : "");
  }
  return worse;
}

}  // namespace

int main(int argc, char** argv) {
  std::string baseline;
  double slower = 1.15;
  std::vector<char*> rest;
  for (int i = 0; i < argc; ++i) {
    const std::string_view arg = argv[i];
    if (arg.starts_with("--compare="))
      baseline = arg.substr(10);
    else if (arg == "--compare" && i + 1 < argc)
      baseline = argv[++i];
    else if (arg.starts_with("--slower="))
      slower = std::stod(std::string(arg.substr(9)));
    else
      rest.push_back(argv[i]);
  }
  int count = static_cast<int>(rest.size());
  benchmark::Initialize(&count, rest.data());
  if (benchmark::ReportUnrecognizedArguments(count, rest.data())) return 2;
  RememberingReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  for (const std::string& name : reporter.failed()) std::cerr << "failed: " << name << "\n";
  const int worse = baseline.empty() ? 0 : compare(baseline, slower, reporter.cpu_ns());
  return reporter.failed().empty() && worse == 0 ? 0 : 1;
}
