// Lists the photos of a folder: which files are photographs, their order and their names in all later stages.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/foundation/base/folder_files.h"
#include "core/foundation/base/hash.h"
#include "core/scene/image/probe.h"
#include "core/intake/photos/exif.h"
#include "core/intake/photos/panorama.h"
#include "core/intake/photos/photo_color.h"
#include "core/intake/photos/picture_roles.h"
#include "core/intake/photos/raw_photo.h"

namespace vitrine {

struct PhotoFile {
  std::filesystem::path path;
  std::string source;      // below the folder, with '/'
  std::string name, stem;  // unique (core/intake/photos/photo_list.h)
  RawBalance balance{};    // raw photos: white balance of the first photo of the camera
};

// A picture that belongs to a photo but is no photo itself.
struct BesidePhoto {
  std::filesystem::path path;
  std::string source;  // below the folder, with '/'
  PictureRole role = PictureRole::Mask;
  std::string of;  // the photo's source; empty: all photos in its folder
};

struct FilmFile {
  std::filesystem::path path;
  std::string source;     // below the folder, with '/'
  bool of_photo = false;  // a photo of the same stem lies next to it, as for Live Photos
};

// A second set of the same photos, left out because its size is about that of the set used.
struct SecondSet {
  std::string used, left_out;  // folders
  size_t photos = 0;
};

// The same photo in another file, left out: the JPEG of a raw photo.
struct PhotoVersion {
  std::string source, of;
};

struct PhotoFolder {
  std::filesystem::path folder;
  std::vector<PhotoFile> photos;          // sorted by source, byte order
  std::map<std::string, size_t> skipped;  // lower-case extension ("" = none) -> files that are no supported photo
  std::vector<BesidePhoto> beside;        // sorted by source
  std::vector<std::string> like_photos;   // named like a mask, ... of another picture, but a photo by content
  std::vector<SecondSet> second_sets;
  std::vector<PhotoVersion> versions;  // sorted by the source of the photo
  std::vector<FilmFile> films;           // sorted by source; also counted in `skipped` until they are cut into frames
  std::vector<std::string> live_photos;  // films of photos, left out (core/intake/film/photos_and_films.h)
  FolderFiles listed;  // links, unreadable folders, junk; without its files
};

enum class FilmsAre { Skipped, Photos };
// Searches sub-folders and linked folders. Throws Error{Input} when the folder is missing, unreadable or contains no photo; for
// FilmsAre::Photos a folder of films alone is accepted.
PhotoFolder find_photos(const std::filesystem::path& folder, FilmsAre films = FilmsAre::Skipped);

// True for the extensions of films that cameras and programs write, in any case: .mp4 .mov .m4v .mkv .webm .avi ...
bool is_film_name(const std::filesystem::path& path);
// True for a film, and for a folder with films that belong to no photo: the frames become photos in the stage ingest.
bool gives_film_frames(const std::filesystem::path& given);

// Message to the user about a folder of photos.
struct FolderNote {
  std::string code;      // "MASKS_BESIDE_PHOTOS"
  bool warning = false;  // a left-out file may be missed; else the left-out files are no photos
  std::string what, why, hint;
  std::string sentence() const { return what + (why.empty() ? "" : " (" + why + ")") + ": " + hint; }
};
std::vector<FolderNote> notes_of(const PhotoFolder& folder);

// Assigns a name and stem to every photo. `photos` is sorted by source.
void assign_names(std::vector<PhotoFile>& photos);

// Metadata of a photo, read without decoding pixels.
struct PhotoHead {
  Probe probe;
  Exif exif;
  GPano gpano;
  Digest digest;                   // of the file's bytes
  std::vector<std::string> notes;  // omissions, assumptions, and data next to the picture (core/scene/image/picture_file.h)
  std::string aside;
  PhotoColor color;
  bool alpha = false;  // the file has an alpha channel
  RawBalance balance{};
};
// Throws Error{Input} when the file is empty, truncated, unsupported, too large, or in print colours. `balance`: of PhotoFile.
PhotoHead read_photo_head(const std::filesystem::path& path, const RawBalance& balance = {});

// "3 x .cr2, 1 x .txt"
std::string skipped_text(const PhotoFolder& folder);
// Files that contain photographs or video in an unsupported format.
size_t skipped_photo_like(const PhotoFolder& folder);

}  // namespace vitrine
