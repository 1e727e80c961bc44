#include "core/foundation/config/photo_name_finder.h"

#include <utf8proc.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <set>
#include <tuple>

#include <fmt/format.h>

#include "core/foundation/base/file.h"

namespace vitrine {

std::string folded_name(const std::string& text) {
  utf8proc_uint8_t* out = nullptr;
  const auto options = static_cast<utf8proc_option_t>(UTF8PROC_STABLE | UTF8PROC_COMPOSE | UTF8PROC_CASEFOLD);
  const utf8proc_ssize_t size = utf8proc_map(reinterpret_cast<const utf8proc_uint8_t*>(text.data()),
                                             static_cast<utf8proc_ssize_t>(text.size()), &out, options);
  std::string result = size >= 0 ? std::string(reinterpret_cast<const char*>(out), static_cast<size_t>(size)) : text;
  std::free(out);
  if (size < 0)  // not UTF-8: bytes
    for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

namespace {

// Removes an image extension: a letter and up to three letters or digits. "v1.25" has none.
std::string without_extension(const std::string& file) {
  const size_t dot = file.rfind('.');
  if (dot == std::string::npos || dot == 0) return file;
  const std::string_view e = std::string_view(file).substr(dot + 1);
  const auto alnum = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; };
  const bool letter = !e.empty() && std::isalpha(static_cast<unsigned char>(e[0])) != 0;
  return letter && e.size() >= 2 && e.size() <= 4 && std::all_of(e.begin(), e.end(), alnum) ? file.substr(0, dot) : file;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

// "a%20b.jpg" -> "a b.jpg"
std::string percent_decoded(std::string_view text) {
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    const int high = text[i] == '%' && i + 2 < text.size() ? hex_digit(text[i + 1]) : -1;
    const int low = high >= 0 ? hex_digit(text[i + 2]) : -1;
    if (low >= 0)
      out += static_cast<char>(16 * high + low), i += 2;
    else
      out += text[i];
  }
  return out;
}

// "file:///a%20b.jpg" -> "/a b.jpg"
std::string without_scheme(const std::string& name) {
  constexpr std::string_view kScheme = "file://";
  if (name.size() < kScheme.size() || folded_name(name.substr(0, kScheme.size())) != kScheme) return name;
  return percent_decoded(std::string_view(name).substr(kScheme.size()));
}

std::string folder_of(const std::vector<std::string>& parts, size_t common) {
  std::string out;
  for (size_t i = 0; i + common < parts.size(); ++i) out += parts[i] + '/';
  return out;
}

}  // namespace

struct PhotoNameFinder::Query {
  Parts parts[2];               // as written; case-folded
  std::vector<Candidate> best;  // equal rank; more than one: ambiguous
  // Smaller is better.
  auto fit() const {
    const Candidate& c = best.front();
    return std::tuple(!c.exact, parts[0].size() - c.common, c.level);
  }
};

PhotoNameFinder::PhotoNameFinder(std::span<const std::string> names) : names_(names.begin(), names.end()) {
  for (const std::string& name : names) keep_backslashes_ |= name.find('\\') != std::string::npos;
  for (size_t i = 0; i < names.size(); ++i) add(i, names[i]);
  index();
}

PhotoNameFinder::PhotoNameFinder(std::span<const std::string> names, std::span<const std::vector<std::string>> paths)
    : names_(names.begin(), names.end()) {
  for (const auto& all : paths)
    for (const std::string& path : all) keep_backslashes_ |= path.find('\\') != std::string::npos;
  for (size_t i = 0; i < paths.size(); ++i)
    for (const std::string& path : paths[i]) add(i, path);
  index();
}

PhotoNameFinder::Parts PhotoNameFinder::parts_of(std::string name) const {
  name = without_scheme(name);
  if (!keep_backslashes_) {
    // "data\train\r_0" in a JSON file with unescaped backslashes: \t and \r were parsed as control characters.
    for (const auto& [control, letter] : {std::pair{'\t', 't'}, {'\r', 'r'}, {'\n', 'n'}, {'\b', 'b'}, {'\f', 'f'}})
      for (size_t at = name.find(control); at != std::string::npos; at = name.find(control, at))
        name.replace(at, 1, std::string("/") + letter);
    std::replace(name.begin(), name.end(), '\\', '/');
  }
  Parts parts;
  for (const fs::path& part : fs::path(name).lexically_normal())
    if (const std::string& text = part.native(); !text.empty() && text != "/" && text != "." && text != "//")
      parts.push_back(text);
  return parts;
}

void PhotoNameFinder::add(size_t photo, const std::string& path) {
  Alias alias{.photo = photo, .parts = {parts_of(path), {}}};
  if (alias.parts[0].empty()) return;
  for (const std::string& part : alias.parts[0]) alias.parts[1].push_back(folded_name(part));
  aliases_.push_back(std::move(alias));
}

void PhotoNameFinder::index() {
  for (size_t a = 0; a < aliases_.size(); ++a)
    for (size_t fold : {0, 1}) {
      const std::string& file = aliases_[a].parts[fold].back();
      by_file_[fold][file].push_back(a);
      std::vector<size_t>& whole = by_file_[kBare + fold][file];
      if (whole.empty() || whole.back() != a) whole.push_back(a);
      if (const std::string stem = without_extension(file); stem != file) by_file_[kBare + fold][stem].push_back(a);
    }
}

std::vector<PhotoNameFinder::Candidate> PhotoNameFinder::candidates(const Query& query, size_t level) const {
  const Parts& parts = query.parts[level % 2];
  std::vector<std::string> files{parts.back()};
  if (level >= kBare)
    for (size_t i = 0; i < 2; ++i)
      if (const std::string stem = without_extension(files.back()); stem != files.back()) files.push_back(stem);
  for (const std::string& file : files) {
    const auto found = by_file_[level].find(file);
    if (found == by_file_[level].end()) continue;
    std::vector<Candidate> out;
    for (size_t a : found->second) {
      const Parts& other = aliases_[a].parts[level % 2];
      Candidate c{.alias = &aliases_[a], .common = 1, .level = level};
      while (c.common < parts.size() && c.common < other.size() &&
             parts[parts.size() - 1 - c.common] == other[other.size() - 1 - c.common])
        ++c.common;
      c.whole = c.common == other.size();
      c.exact = level == kExact && c.whole && c.common == parts.size();
      out.push_back(c);
    }
    return out;
  }
  return {};
}

void PhotoNameFinder::decide(std::vector<Query>& queries) const {
  std::map<std::pair<std::string, std::string>, size_t> votes;  // (folder in the file, photo folder)
  const auto mapping = [&](const Query& q, const Candidate& c) {
    return std::pair(folder_of(q.parts[c.level % 2], c.common), folder_of(c.alias->parts[c.level % 2], c.common));
  };
  const auto keep_best = [](std::vector<Candidate>& list, auto&& rank) {
    if (list.empty()) return;
    const auto best = rank(*std::max_element(list.begin(), list.end(), [&](auto& a, auto& b) { return rank(a) < rank(b); }));
    std::erase_if(list, [&](const Candidate& c) { return rank(c) != best; });
  };
  for (Query& q : queries) {
    if (q.parts[0].empty()) continue;
    for (size_t level = 0; level < kLevels; ++level) {
      const std::vector<Candidate> more = candidates(q, level);
      q.best.insert(q.best.end(), more.begin(), more.end());
    }
    keep_best(q.best, [](const Candidate& c) { return c.path_rank(); });
    std::set<std::pair<std::string, std::string>> own;
    for (const Candidate& c : q.best) own.insert(mapping(q, c));
    for (const auto& m : own) ++votes[m];
  }
  for (Query& q : queries) {
    for (Candidate& c : q.best) c.votes = votes[mapping(q, c)];
    keep_best(q.best, [](const Candidate& c) { return c.rank(); });
    // Two paths of the same photo count as one.
    const auto photo = [](const Candidate& c) { return c.alias->photo; };
    std::ranges::stable_sort(q.best, {}, photo);
    const auto again = std::ranges::unique(q.best, {}, photo);
    q.best.erase(again.begin(), again.end());
  }
}

std::vector<PhotoMatch> PhotoNameFinder::match(std::span<const std::string> names, std::span<const fs::path> folders) const {
  const auto as_written = [&](const std::string& name) {
    Query q{.parts = {parts_of(name), {}}, .best = {}};
    for (const std::string& part : q.parts[0]) q.parts[1].push_back(folded_name(part));
    return q;
  };
  // Some programs write names as in addresses of the web: "a%20b.jpg" may be a photo of that name, else it is "a b.jpg".
  const auto query = [&](const std::string& name) {
    Query q = as_written(name);
    if (name.find('%') == std::string::npos || q.parts[0].empty()) return q;
    for (size_t level = 0; level < kLevels; ++level)
      if (!candidates(q, level).empty()) return q;
    return as_written(percent_decoded(name));
  };
  std::vector<Query> queries;
  for (const std::string& name : names) queries.push_back(query(name));
  decide(queries);

  for (Query& q : queries)
    for (const fs::path& folder : folders) {
      if (q.best.size() < 2) break;
      std::error_code ignored;
      fs::path there = fs::absolute(folder, ignored);
      for (const std::string& part : q.parts[0]) there /= part;
      if (!fs::exists(there, ignored)) continue;
      std::vector<Query> again{query(there.lexically_normal().string())};
      decide(again);
      const bool known = again[0].best.size() == 1 && std::any_of(q.best.begin(), q.best.end(), [&](const Candidate& c) {
                           return c.alias->photo == again[0].best[0].alias->photo;
                         });
      if (known) q.best = again[0].best;
    }

  // "left/c.jpg" does not match right/c.jpg if other names of left/ match photos of left/.
  std::map<std::string, size_t> agreeing;  // folder in the file -> maximum number of matching trailing parts
  const auto unique = [](const Query& q) { return q.best.size() == 1; };
  for (const Query& q : queries)
    if (unique(q)) {
      size_t& most = agreeing[folder_of(q.parts[0], 1)];
      most = std::max(most, q.best[0].common);
    }
  for (Query& q : queries)
    if (unique(q) && q.best[0].common < agreeing.at(folder_of(q.parts[0], 1))) q.best.clear();

  std::vector<PhotoMatch> out(names.size());
  std::map<size_t, size_t> best_name;  // photo -> best matching name
  for (size_t i = 0; i < queries.size(); ++i) {
    const Query& q = queries[i];
    if (q.best.size() > 1)
      for (const Candidate& c : q.best) out[i].could_be.push_back(c.alias->photo);
    if (q.best.size() != 1) continue;
    out[i].photo = q.best[0].alias->photo;
    const auto [at, fresh] = best_name.emplace(*out[i].photo, i);
    if (!fresh && q.fit() < queries[at->second].fit()) at->second = i;
  }
  for (size_t i = 0; i < queries.size(); ++i) {
    if (!out[i].photo) continue;
    const size_t best = best_name.at(*out[i].photo);
    if (best == i || queries[best].fit() == queries[i].fit()) continue;
    out[i].photo.reset();
    out[i].better_name = best;
  }
  return out;
}

PhotoMatch PhotoNameFinder::match(const std::string& name) const { return match(std::span(&name, 1))[0]; }

std::string listed(const PhotoNameFinder& finder, const std::vector<size_t>& photos) {
  constexpr size_t kMost = 3;
  std::string out;
  for (size_t i = 0; i < std::min(photos.size(), kMost); ++i)
    out += fmt::format("{}{}", i == 0 ? "" : i + 1 == photos.size() ? " or " : ", ", finder.name(photos[i]));
  return photos.size() > kMost ? out + fmt::format(" or {} more", photos.size() - kMost) : out;
}

}  // namespace vitrine
