// Every Error that the sources throw, read from the sources: what a user may meet has a code for programs, a place or a cause,
// and what to try next. Bugs of ours (Internal) say to report them; a wrong word on the command line is its own place.
#include <gtest/gtest.h>

#include <regex>
#include <set>

#include <fmt/format.h>

#include "core/foundation/base/file.h"

namespace vitrine {
namespace {

const fs::path kSources = VITRINE_SOURCE_DIR;

struct Thrown {
  std::string place, kind, text;  // text: from the bracket that opens to the one that closes
};

// The end of the bracket that opens at `begin`; strings are skipped.
size_t closing(const std::string& source, size_t begin) {
  int depth = 0;
  bool quoted = false;
  for (size_t i = begin; i < source.size(); ++i) {
    if (quoted) {
      if (source[i] == '\\')
        ++i;
      else if (source[i] == '"')
        quoted = false;
    } else if (source[i] == '"') {
      quoted = true;
    } else if (source[i] == '(') {
      ++depth;
    } else if (source[i] == ')' && --depth == 0) {
      return i;
    }
  }
  return source.size();
}

std::vector<Thrown> errors_of_the_sources() {
  std::vector<Thrown> all;
  for (const char* folder : {"core", "stages", "pipeline"})
    for (const auto& e : fs::recursive_directory_iterator(kSources / folder)) {
      const std::string extension = e.path().extension().string();
      if (!e.is_regular_file() || (extension != ".h" && extension != ".cpp")) continue;
      const std::string source = read_file(e.path());
      static const std::regex kBegin("\\bError\\(\\s*(?:[^()\";{}]*\\? )?ErrorKind::(\\w+)");
      for (auto it = std::sregex_iterator(source.begin(), source.end(), kBegin); it != std::sregex_iterator(); ++it) {
        const auto at = size_t(it->position());
        const size_t open = source.find('(', at), close = closing(source, open);
        const auto line = 1 + std::count(source.begin(), source.begin() + long(at), '\n');
        all.push_back({fmt::format("{}:{}", e.path().lexically_relative(kSources).string(), line), (*it)[1],
                       source.substr(open, close - open)});
      }
    }
  return all;
}

TEST(Errors, SayWhereOrWhyAndWhatToTry) {
  const std::vector<Thrown> all = errors_of_the_sources();
  EXPECT_GT(all.size(), 150u) << "the pattern finds them";
  for (const Thrown& e : all) {
    if (e.kind == "Internal") continue;
    if (e.text.find(", detail") != std::string::npos) continue;  // put together above the throw (core/foundation/base/file.cpp)
    const auto has = [&](const char* field) { return e.text.find(fmt::format(".{} =", field)) != std::string::npos; };
    EXPECT_TRUE(has("code")) << e.place << " has no code: " << e.text;
    EXPECT_TRUE(has("hint")) << e.place << " does not say what to try: " << e.text;
    const bool stopped = e.kind == "Interrupted" || e.kind == "Preempted";
    EXPECT_TRUE(has("where") || has("why") || e.kind == "Usage" || stopped)
        << e.place << " has neither place nor cause: " << e.text;
  }
}

TEST(Errors, HaveCodesThatProgramsCanRelyOn) {
  static const std::regex kCode("\\.code = \"([^\"]*)\"");
  for (const Thrown& e : errors_of_the_sources())
    for (auto it = std::sregex_iterator(e.text.begin(), e.text.end(), kCode); it != std::sregex_iterator(); ++it)
      EXPECT_TRUE(std::regex_match((*it)[1].str(), std::regex("[A-Z][A-Z0-9_]+"))) << e.place << ": " << (*it)[1];
}

}  // namespace
}  // namespace vitrine
