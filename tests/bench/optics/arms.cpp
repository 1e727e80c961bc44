#include "tests/bench/optics/arms.h"

#include <algorithm>
#include <charconv>

#include "core/foundation/base/error.h"
#include "core/foundation/config/text.h"

namespace vitrine {
namespace {

constexpr int kMostSeeds = 10000;

const std::map<std::string, std::map<std::string, std::string>> kKnownArms = {{"diffuse", {{"optimize.layers", "diffuse"}}},
                                                                              {"full", {{"optimize.layers", "auto"}}},
                                                                              {"layers", {{"optimize.opaque_twin", "false"}}},
                                                                              {"auto", {{"input.masks", "none"}}}};

[[noreturn]] void bad_words(std::string_view flag, std::string_view text, const std::string& why, const std::string& hint) {
  throw Error(ErrorKind::Usage, fmt::format("{} cannot be read", flag),
              {.where = std::string(text), .why = why, .hint = hint, .code = "USAGE"});
}

// Pieces between separators that stand in neither brackets nor quotes.
std::vector<std::string> pieces(std::string_view text, char separator) {
  std::vector<std::string> out(1);
  int depth = 0;
  bool quoted = false;
  for (const char c : text) {
    if (c == '"') quoted = !quoted;
    if (!quoted) depth += (c == '[') - (c == ']');
    if (c == separator && depth == 0 && !quoted)
      out.emplace_back();
    else
      out.back() += c;
  }
  return out;
}

int whole_number(std::string_view word, std::string_view flag, std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || value < 0)
    bad_words(flag, text, fmt::format("\"{}\" is no whole number", word), fmt::format("{} 1-12, or {} 1,2,7", flag, flag));
  return value;
}

void add_option(Arm& arm, const std::string& word, std::string_view text) {
  const size_t equals = word.find('=');
  if (equals == std::string::npos || word.find('.') >= equals)
    bad_words("--arms", text, fmt::format("\"{}\" is no option of a stage", word), "NAME:stage.option=value;stage.option=value");
  const std::string path = word.substr(0, equals), value = word.substr(equals + 1);
  const bool known = (path == "input.masks" && (value == "truth" || value == "marks" || value == "none")) ||
                     (path == "input.poses" && (value == "truth" || value == "none"));
  if (path.starts_with("input.") && !known)
    bad_words("--arms", text, fmt::format("\"{}\" is no input of an arm", word),
              "input.masks=marks, input.masks=none or input.poses=none");
  arm.options[path] = value;
}

Arm one_arm(const std::string& text) {
  const size_t colon = text.find(':');
  Arm arm{text.substr(0, colon), {}};
  const bool is_name = !arm.name.empty() && std::ranges::all_of(arm.name, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-';
  });
  if (!is_name) bad_words("--arms", text, fmt::format("\"{}\" is no name", arm.name), "letters, digits, - and _");
  const auto known = kKnownArms.find(arm.name);
  if (known != kKnownArms.end()) arm.options = known->second;
  if (colon != std::string::npos)
    for (const std::string& word : pieces(std::string_view(text).substr(colon + 1), ';')) add_option(arm, word, text);
  if (known == kKnownArms.end() && colon == std::string::npos) {
    std::vector<std::string> names;
    for (const auto& [name, options] : kKnownArms) names.push_back(name);
    const std::string near = nearest_word(arm.name, names);
    bad_words("--arms", text,
              fmt::format("there is no arm of the name '{}'{}", arm.name,
                          near.empty() ? std::string() : fmt::format("; did you mean '{}'?", near)),
              fmt::format("{}, or {}:stage.option=value", fmt::join(names, ", "), arm.name));
  }
  return arm;
}

}  // namespace

std::string Arm::source(const std::string& input) const {
  const auto it = options.find("input." + input);
  return it == options.end() ? "truth" : it->second;
}

std::vector<int> seed_list(std::string_view text, std::string_view flag) {
  std::vector<int> seeds;
  for (const std::string& piece : pieces(text, ',')) {
    const size_t dash = piece.find('-');
    const int from = whole_number(std::string_view(piece).substr(0, dash), flag, text);
    const int to = dash == std::string::npos ? from : whole_number(std::string_view(piece).substr(dash + 1), flag, text);
    if (to < from || to - from >= kMostSeeds)
      bad_words(flag, text, fmt::format("\"{}\" is no range", piece), fmt::format("{} 1-12", flag));
    for (int seed = from; seed <= to; ++seed)
      if (std::ranges::find(seeds, seed) == seeds.end()) seeds.push_back(seed);
  }
  return seeds;
}

std::vector<Arm> arm_list(std::string_view text) {
  std::vector<Arm> arms;
  for (const std::string& piece : pieces(text, ',')) {
    Arm arm = one_arm(piece);
    if (std::ranges::any_of(arms, [&](const Arm& a) { return a.name == arm.name; }))
      bad_words("--arms", text, fmt::format("the name '{}' stands there twice", arm.name), "another name for one of them");
    arms.push_back(std::move(arm));
  }
  return arms;
}

}  // namespace vitrine
