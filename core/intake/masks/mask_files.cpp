#include "core/intake/masks/mask_files.h"

#include <algorithm>
#include <cctype>
#include <set>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/folder_files.h"
#include "core/foundation/config/json_file.h"
#include "core/foundation/config/photo_name_finder.h"
#include "core/intake/masks/mask_classes.h"
#include "core/intake/photos/given_file.h"
#include "core/intake/photos/named_file.h"
#include "core/intake/photos/photo_files.h"
#include "core/intake/photos/picture_content.h"

namespace vitrine {

namespace {

const std::set<std::string> kMaskExtensions{".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".webp"};

bool is_picture(const fs::path& path) { return kMaskExtensions.contains(lowered(path.extension().string())); }

// "left/b.jpg" -> "left/b", in lower case.
std::string stem_key(const std::string& photo) { return lowered(fs::path(photo).replace_extension().generic_string()); }

// Maps each mask in a photo folder, detected by name and content, to its photo. Empty for other folders.
std::map<std::string, std::string> masks_beside_photos(const fs::path& folder) {
  std::map<std::string, std::string> masks;
  for (const BesidePhoto& file : companions_in(folder))
    if (!file.of.empty() && (file.role == PictureRole::Mask || (file.role == PictureRole::Cutout && varying_alpha(file.path))))
      masks[file.source] = file.of;
  return masks;
}

bool in_folder_of_masks(const fs::path& name) {
  const fs::path folder = name.parent_path();
  return std::any_of(folder.begin(), folder.end(), [](const fs::path& part) {
    return role_of_folder(part.string()) == PictureRole::Mask || is_class_folder(part.string());
  });
}

std::string joined(const fs::path& folder, const std::string& base) { return lowered((folder / base).generic_string()); }

// Refuses files given as masks that hold no pictures and name none, with what to export instead.
void refuse_file_without_masks(const fs::path& file) {
  const auto refuse = [&](const std::string& why, const char* hint) {
    throw Error(ErrorKind::Input, "there are no masks",
                {.where = file.string(), .why = why, .hint = hint, .code = "MASKS_MISSING"});
  };
  constexpr const char* kPictures =
      "export masks as pictures, one for each photo (CVAT: Segmentation mask), and give their folder";
  switch (kind_of_file(file)) {
    case FileKind::Archive:
      refuse("this is an archive", "unpack it, and give the folder of the masks");
      break;
    case FileKind::Document:
      refuse("this is a PDF document", kPictures);
      break;
    case FileKind::Photo:
      refuse("this is one picture", "give the folder of the masks: one for each photo, with its name");
      break;
    case FileKind::Other:
      break;
  }
  const DocumentOutline outline = document_outline(file);
  if (!outline.xml_root.empty())
    refuse(outline.xml_root.starts_with("annotation") ? "this file holds annotations (CVAT, Pascal VOC), no pictures"
                                                      : "this is an XML file",
           kPictures);
  if (!outline.json || !outline.json->complete || outline.json->has("frames")) return;
  if (outline.json->has("annotations")) refuse("this file holds annotations (COCO), no pictures", kPictures);
  if (outline.json->has("shapes")) refuse("this file holds annotations (labelme), no pictures", kPictures);
  refuse("this is JSON without 'frames' that have a mask_path", "give a folder of masks, or a transforms.json with mask_path");
}

// Selects one of several mask candidates of a photo: a name with "mask" takes precedence over the plain photo name, which may be
// the photo itself.
MaskFile one_of(const std::vector<MaskFile>& files, const std::string& photo) {
  for (std::string_view convention :
       {"mask_path", "<viewId>.png", "dynamic_mask_b.png", "b.mask.*", "b_mask.*", "b.jpg.png", "b.*"}) {
    std::vector<const MaskFile*> same;
    for (const MaskFile& f : files)
      if (f.convention == convention) same.push_back(&f);
    if (same.size() > 1)
      throw Error(ErrorKind::Input, "two files claim to be the mask of one photo",
                  {.where = photo,
                   .why = fmt::format("{} and {}", same[0]->path.string(), same[1]->path.string()),
                   .hint = "remove or rename one of them",
                   .code = "MASKS_AMBIGUOUS"});
    if (same.size() == 1) return *same[0];
  }
  VITRINE_CHECK(false, "a mask of an unknown convention");
  return {};
}

}  // namespace

MaskFolder::MaskFolder(const fs::path& path, MaskClass flat, const std::vector<std::string>& photos) : path_(path) {
  for (const std::string& photo : photos) {
    const std::string file = fs::path(photo).filename().generic_string();
    photo_stems_.insert({stem_key(photo), stem_key(file)});
  }
  std::error_code ec;
  if (fs::is_regular_file(path, ec)) {
    refuse_file_without_masks(path);
    add_transforms(flat, path);
    return;
  }
  if (!fs::is_directory(path, ec))
    throw Error(
        ErrorKind::Input, "there are no masks",
        {.where = path.string(), .hint = "give a folder of masks, or a transforms.json with mask_path", .code = "MASKS_MISSING"});
  add_folder(flat, photos);
}

void MaskFolder::add_folder(MaskClass flat, const std::vector<std::string>& photos) {
  std::error_code ec;
  const FolderFiles listed = files_below(path_, ReachedTwice::Always, ec);
  if (ec || !listed.unreadable.empty())
    throw Error(ErrorKind::Input, "cannot read the folder of masks",
                {.where = (ec ? path_ : path_ / listed.unreadable[0]).string(),
                 .why = ec ? ec.message() : "it cannot be opened",
                 .hint = "check its permissions",
                 .code = "MASKS_UNREADABLE"});
  // Read the mask lists of other programs first: folders of the files listed there are no classes.
  std::set<fs::path> scenes;
  for (const fs::path& name : listed.files) {
    const std::string extension = lowered(name.extension().string());
    const bool transforms = lowered(name.filename().string()).starts_with("transforms") && extension == ".json";
    if (!transforms && extension != ".sfm") continue;
    const MaskClass kind = mask_class(lowered(name.begin()->string())).value_or(flat);
    if (transforms) {
      add_transforms(kind, path_ / name);
    } else {
      add_meshroom(kind, path_ / name);
      scenes.insert(name.parent_path());
    }
  }
  std::set<fs::path> named;
  for (const Index& index : classes_)
    for (const MaskFile& file : index.listed) named.insert(file.path.lexically_normal());

  const std::map<std::string, std::string> photo_of = masks_beside_photos(path_);
  MaskClassFolders classes(path_, flat, photos);
  for (const fs::path& name : listed.files) {
    const fs::path file = path_ / name;
    if (!is_picture(file) || lowered(name.filename().string()) == "contact_sheet.png") continue;
    const auto photo = photo_of.find(name.generic_string());
    // In a folder of photos, skip the photos and their other companions.
    if (!photo_of.empty() && photo == photo_of.end() && !in_folder_of_masks(name)) continue;
    const std::string top = lowered(name.begin()->string());
    if (name.has_parent_path() && (top == "colmap" || top == "confidence"))
      continue;  // written by this program next to the classes
    if (named.contains(file.lexically_normal())) continue;
    if (scenes.contains(name.parent_path())) {
      const auto kind = name.has_parent_path() ? mask_class(top) : std::nullopt;
      add(kind.value_or(flat), file, kind ? name.lexically_relative(*name.begin()) : name);
      continue;
    }
    const auto place = classes.place(name);
    if (!place) continue;
    if (photo != photo_of.end())
      add_beside(place->kind, file, photo->second);
    else
      add(place->kind, file, place->name);
  }
  classes.throw_if_unknown();
}

void MaskFolder::add_beside(MaskClass kind, const fs::path& file, const std::string& photo) {
  if (kind == MaskClass::Object && lowered(file.filename().string()).starts_with("dynamic_mask")) kind = MaskClass::Ignore;
  Index& index = classes_[static_cast<size_t>(kind)];
  ++index.files;
  index.by_name[lowered(photo)].push_back({file, "b_mask.*"});
  index.by_stem[stem_key(photo)].push_back({file, "b_mask.*"});
}

void MaskFolder::add(MaskClass kind, const fs::path& file, const fs::path& relative) {
  const fs::path folder = relative.parent_path();
  const std::string base = relative.stem().string();
  const std::string low = lowered(base);
  constexpr std::string_view kDynamic = "dynamic_mask_";
  // instant-ngp's masks mark moving objects, whatever lies next to them.
  if (low.starts_with(kDynamic)) {
    Index& index = classes_[static_cast<size_t>(kind == MaskClass::Object ? MaskClass::Ignore : kind)];
    ++index.files;
    index.by_stem[joined(folder, base.substr(kDynamic.size()))].push_back({file, "dynamic_mask_b.png"});
    return;
  }
  Index& index = classes_[static_cast<size_t>(kind)];
  ++index.files;
  // The name may be that of a photo: carnival_mask.jpg has the mask carnival_mask.png.
  const bool is_photo = photo_stems_.contains(joined(folder, base)) || photo_stems_.contains(low);
  if (!is_photo)
    for (const NamedRole& role : roles_of_stem(base)) {
      if (role.role != PictureRole::Mask || role.of == base) continue;
      const std::string convention = low.ends_with(".mask") ? "b.mask.*" : "b_mask.*";
      if (has_photo_extension(role.of))
        index.by_name[joined(folder, role.of)].push_back({file, convention});
      else
        index.by_stem[joined(folder, role.of)].push_back({file, convention});
      break;
    }
  // "b.jpg.png" may also belong to a photo "b.jpg.tif".
  if (has_photo_extension(base)) index.by_name[joined(folder, base)].push_back({file, "b.jpg.png"});
  index.by_stem[joined(folder, base)].push_back({file, "b.*"});
}

void MaskFolder::add_transforms(MaskClass kind, const fs::path& path) {
  size_t named = 0, missing = 0;
  std::string first_missing;
  read_json_file(path, "transforms.json", [&](const nlohmann::json& j) {
    const JsonAt top(j);
    if (!top.has("frames")) return;
    const JsonAt frames = top.at("frames");
    frames.list("a list of frames");
    for (size_t i = 0; i < frames.size(); ++i) {
      const JsonAt frame = frames[i];
      if (!frame.has("mask_path")) continue;
      const JsonAt written = frame.at("mask_path");
      ++named;
      if (const auto mask = named_file(path.parent_path(), written))
        add_listed(kind, frame.at("file_path").text(), {*mask, "mask_path"}, path);
      else if (missing++ == 0)
        first_missing = written.text();
    }
  });
  if (missing == 0) return;
  const std::string why =
      fmt::format("{} of {} files that mask_path names do not exist, for example '{}'", missing, named, first_missing);
  if (missing == named)
    throw Error(
        ErrorKind::Input, "the masks of a transforms.json are not there",
        {.where = path.string(), .why = why, .hint = "paths of masks start at the folder of this file", .code = "MASKS_MISSING"});
  notes_.push_back({"MASKS_MISSING_FILES", path.string() + ": " + why});
}

void MaskFolder::add_meshroom(MaskClass kind, const fs::path& path) {
  read_json_file(path, "Meshroom scene", [&](const nlohmann::json& j) {
    const JsonAt top(j);
    if (!top.has("views")) return;
    const JsonAt views = top.at("views");
    views.list("a list of views");
    for (size_t i = 0; i < views.size(); ++i) {
      const JsonAt view = views[i], id = view.at("viewId");
      const std::string number = id.value().is_number_unsigned() ? std::to_string(id.value().get<uint64_t>()) : id.text();
      const fs::path mask = path_inside(path.parent_path(), number + ".png");
      std::error_code ec;
      if (fs::exists(mask, ec)) add_listed(kind, view.at("path").text(), {mask, "<viewId>.png"}, path);
    }
  });
}

void MaskFolder::add_listed(MaskClass kind, const std::string& photo, MaskFile mask, const fs::path& list) {
  Index& index = classes_[static_cast<size_t>(kind)];
  ++index.files;
  index.listed_photos.push_back(photo);
  index.listed.push_back(std::move(mask));
  if (std::find(index.lists.begin(), index.lists.end(), list.parent_path()) == index.lists.end())
    index.lists.push_back(list.parent_path());
}

std::vector<fs::path> MaskFolder::listed_files(MaskClass kind) const {
  std::set<fs::path> files;
  for (const MaskFile& file : classes_[static_cast<size_t>(kind)].listed) files.insert(file.path);
  return {files.begin(), files.end()};
}

std::vector<fs::path> files_of_mask_list(const fs::path& masks) {
  std::error_code ec;
  if (!fs::is_regular_file(masks, ec)) return {};
  try {
    return MaskFolder(masks).listed_files(MaskClass::Object);
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Input) throw;
    return {};
  }
}

std::vector<std::optional<MaskFile>> MaskFolder::match(MaskClass kind, std::span<const std::string> photos, Notes* notes) const {
  const Index& index = classes_[static_cast<size_t>(kind)];
  std::vector<std::vector<MaskFile>> listed(photos.size());
  const PhotoNameFinder finder(photos);
  const std::vector<PhotoMatch> matches = finder.match(index.listed_photos, index.lists);
  size_t ambiguous = 0;
  for (size_t i = 0; i < matches.size(); ++i) {
    if (const auto photo = matches[i].photo) {
      std::vector<MaskFile>& files = listed[*photo];
      const bool known =
          std::any_of(files.begin(), files.end(), [&](const MaskFile& f) { return f.path == index.listed[i].path; });
      if (!known) files.push_back(index.listed[i]);
    }
    if (!matches[i].could_be.empty() && ambiguous++ == 0 && notes != nullptr)
      notes->push_back(
          {"MASKS_AMBIGUOUS_NAMES", fmt::format("the mask {} belongs to no photo: '{}' may be {}", index.listed[i].path.string(),
                                                index.listed_photos[i], vitrine::listed(finder, matches[i].could_be))});
  }
  if (ambiguous > 1 && notes != nullptr) notes->back().text += fmt::format("; so it is with {} more masks", ambiguous - 1);
  std::vector<std::optional<MaskFile>> out;
  for (size_t i = 0; i < photos.size(); ++i)
    out.push_back(listed[i].empty() ? called_like(index, photos[i]) : std::optional(one_of(listed[i], photos[i])));
  return out;
}

std::optional<MaskFile> MaskFolder::find(MaskClass kind, const std::string& photo) const {
  return match(kind, std::span(&photo, 1))[0];
}

std::optional<MaskFile> MaskFolder::called_like(const Index& index, const std::string& photo) {
  const std::string full = lowered(photo), stem = stem_key(photo);
  const std::string file_name = lowered(fs::path(photo).filename().generic_string()), file_stem = stem_key(file_name);
  for (const auto& [map, key] : {std::pair{&index.by_name, full}, std::pair{&index.by_stem, stem},
                                 std::pair{&index.by_name, file_name}, std::pair{&index.by_stem, file_stem}})
    if (const auto found = map->find(key); found != map->end()) return one_of(found->second, photo);
  // By unique file name in any folder.
  std::vector<MaskFile> anywhere;
  for (const auto& [map, wanted] : {std::pair{&index.by_name, file_name}, std::pair{&index.by_stem, file_stem}})
    for (const auto& [key, files] : *map)
      if (fs::path(key).filename().generic_string() == wanted)
        for (const MaskFile& file : files)  // a file may be listed under both keys
          if (std::none_of(anywhere.begin(), anywhere.end(), [&](const MaskFile& a) { return a.path == file.path; }))
            anywhere.push_back(file);
  if (anywhere.size() == 1) return anywhere[0];
  return std::nullopt;
}

}  // namespace vitrine
