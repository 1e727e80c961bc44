// Every #include of the sources against the edges that core/*/*/CMakeLists.txt declare (vitrine_module(... DEPENDS ...)): a core
// module includes itself and what it depends on, and no wing above its own; a stage includes core and itself, never another
// stage; the pipeline includes core and itself; core includes neither stages nor the pipeline.
#include <algorithm>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

#include "core/foundation/base/file.h"

namespace vitrine {
namespace {

const fs::path kRoot = VITRINE_SOURCE_DIR;

// Words behind DEPENDS in a call of vitrine_module, closed over dependencies of dependencies.
std::map<std::string, std::set<std::string>> declared_edges() {
  std::map<std::string, std::set<std::string>> edges;
  for (const auto& e : fs::recursive_directory_iterator(kRoot / "core")) {
    if (!e.is_directory() || !fs::exists(e.path() / "CMakeLists.txt")) continue;
    const std::string text = std::regex_replace(read_file(e.path() / "CMakeLists.txt"), std::regex("#[^\n]*"), "");
    std::smatch call;
    if (!std::regex_search(text, call, std::regex("vitrine_module\\(\\s*(\\w+)([^)]*)\\)"))) continue;
    std::set<std::string>& to = edges[call[1]];
    std::istringstream words(call[2].str());
    bool inside = false;
    for (std::string word; words >> word;) {
      if (word == "DEPENDS")
        inside = true;
      else if (word == "LIBRARIES" || word == "PRIVATE" || word == "SUBFOLDERS")
        inside = false;
      else if (inside)
        to.insert(word);
    }
  }
  for (size_t round = 0; round < edges.size(); ++round)
    for (auto& [module, to] : edges) {
      const std::set<std::string> direct = to;
      for (const std::string& d : direct) to.insert(edges[d].begin(), edges[d].end());
    }
  return edges;
}

struct Include {
  fs::path file;
  int line;
  std::string target;
};

std::vector<Include> includes_below(const fs::path& folder) {
  std::vector<Include> found;
  for (const auto& e : fs::recursive_directory_iterator(folder)) {
    const std::string extension = e.path().extension().string();
    if (!e.is_regular_file() || (extension != ".h" && extension != ".cpp")) continue;
    std::ifstream in(e.path());
    int number = 0;
    for (std::string line; std::getline(in, line);) {
      ++number;
      if (line.find("include") == std::string::npos) continue;
      std::smatch m;
      if (std::regex_search(line, m, std::regex("^\\s*#\\s*include\\s*[\"<]([^\">]+)[\">]")))
        found.push_back({fs::relative(e.path(), kRoot), number, m[1]});
    }
  }
  return found;
}

std::vector<std::string> parts(const std::string& path) {
  std::vector<std::string> out;
  for (const auto& p : fs::path(path)) out.push_back(p.string());
  return out;
}

// From the lowest up; core/README.md says what each holds.
const std::vector<std::string> kWings{"foundation", "scene", "intake", "observe", "render", "learn"};

size_t wing_of(const std::string& name) {
  return static_cast<size_t>(std::find(kWings.begin(), kWings.end(), name) - kWings.begin());
}

TEST(Layers, NoWingIncludesOneAboveIt) {
  for (const Include& i : includes_below(kRoot / "core")) {
    const std::vector<std::string> from = parts(i.file.string()), to = parts(i.target);
    ASSERT_LT(wing_of(from[1]), kWings.size()) << i.file.string() << " lies in no wing";
    if (to[0] != "core") continue;
    EXPECT_LE(wing_of(to[1]), wing_of(from[1])) << i.file.string() << ":" << i.line << " includes " << i.target;
  }
}

TEST(Layers, ModulesHaveNoCycle) {
  for (const auto& [module, to] : declared_edges())
    EXPECT_FALSE(to.contains(module)) << "core/" << module << " depends on itself";
}

TEST(Layers, CoreModulesIncludeOnlyWhatTheyDeclare) {
  const auto edges = declared_edges();
  ASSERT_GE(edges.size(), 10u);
  size_t seen = 0;
  for (const Include& i : includes_below(kRoot / "core")) {
    const std::string module = parts(i.file.string())[2];
    const std::vector<std::string> to = parts(i.target);
    EXPECT_TRUE(to[0] != "stages" && to[0] != "pipeline" && to[0] != "tests")
        << i.file << ":" << i.line << " includes " << i.target;
    if (to[0] != "core") continue;
    ++seen;
    const bool allowed = to[2] == module || (edges.contains(module) && edges.at(module).contains(to[2]));
    EXPECT_TRUE(allowed) << i.file.string() << ":" << i.line << " includes " << i.target << ", but the CMakeLists.txt of "
                         << module << " does not declare DEPENDS " << to[2];
  }
  EXPECT_GT(seen, 50u);
}

TEST(Layers, StagesNeverIncludeEachOther) {
  for (const Include& i : includes_below(kRoot / "stages")) {
    const std::vector<std::string> from = parts(i.file.string()), to = parts(i.target);
    EXPECT_NE(to[0], "pipeline") << i.file << ":" << i.line;
    if (to[0] != "stages" || to.size() < 3) continue;  // stages/stage.h and its kin belong to all
    EXPECT_EQ(to[1], from[1]) << i.file.string() << ":" << i.line << " includes " << i.target;
  }
}

TEST(Layers, ThePipelineKnowsStagesOnlyThroughTheirDescription) {
  for (const Include& i : includes_below(kRoot / "pipeline"))
    EXPECT_NE(parts(i.target)[0], "stages") << i.file.string() << ":" << i.line << " includes " << i.target;
}

TEST(Layers, TestsOfCoreIncludeNeitherStagesNorThePipeline) {
  const std::regex above("^(tests/)?(stages|pipeline)/");
  for (const Include& i : includes_below(kRoot / "tests/core"))
    EXPECT_FALSE(std::regex_search(i.target, above)) << i.file.string() << ":" << i.line << " includes " << i.target;
}

TEST(Layers, HeavyLibrariesStayOutOfPublicHeaders) {
  // embree_version.h is for sources alone: it includes the version of Embree that is installed.
  const std::regex heavy("^(opencv2|CGAL|embree[34]?|Eigen|ceres|OpenMesh|tbb|oneapi)/|/embree_version\\.h$");
  for (const Include& i : includes_below(kRoot / "core")) {
    if (i.file.extension() != ".h" || i.file.filename() == "embree_version.h") continue;
    EXPECT_FALSE(std::regex_search(i.target, heavy)) << i.file.string() << ":" << i.line << " includes " << i.target;
  }
}

// No rule is for one scene: what photos of the samples show has no name in the sources.
TEST(Layers, SourcesNameNoObjectOfASample) {
  const std::regex object("kettle|spout|brass|cabinet|tankard|plush", std::regex::icase);
  for (const char* folder : {"core", "stages", "pipeline"})
    for (const auto& e : fs::recursive_directory_iterator(kRoot / folder)) {
      const std::string extension = e.path().extension().string(), path = fs::relative(e.path(), kRoot).string();
      EXPECT_FALSE(std::regex_search(path, object)) << path;
      if (!e.is_regular_file() || (extension != ".h" && extension != ".cpp")) continue;
      std::ifstream in(e.path());
      int number = 0;
      for (std::string line; std::getline(in, line);)
        EXPECT_FALSE(++number > 0 && std::regex_search(line, object)) << path << ":" << number << ": " << line;
    }
}

}  // namespace
}  // namespace vitrine
