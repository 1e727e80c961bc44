#include "core/intake/photos/picture_roles.h"
#include "core/foundation/base/file.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace vitrine {

namespace {

struct Word {
  std::string_view text;
  PictureRole role;
};
// Longer words before their suffixes.
constexpr Word kWords[] = {
    {"dynamic_mask", PictureRole::Mask}, {"segmentation", PictureRole::Mask}, {"silhouette", PictureRole::Mask},
    {"masked", PictureRole::Mask},       {"masks", PictureRole::Mask},        {"mask", PictureRole::Mask},
    {"matte", PictureRole::Mask},        {"alpha", PictureRole::Mask},        {"segm", PictureRole::Mask},
    {"seg", PictureRole::Mask},          {"msk", PictureRole::Mask},          {"depthmap", PictureRole::Depth},
    {"depth", PictureRole::Depth},       {"disparity", PictureRole::Depth},   {"disp", PictureRole::Depth},
    {"normals", PictureRole::Normals},   {"normal", PictureRole::Normals},    {"thumbnail", PictureRole::Copy},
    {"thumb", PictureRole::Copy},        {"preview", PictureRole::Copy},      {"lowres", PictureRole::Copy},
    {"small", PictureRole::Copy},
};
constexpr Word kFolders[] = {
    {"mask", PictureRole::Mask},          {"masks", PictureRole::Mask},
    {"dynamic_mask", PictureRole::Mask},  {"dynamic_masks", PictureRole::Mask},
    {"segmentation", PictureRole::Mask},  {"segmentations", PictureRole::Mask},
    {"segmented", PictureRole::Mask},     {"segmentation_masks", PictureRole::Mask},
    {"seg", PictureRole::Mask},           {"silhouette", PictureRole::Mask},
    {"silhouettes", PictureRole::Mask},   {"alpha", PictureRole::Mask},
    {"alphas", PictureRole::Mask},        {"matte", PictureRole::Mask},
    {"mattes", PictureRole::Mask},        {"matting", PictureRole::Mask},
    {"image_masks", PictureRole::Mask},   {"images_masks", PictureRole::Mask},
    {"object_mask", PictureRole::Mask},   {"object_masks", PictureRole::Mask},
    {"depth", PictureRole::Depth},        {"depths", PictureRole::Depth},
    {"depth_map", PictureRole::Depth},    {"depth_maps", PictureRole::Depth},
    {"depthmaps", PictureRole::Depth},    {"depthmap", PictureRole::Depth},
    {"disparity", PictureRole::Depth},    {"disparities", PictureRole::Depth},
    {"mono_depth", PictureRole::Depth},   {"normal", PictureRole::Normals},
    {"normals", PictureRole::Normals},    {"normal_maps", PictureRole::Normals},
    {"normal_map", PictureRole::Normals}, {"mono_normal", PictureRole::Normals},
};

constexpr std::string_view kPhotoWords[] = {"rgb", "rgba",  "color", "colour",   "image",
                                            "img", "photo", "frame", "original", "raw"};

// Mask classes and their synonyms.
constexpr std::string_view kClassFolders[] = {"object", "transparent", "specular", "ignore", "foreground", "background",
                                              "fg",     "bg",          "glass",    "mirror", "mirrors",    "dynamic"};

bool is_separator(char c) { return c == '_' || c == '-' || c == '.' || c == ' '; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Words that may join without a separator: "mask0001", "IMG_7mask".
bool joins(const Word& word, char neighbour) {
  return is_separator(neighbour) || word.text == "mask" || word.text == "masks" || word.text == "depth";
}

std::string_view without_separators(std::string_view text) {
  while (!text.empty() && is_separator(text.back())) text.remove_suffix(1);
  while (!text.empty() && is_separator(text.front())) text.remove_prefix(1);
  return text;
}

}  // namespace

std::string_view plural(PictureRole role) {
  constexpr std::string_view names[] = {"masks", "depth maps", "maps of normals", "reduced copies"};
  return names[static_cast<size_t>(role)];
}

std::string_view without_number(std::string_view text) {
  size_t end = text.size();
  while (end > 0 && is_digit(text[end - 1])) --end;
  if (end == text.size() || end == 0) return text;
  if (is_separator(text[end - 1])) --end;
  return end == 0 ? text : text.substr(0, end);
}

std::vector<NamedRole> roles_of_stem(const std::string& stem) {
  std::vector<NamedRole> roles;
  const std::string low = lowered(stem);
  for (const std::string_view text : {std::string_view(low), without_number(low)}) {
    for (const Word& word : kWords) {
      const size_t rest = text.size() - std::min(text.size(), word.text.size());
      if (rest == 0 || !text.ends_with(word.text) || !joins(word, text[rest - 1])) continue;
      const std::string_view of = without_separators(std::string_view(stem).substr(0, rest));
      if (!of.empty()) roles.push_back({word.role, std::string(of)});
      break;
    }
    if (without_number(low).size() == low.size()) break;  // no number to remove
  }
  for (const Word& word : kWords) {
    const size_t size = word.text.size();
    if (low.size() <= size || !low.starts_with(word.text) || !joins(word, low[size])) continue;
    const std::string_view of = without_separators(std::string_view(stem).substr(size));
    if (!of.empty()) roles.push_back({word.role, std::string(of)});
    break;
  }
  if (has_photo_extension(stem)) roles.push_back({PictureRole::Mask, stem});
  return roles;
}

std::vector<std::string> photo_stems_of(std::string_view of) {
  const std::string low = lowered(of);
  std::vector<std::string> stems{low};
  for (const std::string_view word : kPhotoWords)
    for (const char separator : {'_', '-', '.'}) {
      stems.push_back(low + separator + std::string(word));
      stems.push_back(std::string(word) + separator + low);
    }
  return stems;
}

std::optional<PictureRole> role_of_folder(std::string_view name) {
  const std::string low = lowered(name);
  for (const std::string_view text : {std::string_view(low), without_number(low)})
    for (const Word& word : kFolders)
      if (text == word.text) return word.role;
  return std::nullopt;
}

bool is_class_folder(std::string_view name) {
  const std::string low = lowered(name);
  return std::find(std::begin(kClassFolders), std::end(kClassFolders), low) != std::end(kClassFolders);
}

bool has_photo_extension(const std::string& name) {
  const std::string e = std::filesystem::path(name).extension().string();
  return e.size() >= 3 && e.size() <= 5 && lowered(e) != ".mask" &&
         std::all_of(e.begin() + 1, e.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)); }) &&
         std::any_of(e.begin() + 1, e.end(), [](char c) { return std::isalpha(static_cast<unsigned char>(c)); });
}

}  // namespace vitrine
