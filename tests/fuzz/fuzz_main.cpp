// vitrine-fuzz FORMAT [--runs N] [--seed S] [--first I] [--seconds T] [--keep FILE]   one format (or "all"), many damaged inputs
// vitrine-fuzz FORMAT FILE...                                                         these inputs, as they are
#include <cstdlib>
#include <cstring>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/timer.h"
#include "tests/fuzz/mutate.h"

namespace {

int run(const std::vector<std::string>& words) {
  using namespace vitrine;
  if (words.empty() || words[0].starts_with("-")) {
    fmt::print(
        "vitrine-fuzz FORMAT|all [--runs N] [--seed S] [--first I] [--seconds T] [--keep FILE]\nvitrine-fuzz FORMAT FILE...\n");
    return words.empty() ? 2 : 0;
  }
  FuzzDesc desc;
  std::vector<std::string> files;
  for (size_t i = 1; i < words.size(); ++i) {
    const auto value = [&] { return i + 1 < words.size() ? words[++i] : std::string(); };
    if (words[i] == "--runs")
      desc.runs = std::strtoull(value().c_str(), nullptr, 10);
    else if (words[i] == "--seed")
      desc.seed = std::strtoull(value().c_str(), nullptr, 10);
    else if (words[i] == "--first")
      desc.first = std::strtoull(value().c_str(), nullptr, 10);
    else if (words[i] == "--seconds")
      desc.seconds = std::strtod(value().c_str(), nullptr);
    else if (words[i] == "--keep")
      desc.keep = value();
    else
      files.push_back(words[i]);
  }
  for (const std::string& file : files) {
    const std::string bytes = read_file(file);
    fuzz_format(words[0]).entry({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
  }
  if (!files.empty()) return 0;
  for (const FuzzFormat& format : fuzz_formats()) {
    if (words[0] != "all" && fuzz_format(words[0]).name != format.name) continue;
    const Timer clock;
    const uint64_t tried = fuzz(format, desc);
    fmt::print("{:<14} {:>9} inputs in {:6.1f} s, all read or refused\n", format.name, tried, clock.seconds());
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run({argv + 1, argv + argc});
  } catch (const vitrine::Error& e) {
    fmt::print(stderr, "error: {}\n", e.what());
    return vitrine::exit_code(e.kind());
  } catch (const std::exception& e) {
    fmt::print(stderr, "error: a parser raised something else than Error: {}\n", e.what());
    return 1;
  }
}
