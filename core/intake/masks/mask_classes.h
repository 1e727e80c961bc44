// The class of a file of masks by the folders that it lies in: masks/transparent/left/b.png is glass in the photo left/b. Folders
// that the photos have, too, are no classes, and neither are those whose names say nothing ("masks", "images"). Any other folder
// is a mistake that must not pass for masks of the object: `glass` is a word of the user's for `transparent`.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/intake/masks/mask_files.h"

namespace vitrine {

class MaskClassFolders {
 public:
  // `photos`: their names with folders. Without any, a folder that is not like a class is taken for one that the photos have.
  MaskClassFolders(std::filesystem::path masks, MaskClass flat, const std::vector<std::string>& photos);

  struct Place {
    MaskClass kind;
    std::filesystem::path name;  // below the folder of the class, as the photo lies below that of the photos
  };
  // Of a file by its path below the masks; nullopt: an unknown folder, which throw_if_unknown() names.
  std::optional<Place> place(const std::filesystem::path& relative);
  // Throws Error{Input}, with the class that was probably meant.
  void throw_if_unknown() const;

 private:
  bool of_photos(const std::string& folder) const { return photo_folders_.contains(folder); }
  std::filesystem::path masks_;
  MaskClass flat_;
  bool photos_known_;
  std::set<std::string> photo_folders_;    // lower case
  std::map<std::string, size_t> unknown_;  // folder, as written -> files
};

// The class that a word probably means: "glass", "Mirrors", "specualr".
std::optional<MaskClass> probable_mask_class(const std::string& word);

}  // namespace vitrine
