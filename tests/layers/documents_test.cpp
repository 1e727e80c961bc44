// READMEs are short enough to be read, entries of the pages EXPERIMENTS have the one form, and links of pages lead to files.
#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/foundation/base/file.h"

namespace vitrine {
namespace {

const fs::path kTop = VITRINE_SOURCE_DIR;

// Pages of the tree, that at its top among them, relative to it.
std::vector<fs::path> markdown_pages(std::string_view name = {}) {
  std::vector<fs::path> out{"README.md"};
  for (const char* folder : {"core", "stages", "pipeline", "tests", "sample_data", "configs"})
    for (const auto& e : fs::recursive_directory_iterator(kTop / folder))
      if (e.path().extension() == ".md") out.push_back(e.path().lexically_relative(kTop));
  if (!name.empty()) std::erase_if(out, [&](const fs::path& p) { return p.stem() != name; });
  std::sort(out.begin(), out.end());
  return out;
}

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> out;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    out.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return out;
}

TEST(Documents, ReadmesHaveAtMost120Lines) {
  const std::vector<fs::path> all = markdown_pages("README");
  EXPECT_GT(all.size(), 20u);
  for (const fs::path& page : all) EXPECT_LE(lines(read_file(kTop / page)).size(), 120u) << page;
}

// The labels that an entry must have, in this order, each at the beginning of a line.
constexpr std::array<std::string_view, 5> kForm{"Change: ", "Scenes: ", "Seeds: ", "Figures:", "Decision: "};

TEST(Documents, ExperimentsAreQuestionsWithChangeScenesSeedsFiguresDecision) {
  size_t entries = 0;
  for (const fs::path& page : markdown_pages("EXPERIMENTS")) {
    std::string title;
    size_t next = kForm.size();
    const auto close = [&] {
      if (next < kForm.size()) ADD_FAILURE() << page << ": '" << title << "' has no line '" << kForm[next] << "...'";
    };
    for (const std::string& line : lines(read_file(kTop / page))) {
      if (line.starts_with("## ")) {
        close();
        title = line.substr(3);
        next = 0;
        ++entries;
        EXPECT_NE(title.find('?'), std::string::npos) << page << ": '" << title << "' is no question";
      } else if (next < kForm.size() && line.starts_with(kForm[next])) {
        ++next;
      }
    }
    close();
  }
  EXPECT_GT(entries, 50u);
}

// [text](target) of a page, without links to other sites and without the heading behind '#'.
std::vector<std::string> targets(const std::string& text) {
  std::vector<std::string> out;
  for (size_t at = 0; (at = text.find("](", at)) != std::string::npos;) {
    at += 2;
    const std::string target = text.substr(at, text.find_first_of(") \n", at) - at);
    const std::string file = target.substr(0, target.find('#'));
    if (!file.empty() && target.find("://") == std::string::npos) out.push_back(file);
  }
  return out;
}

TEST(Documents, LinksLeadToFiles) {
  size_t links = 0;
  for (const fs::path& page : markdown_pages())
    for (const std::string& target : targets(read_file(kTop / page))) {
      ++links;
      EXPECT_TRUE(fs::exists(kTop / page.parent_path() / target)) << page << " links to " << target;
    }
  EXPECT_GT(links, 50u);
}

}  // namespace
}  // namespace vitrine
