// Ceilings on the tree, so that it does not grow unnoticed: lines of C++ of each folder, small files, constants at file level,
// words that a graphics engineer would not search for, headers that open with a question. A commit that raises a ceiling gives
// the reason.
#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "core/foundation/base/file.h"

namespace vitrine {
namespace {

const fs::path kHouse = VITRINE_SOURCE_DIR;

struct Ceiling {
  const char* folder;
  size_t lines, private_words;
};
constexpr Ceiling kCeilings[] = {{"core/foundation", 6000, 0}, {"core/scene", 15000, 3},  {"core/intake", 10450, 36},
                                 {"core/observe", 5700, 0},    {"core/render", 19350, 0}, {"core/learn", 6450, 0},
                                 {"stages", 37350, 35},        {"pipeline", 9050, 0}};
constexpr size_t kSmallFileLines = 40;
constexpr size_t kMostSmallFiles = 128, kMostConstants = 1461, kMostQuestionHeaders = 0;

// Standard terms for them stand in the glossary of core/README.md.
constexpr std::array<std::string_view, 22> kPrivateWords{
    "says",    "said",  "say",    "asks", "asked", "askers", "tells", "told",     "tell",  "speaks", "teaches",
    "vouched", "thing", "things", "lump", "crumb", "beside", "gloss", "polished", "blame", "blamed", "dissent"};

std::vector<fs::path> sources(const fs::path& folder) {
  std::vector<fs::path> out;
  for (const auto& e : fs::recursive_directory_iterator(kHouse / folder))
    if (e.is_regular_file() && (e.path().extension() == ".h" || e.path().extension() == ".cpp")) out.push_back(e.path());
  return out;
}

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> out;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    out.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return out;
}

size_t private_words(std::string_view text) {
  size_t count = 0;
  const auto is_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  for (size_t at = 0; at < text.size();) {
    size_t end = at;
    while (end < text.size() && is_word(text[end])) ++end;
    std::string word(text.substr(at, end - at));
    for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    count += std::find(kPrivateWords.begin(), kPrivateWords.end(), word) != kPrivateWords.end();
    at = end + 1;
  }
  return count;
}

TEST(House, FoldersStayBelowTheirCeilings) {
  for (const Ceiling& c : kCeilings) {
    size_t lines = 0, words = 0;
    for (const fs::path& file : sources(c.folder)) {
      const std::string text = read_file(file);
      lines += lines_of(text).size();
      words += private_words(text);
    }
    EXPECT_LE(lines, c.lines) << "lines of C++ in " << c.folder;
    EXPECT_LE(words, c.private_words) << "words of the list above in " << c.folder;
    RecordProperty(c.folder, std::to_string(lines) + " lines, " + std::to_string(words) + " words");
  }
}

TEST(House, SmallFilesConstantsAndQuestionsStayBelowTheirCeilings) {
  size_t small = 0, constants = 0, questions = 0;
  for (const char* folder : {"core", "stages", "pipeline"})
    for (const fs::path& file : sources(folder)) {
      const std::string text = read_file(file);
      const std::vector<std::string_view> lines = lines_of(text);
      small += lines.size() < kSmallFileLines;
      for (std::string_view line : lines) {
        for (std::string_view word : {"inline ", "static "})
          if (line.starts_with(word)) line.remove_prefix(word.size());
        const size_t equals = line.find('=');
        constants += line.starts_with("constexpr ") && equals != line.npos && line.find('(') > equals;
      }
      for (std::string_view word : {"// What ", "// Which ", "// How ", "// Where "}) questions += text.starts_with(word);
    }
  EXPECT_LE(small, kMostSmallFiles) << "files of fewer than " << kSmallFileLines << " lines";
  EXPECT_LE(constants, kMostConstants) << "constants at file level";
  EXPECT_LE(questions, kMostQuestionHeaders) << "files whose first sentence is a question";
}

}  // namespace
}  // namespace vitrine
