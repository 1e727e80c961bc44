// The photos of a folder: which files are photographs, in which order, and what they are called from here on.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/foundation/base/folder_files.h"
#include "core/foundation/base/hash.h"
#include "core/scene/image/probe.h"
#include "core/intake/photos/exif.h"
#include "core/intake/photos/photo_color.h"
#include "core/intake/photos/picture_roles.h"

namespace vitrine {

struct PhotoFile {
  std::filesystem::path path;
  std::string source;      // below the folder, with '/'
  std::string name, stem;  // unique (core/intake/photos/photo_list.h)
};

// A picture that belongs to a photo and is none.
struct BesidePhoto {
  std::filesystem::path path;
  std::string source;  // below the folder, with '/'
  PictureRole role = PictureRole::Mask;
  std::string of;  // the photo's source; empty: all photos in its folder
};

// A second set of the same photos that is left out, because it is of about the same size as the one that is used.
struct SecondSet {
  std::string used, left_out;  // folders
  size_t photos = 0;
};

struct PhotoFolder {
  std::filesystem::path folder;
  std::vector<PhotoFile> photos;          // sorted by source, byte order
  std::map<std::string, size_t> skipped;  // lower-case extension ("" = none) -> files that are no photo we read
  std::vector<BesidePhoto> beside;        // sorted by source
  std::vector<std::string> like_photos;   // called like a mask, ... of another picture, and a photo by their content
  std::vector<SecondSet> second_sets;
  FolderFiles listed;  // links, closed folders, junk; without its files
};

// Sub-folders are searched, and linked ones. Throws Error{Input} when the folder is missing, unreadable or holds no photo.
PhotoFolder find_photos(const std::filesystem::path& folder);

// What a user should know of a folder of photos.
struct FolderNote {
  std::string code;      // "MASKS_BESIDE_PHOTOS"
  bool warning = false;  // something is left out that may be missed; else what is left out is no photo
  std::string what, why, hint;
  std::string sentence() const { return what + (why.empty() ? "" : " (" + why + ")") + ": " + hint; }
};
std::vector<FolderNote> notes_of(const PhotoFolder& folder);

// Gives every photo its name and stem. `photos` is sorted by source.
void assign_names(std::vector<PhotoFile>& photos);

// What is known of a photo before its pixels are decoded.
struct PhotoHead {
  Probe probe;
  Exif exif;
  Digest digest;                   // of the file's bytes
  std::vector<std::string> notes;  // what is left out or assumed, and what is beside the picture (core/scene/image/picture_file.h)
  std::string aside;
  PhotoColor color;
  bool alpha = false;  // the file has an alpha channel
};
// Throws Error{Input} when the file is empty, truncated, of a kind we do not read, too large, or has colours of print.
PhotoHead read_photo_head(const std::filesystem::path& path);

// "3 x .cr2, 1 x .txt"
std::string skipped_text(const PhotoFolder& folder);
// Files that hold photographs or video in a form this build does not read.
size_t skipped_photo_like(const PhotoFolder& folder);

}  // namespace vitrine
