// Second sets of the same photos: folders of reduced copies, of cut-outs, of undistorted photos next to their originals.
#include "core/foundation/base/file.h"
#include "core/intake/photos/picture_content.h"
#include "core/intake/photos/sorted_pictures.h"

namespace vitrine {

namespace fs = std::filesystem;

namespace {

// Whether the folder name suggests another version.
bool is_other_version(const std::string& folder) {
  for (const fs::path& part : fs::path(folder)) {
    const std::string low = lowered(part.string());
    if (low == "input" || low == "dense" || low == "distorted" || low.find("undist") != std::string::npos) return true;
  }
  return false;
}

// Lower-case stems of the photos in one folder. For duplicates, the first photo.
using Stems = std::map<std::string, size_t>;

std::vector<std::string> common_stems(const Stems& a, const Stems& b) {
  std::vector<std::string> common;
  for (const auto& entry : a)
    if (b.contains(entry.first)) common.push_back(entry.first);
  return common;
}

}  // namespace

void drop_photos(std::vector<PhotoFile>& photos, const std::vector<uint8_t>& out) {
  std::vector<PhotoFile> kept;
  for (size_t i = 0; i < photos.size(); ++i)
    if (!out[i]) kept.push_back(std::move(photos[i]));
  photos = std::move(kept);
}

void leave_out_second_sets(PhotoFolder& folder) {
  std::map<std::string, Stems> folders;
  for (size_t i = 0; i < folder.photos.size(); ++i) {
    const fs::path source(folder.photos[i].source);
    folders[source.parent_path().generic_string()].try_emplace(lowered(source.stem().string()), i);
  }
  if (folders.size() < 2) return;
  std::vector<uint8_t> out(folder.photos.size(), 0);
  const auto path = [&](size_t i) { return folder.photos[i].path; };
  CopyFinder finder;
  // Whether sampled common photos of `small` are reduced copies (`shrunk`) or other versions of those of `large`.
  const auto is_version = [&](const std::vector<std::string>& common, const Stems& small, const Stems& large, bool shrunk) {
    const std::vector<std::string> samples = spread_samples(common);
    return std::all_of(samples.begin(), samples.end(), [&](const std::string& stem) {
      return finder.looks_like_copy(path(small.at(stem)), path(large.at(stem)), shrunk);
    });
  };
  // Those of the common photos of `small` that are cut-outs of those of `large`; empty if one of a few samples is none.
  const auto cutouts = [&](const std::vector<std::string>& common, const Stems& small, const Stems& large) {
    std::vector<std::pair<size_t, size_t>> cut;
    const auto is_one = [&](const std::string& stem) {
      return picture_head(path(small.at(stem))).alpha && looks_like_cutout(path(small.at(stem)), path(large.at(stem)), false);
    };
    const std::vector<std::string> samples = spread_samples(common);
    if (!std::all_of(samples.begin(), samples.end(), is_one)) return cut;
    for (const std::string& stem : common)
      if (is_one(stem)) cut.emplace_back(small.at(stem), large.at(stem));
    return cut;
  };
  for (const auto& [small_name, small] : folders)
    for (const auto& [large_name, large] : folders) {
      if (small_name == large_name) continue;
      const std::vector<std::string> common = common_stems(small, large);
      // Only whole folders: one or two photos of the same name are not enough.
      if (common.size() < 2 || 2 * common.size() < small.size()) continue;
      if (out[small.at(common[0])] || out[large.at(common[0])]) continue;
      if (const auto cut = cutouts(common, small, large); cut.size() == common.size()) {
        for (const auto& [i, of] : cut) {
          out[i] = 1;
          folder.beside.push_back({path(i), folder.photos[i].source, PictureRole::Cutout, folder.photos[of].source});
        }
        continue;
      }
      const bool shrunk = is_version(common, small, large, true);
      const bool other =
          !shrunk && is_other_version(small_name) && !is_other_version(large_name) && is_version(common, small, large, false);
      if (!shrunk && !other) continue;
      for (const std::string& stem : common) {
        const size_t i = small.at(stem);
        out[i] = 1;
        if (shrunk)
          folder.beside.push_back({path(i), folder.photos[i].source, PictureRole::Copy, folder.photos[large.at(stem)].source});
      }
      if (other) folder.second_sets.push_back({.used = large_name, .left_out = small_name, .photos = common.size()});
    }
  // The source of a copy may itself be a copy or left out: follow the chain.
  std::map<std::string, std::string> full;
  for (const BesidePhoto& b : folder.beside)
    if (b.role == PictureRole::Copy) full[b.source] = b.of;
  for (BesidePhoto& b : folder.beside)
    for (auto next = full.find(b.of); next != full.end(); next = full.find(b.of)) b.of = next->second;
  drop_photos(folder.photos, out);
}

}  // namespace vitrine
