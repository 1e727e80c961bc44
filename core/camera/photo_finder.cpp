#include "core/camera/photo_finder.h"

#include <cctype>

#include "core/base/file.h"

namespace vitrine {

namespace {

std::string lower(std::string s) {
  for (char& c : s) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return s;
}

}  // namespace

PhotoFinder::PhotoFinder(std::span<const Photo> photos) {
  for (size_t i = 0; i < photos.size(); ++i) {
    const fs::path name(photos[i].name), source(photos[i].source);
    note(0, photos[i].name, i);
    note(1, photos[i].source, i);
    note(2, lower(name.filename().string()), i);
    note(3, lower(source.filename().string()), i);
    note(4, lower(photos[i].stem), i);
    note(5, lower(name.stem().string()), i);
  }
}

std::optional<size_t> PhotoFinder::operator()(const std::string& pose_name) const {
  const fs::path path(pose_name);
  const std::string file = lower(path.filename().string());
  const std::string tries[kRules] = {pose_name, pose_name, file, file, lower(pose_name), lower(path.stem().string())};
  for (size_t rule = 0; rule < kRules; ++rule) {
    const auto found = keys_[rule].find(tries[rule]);
    if (found != keys_[rule].end() && found->second) return found->second;
  }
  // transforms.json of the Blender kind has no extension.
  const auto bare = keys_[5].find(file);
  return bare != keys_[5].end() ? bare->second : std::nullopt;
}

void PhotoFinder::note(size_t rule, const std::string& key, size_t photo) {
  const auto [at, fresh] = keys_[rule].emplace(key, photo);
  if (!fresh && at->second != photo) at->second = std::nullopt;
}

}  // namespace vitrine
