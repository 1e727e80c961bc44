// vitrine-results: records a finished run as tests/results/NAME.json, and writes the table of README.md from these files.
#include <exception>
#include <fstream>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include "core/foundation/base/file.h"
#include "tests/results/results.h"

namespace {

using namespace vitrine;

constexpr const char* kUsage =
    "usage: vitrine-results record RUN NAME TITLE COMMIT   the run's folder -> tests/results/NAME.json; on the machine of the "
    "run\n"
    "       vitrine-results table                          tests/results/*.json -> the table of README.md\n";

const fs::path kTree = VITRINE_SOURCE_DIR;

std::string cpu_name() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown";
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  try {
    if (words.size() == 5 && words[0] == "record") {
      const RunLabel label{words[3], words[4], cpu_name(), static_cast<int>(std::thread::hardware_concurrency())};
      write_file(kTree / "tests/results" / (words[2] + ".json"), recorded_run(words[1], label));
    } else if (words.size() == 1 && words[0] == "table") {
      write_file(kTree / "README.md", with_table(read_file(kTree / "README.md"), results_table(kTree / "tests/results")));
    } else {
      std::cerr << kUsage;
      return 2;
    }
  } catch (const std::exception& e) {
    std::cerr << "error: " << e.what() << "\n";
    return 1;
  }
}
