// Split of a capture into training and held-out views. Views cut from one panorama have one centre: they are
// held out together. sfm/rigs.json of an sfm artifact lists them; it is missing without panoramas.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/scene/camera/view.h"

namespace vitrine {

using Rigs = std::map<std::string, std::string>;  // view name -> its panorama, or the fisheye photo that it is cut from

// Empty without the file. Throws Error{Input} if it is damaged.
Rigs read_rigs(const std::filesystem::path& sfm_folder);
void write_rigs(const std::filesystem::path& sfm_folder, const Rigs& rigs);

// [view] 1: held out. `views`: sorted by name. Photos and panoramas are counted in the order of their first view, and the rule is
// is_heldout() of that number.
std::vector<uint8_t> heldout_views(std::span<const View> views, const Rigs& rigs, int every);
// Of an sfm artifact and its views.
std::vector<uint8_t> heldout_views(const std::filesystem::path& sfm_folder, std::span<const View> views, int every);

}  // namespace vitrine
