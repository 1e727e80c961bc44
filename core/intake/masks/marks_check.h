// Reads the entries of a file of marks. `vitrine run` checks the whole file against the photos before any stage runs; the masks
// stage, which has the cameras, reads the same entries.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "core/intake/masks/photo_marks.h"
#include "core/scene/camera/mask_class.h"

namespace vitrine {

// An entry of the list `marks`.
struct GivenMark {
  const YamlNode *node = nullptr, *photo = nullptr;  // the entry, and its value `photo`
  MaskClass kind = MaskClass::Object;
  std::string word;  // name of the object, or empty
  MarkedRegion region;
  Vec2d size{};  // of the marked photo, pixels

  std::string object() const;  // "transparent", "transparent case"
};

// The entries of the file; nullptr: an error was reported.
const YamlNode* mark_list(YamlReader& in);
// `size` of the file or of an entry; nullopt: absent, or an error was reported.
std::optional<Vec2d> mark_size(YamlReader& in, const YamlNode& map);
// nullopt: errors were reported. `common_size`: that of the file; `find_photo`: false if it reported an unknown photo.
std::optional<GivenMark> given_mark(YamlReader& in, const YamlNode& entry, const std::optional<Vec2d>& common_size,
                                    const std::function<bool(const YamlNode& photo)>& find_photo);
struct PhotoPixels {
  int width = 0, height = 0;
};
// True if the mark was drawn on a picture of the photo's aspect ratio (not checked without `photo`) and all its corners lie
// inside; else an error was reported.
bool mark_fits(YamlReader& in, const GivenMark& mark, const std::optional<PhotoPixels>& photo);
// Reports a second mark of one object in a photo.
void complain_of_second_mark(YamlReader& in, const GivenMark& mark);

struct MarkablePhotos {
  std::span<const std::string> names;                                       // in messages; empty: names are not known yet
  std::function<std::optional<size_t>(const YamlNode&, YamlReader&)> find;  // nullopt: an error was reported
  std::function<std::optional<PhotoPixels>(size_t)> size;                   // upright; nullopt: not known
};
// Throws Error{Usage} with the line of every mistake: unknown photos and classes, invalid outlines, marks outside the photo, of
// another aspect ratio or twice in one photo, objects marked in one photo only.
void check_marks(const std::filesystem::path& path, const MarkablePhotos& photos);

}  // namespace vitrine
