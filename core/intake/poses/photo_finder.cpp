#include "core/intake/poses/pose_files.h"

#include <cstdlib>
#include <map>

#include "core/foundation/base/file.h"

namespace vitrine {

namespace {

std::vector<std::string> names_of(std::span<const Photo> photos) {
  std::vector<std::string> names;
  for (const Photo& p : photos) names.push_back(p.name);
  return names;
}

std::vector<std::vector<std::string>> paths_of(std::span<const Photo> photos) {
  std::vector<std::vector<std::string>> paths;
  for (const Photo& p : photos) {
    paths.push_back({p.source.empty() ? p.name : p.source});
    if (p.name != paths.back()[0]) paths.back().push_back(p.name);
  }
  return paths;
}

}  // namespace

PhotoFinder::PhotoFinder(std::span<const Photo> photos) : PhotoNameFinder(names_of(photos), paths_of(photos)) {}

std::vector<size_t> first_versions(std::span<const Photo> photos) {
  const auto key = [](const fs::path& path) { return folded_name(fs::path(path).replace_extension().generic_string()); };
  std::map<std::string, size_t> by_key;
  for (size_t i = 0; i < photos.size(); ++i) by_key.emplace(key(photos[i].source), i);
  // Photo at `path` with its folder `part` renamed to `name`.
  const auto with_folder = [&](const fs::path& path, const fs::path::iterator& part,
                               const std::string& name) -> std::optional<size_t> {
    fs::path other;
    for (auto at = path.begin(); at != path.end(); ++at) other /= at == part ? fs::path(name) : *at;
    const auto found = by_key.find(key(other));
    return found != by_key.end() ? std::optional(found->second) : std::nullopt;
  };
  std::vector<size_t> first(photos.size());
  for (size_t i = 0; i < photos.size(); ++i) {
    first[i] = i;
    const fs::path path(photos[i].source);
    for (auto part = path.begin(); part != path.end(); ++part) {
      const std::string& folder = part->native();
      if (folder == "input")
        if (const auto found = with_folder(path, part, "images")) first[i] = *found;
      const size_t line = folder.rfind('_');
      if (line == std::string::npos || line == 0 || line + 1 == folder.size() || folder.size() - line > 3 ||
          folder.find_first_not_of("0123456789", line + 1) != std::string::npos)
        continue;
      const int factor = std::stoi(folder.substr(line + 1));
      const auto found = with_folder(path, part, folder.substr(0, line));
      if (factor < 2 || !found || *found == i) continue;
      const auto fits = [&](int a, int b) { return std::abs(double(b) / factor - a) <= 1; };
      if (fits(photos[i].original_width, photos[*found].original_width) &&
          fits(photos[i].original_height, photos[*found].original_height))
        first[i] = *found;
    }
  }
  return first;
}

}  // namespace vitrine
