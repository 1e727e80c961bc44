// Derives the class of a mask file from its folders: masks/transparent/left/b.png is glass in the photo left/b. Folders that the
// photos also have are no classes, nor are generic names ("masks", "images"). Any other folder is an error, so that it is not
// read as masks of the object: users write `glass` for `transparent`.
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
  // `photos`: their names with folders. If empty, a folder unlike any class is assumed to be one of the photos'.
  MaskClassFolders(std::filesystem::path masks, MaskClass flat, const std::vector<std::string>& photos);

  struct Place {
    MaskClass kind;
    std::filesystem::path name;  // below the class folder, matching the photo's path below the photo folder
  };
  // `relative`: path of a file below the masks; nullopt: an unknown folder, which throw_if_unknown() reports.
  std::optional<Place> place(const std::filesystem::path& relative);
  // Throws Error{Input} with the class that was probably meant.
  void throw_if_unknown() const;

 private:
  bool of_photos(const std::string& folder) const { return photo_folders_.contains(folder); }
  std::filesystem::path masks_;
  MaskClass flat_;
  bool photos_known_;
  std::set<std::string> photo_folders_;    // lower case
  std::map<std::string, size_t> unknown_;  // folder, as written -> files
};

// The most likely class for a word: "glass", "Mirrors", "specualr".
std::optional<MaskClass> probable_mask_class(const std::string& word);

}  // namespace vitrine
