// Finds the mask file of a photo under the naming conventions of other programs:
//
//   b.jpg.png             COLMAP, Brush
//   b.png, b.*            nerfstudio, LichtFeld, Postshot, COLMAP's fall-back; or an alpha channel
//   b_mask.*, mask_b.*    3DGRUT, ODM, openMVG; other words for it: core/intake/photos/picture_roles.h
//   b.mask.*              OpenMVS (labels: 0 = no, everything else = yes), Brush
//   dynamic_mask_b.png    instant-ngp: pixels that are not black move
//   mask_path of a transforms.json           <viewId>.png next to a Meshroom .sfm file
//
// in one folder per class (object/ transparent/ specular/ ignore/: mask_classes.h), or all in one folder, which then holds masks
// of the object. The folder may be that of the photos, with masks next to them; the photos themselves are then no masks. Values
// are as in the file: the caller sets whether black or white marks the class (polarity).
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/base/error.h"
#include "core/scene/camera/mask_class.h"
#include "core/scene/image/image.h"

namespace vitrine {

struct MaskFile {
  std::filesystem::path path;
  std::string convention;  // "b.jpg.png", "b_mask.*", ...: one of the rows above
};

class MaskFolder {
 public:
  // `path`: a folder, or a transforms.json. `flat`: the class of files outside any class folder. `photos`: the names of all
  // photos, with folders. Throws Error{Input}: no masks, or folders that are neither a class nor the photos'.
  explicit MaskFolder(const std::filesystem::path& path, MaskClass flat = MaskClass::Object,
                      const std::vector<std::string>& photos = {});

  const std::filesystem::path& path() const { return path_; }
  size_t file_count(MaskClass kind) const { return classes_[static_cast<size_t>(kind)].files; }
  // Masks by photo name, "left/b.jpg": first from a list (transforms.json, Meshroom), else by path, else by unique file name.
  // Throws Error{Input} when two files match a photo equally well.
  std::vector<std::optional<MaskFile>> match(MaskClass kind, std::span<const std::string> photos, Notes* notes = nullptr) const;
  std::optional<MaskFile> find(MaskClass kind, const std::string& photo) const;  // of one photo
  std::vector<std::filesystem::path> listed_files(MaskClass kind) const;         // that a list names, sorted, each once
  const Notes& notes() const { return notes_; }                                  // on the files

 private:
  struct Index {
    size_t files = 0;
    std::map<std::string, std::vector<MaskFile>> by_name, by_stem;  // lower-case keys
    std::vector<std::string> listed_photos;                         // photo names in lists, and
    std::vector<MaskFile> listed;                                   // their masks
    std::vector<std::filesystem::path> lists;                       // folders of the lists
  };
  void add_folder(MaskClass flat, const std::vector<std::string>& photos);
  // `relative`: path of the file, to be compared with photo names.
  void add(MaskClass kind, const std::filesystem::path& file, const std::filesystem::path& relative);
  void add_beside(MaskClass kind, const std::filesystem::path& file, const std::string& photo);
  void add_transforms(MaskClass kind, const std::filesystem::path& json);
  void add_meshroom(MaskClass kind, const std::filesystem::path& json);
  void add_listed(MaskClass kind, const std::string& photo, MaskFile mask, const std::filesystem::path& list);
  static std::optional<MaskFile> called_like(const Index& index, const std::string& photo);
  std::filesystem::path path_;
  Notes notes_;
  std::array<Index, kMaskClassCount> classes_;
  std::set<std::string> photo_stems_;  // lower-case keys, with folders and without
};

// The mask files that a transforms.json given as masks refers to (mask_path) and that exist, sorted, each once. Empty for other
// paths, and for a file that cannot be read as one: its reader reports that.
std::vector<std::filesystem::path> files_of_mask_list(const std::filesystem::path& masks);

// One channel in [0, 1]. Colour is converted to luma; a varying alpha channel takes precedence over colour; a file of small
// integers is a label map, also with white for void, which is no label (`void_label` becomes true). Throws Error{Input}:
// unreadable, or a colour photo.
ImageF read_mask(const MaskFile& file, bool* void_label = nullptr);

// Statistics of the masks of one class, to detect inverted masks.
struct MaskExtent {
  double mean = 0, border = 0, centre = 0;  // mean of the mask; of its outermost twentieth; of the middle third
  size_t masks = 0, empty = 0, full = 0;    // empty: black up to noise; full: white up to noise
  void add(const ImageF& mask);             // updates the running means
};
// A marked region is usually smaller than the rest and does not touch the border: true when both are reversed. Only a hint:
// photos of a window may be glass up to the border.
bool looks_inverted(const MaskExtent& extent);

}  // namespace vitrine
