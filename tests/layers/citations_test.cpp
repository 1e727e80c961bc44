// Citations in comments and documents resolve: "algorithms 3.2" is a heading of core/algorithms.md, a number behind "README" is
// that of a paragraph there, a page that is named exists; and core/algorithms.md names only files and papers that exist.
#include <algorithm>
#include <array>
#include <cctype>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/foundation/base/file.h"

namespace vitrine {
namespace {

const fs::path kTree = VITRINE_SOURCE_DIR;

struct Page {
  fs::path file;  // relative to the tree
  std::string text;
};

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }
bool is_path(char c) { return is_word(c) || c == '/' || c == '.' || c == '-'; }

// Sources and documents of the tree, those at its top among them; sorted.
std::vector<Page> pages() {
  std::vector<fs::path> files;
  const auto take = [&](const fs::directory_entry& e) {
    const std::string extension = e.path().extension().string();
    if (e.is_regular_file() && (extension == ".h" || extension == ".cpp" || extension == ".md")) files.push_back(e.path());
  };
  for (const auto& e : fs::directory_iterator(kTree)) take(e);
  for (const char* folder : {"core", "stages", "pipeline", "tests", "sample_data"})
    for (const auto& e : fs::recursive_directory_iterator(kTree / folder)) take(e);
  std::sort(files.begin(), files.end());
  std::vector<Page> out;
  for (const fs::path& file : files) out.push_back({file.lexically_relative(kTree), read_file(file)});
  return out;
}

std::string place(const Page& page, size_t at) {
  const auto line = 1 + std::count(page.text.begin(), page.text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
  return fmt::format("{}:{}", page.file.string(), line);
}

// Past spaces, line ends and the slashes of comments.
size_t past_gap(std::string_view text, size_t at) {
  while (at < text.size()) {
    if (std::isspace(static_cast<unsigned char>(text[at])) != 0)
      ++at;
    else if (text.substr(at, 2) == "//")
      at += 2;
    else
      break;
  }
  return at;
}

// "3" or "3.2" at `at`, which moves behind it; empty: there is none.
std::string number_at(std::string_view text, size_t& at) {
  size_t end = at;
  while (end < text.size() &&
         (is_digit(text[end]) || (end > at && text[end] == '.' && end + 1 < text.size() && is_digit(text[end + 1]))))
    ++end;
  if (end < text.size() && is_word(text[end])) return {};
  std::string number(text.substr(at, end - at));
  at = end;
  return number;
}

// The numbers of "3.2", "1, 4 and 8", "3 to 5", "6-8" behind a gap at `at`; a range of whole numbers has those between.
std::vector<std::string> numbers_after(std::string_view text, size_t at) {
  std::vector<std::string> out;
  size_t next = past_gap(text, at);
  if (next == at) return out;
  bool range = false;
  while (true) {
    const std::string number = number_at(text, next);
    if (number.empty()) return out;
    if (range && (out.back() + number).find('.') == std::string::npos)
      for (int i = std::stoi(out.back()) + 1; i < std::stoi(number); ++i) out.push_back(std::to_string(i));
    out.push_back(number);
    next = past_gap(text, next);
    constexpr std::array<std::string_view, 5> kLinks{"to", "-", ",", "and", "or"};
    const auto link = std::find_if(kLinks.begin(), kLinks.end(), [&](auto l) { return text.substr(next, l.size()) == l; });
    if (link == kLinks.end()) return out;
    range = link < kLinks.begin() + 2;
    next = past_gap(text, next + link->size());
  }
}

// Behind a name that may end with ".md" and a backtick.
size_t past_name(std::string_view text, size_t at) {
  if (text.substr(at, 3) == ".md") at += 3;
  return text.substr(at, 1) == "`" ? at + 1 : at;
}

// Numbers behind `mark` at the beginning of lines: "### 3.2 Blend", "**4 Shading**".
std::set<std::string> numbered(const std::string& text, std::string_view mark) {
  std::set<std::string> out;
  for (size_t begin = 0; begin < text.size(); begin = std::min(text.find('\n', begin), text.size()) + 1) {
    if (text.compare(begin, mark.size(), mark) != 0) continue;
    size_t at = begin + mark.size();
    if (const std::string number = number_at(text, at); !number.empty()) out.insert(number);
  }
  return out;
}

std::set<std::string> sections() {
  const std::string text = read_file(kTree / "core/algorithms.md");
  std::set<std::string> out = numbered(text, "## ");
  out.merge(numbered(text, "### "));
  return out;
}

TEST(Citations, OfAlgorithmsAreHeadingsOfThatPage) {
  const std::set<std::string> known = sections();
  ASSERT_GT(known.size(), 40u);
  size_t cited = 0;
  for (const Page& page : pages())
    for (size_t at = 1; (at = page.text.find("lgorithms", at)) != std::string::npos; ++at) {
      const char first = page.text[at - 1];
      if ((first != 'a' && first != 'A') || (at > 1 && is_word(page.text[at - 2]))) continue;
      for (const std::string& number : numbers_after(page.text, past_name(page.text, at + 9))) {
        ++cited;
        EXPECT_TRUE(known.contains(number)) << place(page, at) << " cites algorithms " << number
                                            << ", which is no heading of core/algorithms.md";
      }
    }
  EXPECT_GT(cited, 40u);
}

// The README that is named, or the first one with numbered paragraphs on the way up from the page.
std::set<std::string> paragraphs_meant(const Page& page, const std::string& folder) {
  if (!folder.empty()) {
    const fs::path file = kTree / folder / "README.md";
    return fs::exists(file) ? numbered(read_file(file), "**") : std::set<std::string>{};
  }
  for (fs::path up = page.file.parent_path(); !up.empty(); up = up.parent_path())
    if (const fs::path file = kTree / up / "README.md"; fs::exists(file))
      if (auto found = numbered(read_file(file), "**"); !found.empty()) return found;
  return {};
}

TEST(Citations, OfReadmesAreNumberedParagraphs) {
  size_t cited = 0;
  for (const Page& page : pages())
    for (size_t at = 0; (at = page.text.find("README", at)) != std::string::npos; ++at) {
      const std::vector<std::string> numbers = numbers_after(page.text, past_name(page.text, at + 6));
      if (numbers.empty()) continue;
      size_t begin = at;
      while (begin > 0 && is_path(page.text[begin - 1])) --begin;
      const std::set<std::string> known = paragraphs_meant(page, page.text.substr(begin, at - begin));
      for (const std::string& number : numbers) {
        ++cited;
        EXPECT_TRUE(known.contains(number)) << place(page, at) << " cites " << page.text.substr(begin, at - begin) << "README "
                                            << number << ", which is no numbered paragraph there";
      }
    }
  EXPECT_GT(cited, 30u);
}

// As seen from the top of the tree, or from a folder on the way up from the page.
bool exists_for(const Page& page, const fs::path& name) {
  for (fs::path up = page.file.parent_path(); !up.empty(); up = up.parent_path())
    if (fs::exists(kTree / up / name)) return true;
  return fs::exists(kTree / name);
}

TEST(Citations, OfPagesNameFilesThatExist) {
  for (const Page& page : pages())
    for (size_t at = 1; (at = page.text.find(".md", at)) != std::string::npos; ++at) {
      if (!is_word(page.text[at - 1]) || (at + 3 < page.text.size() && is_word(page.text[at + 3]))) continue;
      size_t begin = at;
      while (begin > 0 && is_path(page.text[begin - 1])) --begin;
      const std::string name = page.text.substr(begin, at + 3 - begin);
      EXPECT_TRUE(exists_for(page, name)) << place(page, at) << " names " << name << ", which does not exist";
    }
}

// `mesh/tsdf_volume.cpp` is below core/, `stages/mesh/fusion.cpp` below the tree, `aovs.h` anywhere.
TEST(Citations, OfFilesInAlgorithmsExist) {
  const Page page{"core/algorithms.md", read_file(kTree / "core/algorithms.md")};
  std::set<std::string> names;
  for (const Page& p : pages()) names.insert(p.file.filename().string());
  size_t cited = 0;
  for (size_t at = 0; (at = page.text.find('`', at)) != std::string::npos; ++at) {
    const size_t begin = ++at;
    at = page.text.find('`', begin);
    ASSERT_NE(at, std::string::npos) << place(page, begin) << " has a backtick without its partner";
    const fs::path file = page.text.substr(begin, at - begin);
    if ((file.extension() != ".h" && file.extension() != ".cpp") || file.string().find('{') != std::string::npos) continue;
    ++cited;
    EXPECT_TRUE(fs::exists(kTree / file) || fs::exists(kTree / "core" / file) ||
                (!file.has_parent_path() && names.contains(file.string())))
        << place(page, begin) << " names " << file.string() << ", which does not exist";
  }
  EXPECT_GT(cited, 60u);
}

// [Author year] in the text stands in the table of section 10.
TEST(Citations, OfPapersInAlgorithmsStandInItsTable) {
  const Page page{"core/algorithms.md", read_file(kTree / "core/algorithms.md")};
  const size_t table = page.text.find("## 10 Sources");
  ASSERT_NE(table, std::string::npos);
  size_t cited = 0;
  for (size_t at = 0; (at = page.text.find('[', at)) < table; ++at) {
    const size_t end = page.text.find_first_of(",]", at);
    std::string paper;  // without the line end that may divide it
    for (size_t i = at + 1; i < end; ++i) paper += page.text[i] == '\n' ? ' ' : page.text[i];
    const bool has_year = paper.size() > 5 && std::all_of(paper.end() - 4, paper.end(), is_digit) && *(paper.end() - 5) == ' ';
    if (!has_year || std::isupper(static_cast<unsigned char>(paper[0])) == 0) continue;
    ++cited;
    EXPECT_NE(page.text.find("| " + paper + " |", table), std::string::npos)
        << place(page, at) << " cites [" << paper << "], which is not in section 10";
  }
  EXPECT_GT(cited, 40u);
}

}  // namespace
}  // namespace vitrine
