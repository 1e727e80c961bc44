#include "core/scene/camera/holdout.h"

#include "core/foundation/base/file.h"
#include "core/foundation/config/json_file.h"

namespace vitrine {

namespace {

std::filesystem::path rigs_path(const std::filesystem::path& sfm_folder) { return sfm_folder / "sfm" / "rigs.json"; }

}  // namespace

Rigs read_rigs(const std::filesystem::path& sfm_folder) {
  Rigs rigs;
  const std::filesystem::path path = rigs_path(sfm_folder);
  if (!std::filesystem::exists(path)) return rigs;
  read_json_file(path, "list of rigs", [&](const nlohmann::json& j) {
    for (const auto& [view, panorama] : j.at("panorama_of").items()) rigs.emplace(view, panorama.get<std::string>());
  });
  return rigs;
}

void write_rigs(const std::filesystem::path& sfm_folder, const Rigs& rigs) {
  nlohmann::json panorama_of = nlohmann::json::object();
  for (const auto& [view, panorama] : rigs) panorama_of[view] = panorama;
  write_json_file(rigs_path(sfm_folder), {{"panorama_of", panorama_of}});
}

std::vector<uint8_t> heldout_views(std::span<const View> views, const Rigs& rigs, int every) {
  std::map<std::string, size_t> number_of_panorama;
  std::vector<uint8_t> heldout;
  size_t count = 0;
  for (const View& view : views) {
    const auto rig = rigs.find(view.name);
    size_t number = count;
    if (rig != rigs.end()) number = number_of_panorama.try_emplace(rig->second, count).first->second;
    if (number == count) ++count;
    heldout.push_back(is_heldout(number, every));
  }
  return heldout;
}

std::vector<uint8_t> heldout_views(const std::filesystem::path& sfm_folder, std::span<const View> views, int every) {
  return heldout_views(views, read_rigs(sfm_folder), every);
}

}  // namespace vitrine
