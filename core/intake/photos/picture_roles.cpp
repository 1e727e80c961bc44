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
// Of file names. Longer words before their suffixes.
constexpr Word kWords[] = {
    {"dynamic_mask", PictureRole::Mask},
    {"segmentation", PictureRole::Mask},
    {"silhouette", PictureRole::Mask},
    {"masked", PictureRole::Mask},
    {"masks", PictureRole::Mask},
    {"mask", PictureRole::Mask},
    {"matte", PictureRole::Mask},
    {"alpha", PictureRole::Mask},
    {"segm", PictureRole::Mask},
    {"seg", PictureRole::Mask},
    {"msk", PictureRole::Mask},
    {"depthmaps", PictureRole::Depth},
    {"depthmap", PictureRole::Depth},
    {"depths", PictureRole::Depth},
    {"depth", PictureRole::Depth},
    {"disparity", PictureRole::Depth},
    {"disp", PictureRole::Depth},
    {"zdepth", PictureRole::Depth},
    {"zbuffer", PictureRole::Depth},
    {"mist", PictureRole::Depth},
    {"z", PictureRole::Depth},
    {"normalmap", PictureRole::Normals},
    {"normals", PictureRole::Normals},
    {"normal", PictureRole::Normals},
    {"nrm", PictureRole::Normals},
    {"confidences", PictureRole::Confidence},
    {"confidence", PictureRole::Confidence},
    {"conf", PictureRole::Confidence},
    {"certainty", PictureRole::Confidence},
    {"uncertainty", PictureRole::Confidence},
    {"labels", PictureRole::Labels},
    {"label", PictureRole::Labels},
    {"labelmap", PictureRole::Labels},
    {"semantics", PictureRole::Labels},
    {"semantic", PictureRole::Labels},
    {"instances", PictureRole::Labels},
    {"instance", PictureRole::Labels},
    {"panoptic", PictureRole::Labels},
    {"indexob", PictureRole::Labels},
    {"indexma", PictureRole::Labels},
    {"cryptomatte", PictureRole::Labels},
    {"albedo", PictureRole::Pass},
    {"diffuse", PictureRole::Pass},
    {"roughness", PictureRole::Pass},
    {"metallic", PictureRole::Pass},
    {"occlusion", PictureRole::Pass},
    {"ao", PictureRole::Pass},
    {"emission", PictureRole::Pass},
    {"shading", PictureRole::Pass},
    {"removebg", PictureRole::Cutout},
    {"rembg", PictureRole::Cutout},
    {"rmbg", PictureRole::Cutout},
    {"nobg", PictureRole::Cutout},
    {"nobackground", PictureRole::Cutout},
    {"bgremoved", PictureRole::Cutout},
    {"cutouts", PictureRole::Cutout},
    {"cutout", PictureRole::Cutout},
    {"thumbnail", PictureRole::Copy},
    {"thumb", PictureRole::Copy},
    {"preview", PictureRole::Copy},
    {"lowres", PictureRole::Copy},
    {"small", PictureRole::Copy},
};
// Of folders only.
constexpr Word kFolders[] = {
    {"dynamic_masks", PictureRole::Mask},
    {"segmentations", PictureRole::Mask},
    {"segmented", PictureRole::Mask},
    {"segmentation_masks", PictureRole::Mask},
    {"silhouettes", PictureRole::Mask},
    {"alphas", PictureRole::Mask},
    {"mattes", PictureRole::Mask},
    {"matting", PictureRole::Mask},
    {"image_masks", PictureRole::Mask},
    {"images_masks", PictureRole::Mask},
    {"object_mask", PictureRole::Mask},
    {"object_masks", PictureRole::Mask},
    {"depth_map", PictureRole::Depth},
    {"depth_maps", PictureRole::Depth},
    {"disparities", PictureRole::Depth},
    {"mono_depth", PictureRole::Depth},
    {"normal_maps", PictureRole::Normals},
    {"normal_map", PictureRole::Normals},
    {"mono_normal", PictureRole::Normals},
    {"confidence_maps", PictureRole::Confidence},
    {"confidence_map", PictureRole::Confidence},
    {"label_maps", PictureRole::Labels},
    {"semantic_class", PictureRole::Labels},
    {"semantic_instance", PictureRole::Labels},
    {"instance_masks", PictureRole::Labels},
    {"no_bg", PictureRole::Cutout},
    {"no_background", PictureRole::Cutout},
    {"bg_removed", PictureRole::Cutout},
    {"background_removed", PictureRole::Cutout},
    {"cut_outs", PictureRole::Cutout},
};
// Words of kWords that name no folder: a place or a model may be called so.
constexpr std::string_view kNoFolders[] = {"z",     "ao",    "mist",    "conf",  "masked",  "msk",    "segm",     "disp",
                                           "thumb", "small", "preview", "label", "diffuse", "lowres", "thumbnail"};

constexpr std::string_view kPhotoWords[] = {"rgb", "rgba",  "color", "colour",   "image",
                                            "img", "photo", "frame", "original", "raw"};

// Mask classes and their synonyms.
constexpr std::string_view kClassFolders[] = {"object", "transparent", "specular", "ignore", "foreground", "background",
                                              "fg",     "bg",          "glass",    "mirror", "mirrors",    "dynamic"};

// Words of names of pictures that tell nothing about them.
constexpr std::string_view kFillers[] = {"map",    "maps", "images", "frames", "photos", "render",
                                         "meters", "mm",   "vis",    "pic",    "picture"};

bool is_separator(char c) { return c == '_' || c == '-' || c == '.' || c == ' '; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Words that may join without a separator: "mask0001", "IMG_7mask", "Normal0001".
bool joins(const Word& word, char neighbour) {
  return is_separator(neighbour) || is_digit(neighbour) || word.text == "mask" || word.text == "masks" || word.text == "depth";
}

template <size_t N>
bool listed(const std::string_view (&list)[N], std::string_view word) {
  return std::find(std::begin(list), std::end(list), word) != std::end(list);
}

std::optional<PictureRole> role_of_word(std::string_view word) {
  for (const Word& w : kWords)
    if (w.text == word) return w.role;
  return std::nullopt;
}

// "frame_007Depth" -> "frame", "7", "depth"
std::vector<std::string> words_of(std::string_view stem) {
  std::vector<std::string> words;
  for (size_t i = 0; i < stem.size();) {
    size_t end = i + 1;
    if (is_digit(stem[i])) {
      while (end < stem.size() && is_digit(stem[end])) ++end;
      size_t first = i;
      while (first + 1 < end && stem[first] == '0') ++first;
      words.emplace_back(stem.substr(first, end - first));
    } else if (!is_separator(stem[i])) {
      const auto continues = [&](char before, char c) {
        const bool capital = std::isupper(static_cast<unsigned char>(c)) && std::islower(static_cast<unsigned char>(before));
        return !is_digit(c) && !is_separator(c) && !capital;
      };
      while (end < stem.size() && continues(stem[end - 1], stem[end])) ++end;
      words.push_back(lowered(std::string(stem.substr(i, end - i))));
    }
    i = end;
  }
  return words;
}

std::string_view without_separators(std::string_view text) {
  while (!text.empty() && is_separator(text.back())) text.remove_suffix(1);
  while (!text.empty() && is_separator(text.front())) text.remove_prefix(1);
  return text;
}

}  // namespace

std::string_view plural(PictureRole role) {
  constexpr std::string_view names[] = {"masks",           "cut-outs",       "depth maps",    "maps of normals",
                                        "confidence maps", "maps of labels", "render passes", "reduced copies"};
  return names[static_cast<size_t>(role)];
}

std::string_view singular(PictureRole role) {
  constexpr std::string_view names[] = {"a mask",           "a cut-out",       "a depth map",   "a map of the normals",
                                        "a confidence map", "a map of labels", "a render pass", "a reduced copy"};
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

StemKey key_of_stem(std::string_view stem) {
  StemKey key;
  const std::vector<std::string> words = words_of(stem);
  for (size_t i = 0; i < words.size(); ++i) {
    // "no_bg", "Index OB": two words that are one in the table.
    const auto both = i + 1 < words.size() ? role_of_word(words[i] + words[i + 1]) : std::nullopt;
    if (const auto role = both ? both : role_of_word(words[i])) {
      if (!key.role || (*key.role == PictureRole::Copy)) key.role = role;
      i += both.has_value();
    } else if (!listed(kPhotoWords, words[i]) && !listed(kFillers, words[i])) {
      key.rest += (key.rest.empty() ? "" : " ") + words[i];
      if (is_digit(words[i][0])) key.number = words[i];
    }
  }
  return key;
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
  for (const std::string_view text : {std::string_view(low), without_number(low)}) {
    for (const Word& word : kFolders)
      if (text == word.text) return word.role;
    if (listed(kNoFolders, text)) continue;
    if (const auto role = role_of_word(text)) return role;
  }
  return std::nullopt;
}

bool is_class_folder(std::string_view name) {
  const std::string low = lowered(name);
  return listed(kClassFolders, low);
}

bool has_photo_extension(const std::string& name) {
  const std::string e = std::filesystem::path(name).extension().string();
  return e.size() >= 3 && e.size() <= 5 && lowered(e) != ".mask" &&
         std::all_of(e.begin() + 1, e.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)); }) &&
         std::any_of(e.begin() + 1, e.end(), [](char c) { return std::isalpha(static_cast<unsigned char>(c)); });
}

}  // namespace vitrine
