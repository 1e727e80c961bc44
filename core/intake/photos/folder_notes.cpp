// User messages about a folder of photos, shared by inspect (before a run) and ingest (during it).
#include "core/foundation/base/error.h"
#include "core/intake/photos/photo_files.h"

namespace vitrine {

namespace {

constexpr size_t kNamed = 3;

// "a.jpg, b.jpg, c.jpg and 4 more"
template <class List, class F>
std::string some(const List& list, F&& name) {
  std::string text;
  size_t n = 0;
  for (const auto& entry : list)
    if (++n <= kNamed) text += fmt::format("{}{}", n > 1 ? ", " : "", name(entry));
  return n > kNamed ? fmt::format("{} and {} more", text, n - kNamed) : text;
}
std::string some(const std::vector<std::string>& names) {
  return some(names, [](const std::string& name) { return name; });
}

std::string count(size_t n, const char* one, const char* several) { return fmt::format("{} {}", n, n == 1 ? one : several); }

std::string code_of(PictureRole role) {
  constexpr const char* codes[] = {
      "MASKS_BESIDE_PHOTOS",      "CUTOUTS_BESIDE_PHOTOS", "DEPTH_BESIDE_PHOTOS",  "NORMALS_BESIDE_PHOTOS",
      "CONFIDENCE_BESIDE_PHOTOS", "LABELS_BESIDE_PHOTOS",  "PASSES_BESIDE_PHOTOS", "REDUCED_COPIES"};
  return codes[static_cast<size_t>(role)];
}

std::string hint_of(PictureRole role, const std::string& folder) {
  switch (role) {
    case PictureRole::Mask:
      return fmt::format("they are left out of the photos; --masks {} uses them", folder);
    case PictureRole::Cutout:
      return fmt::format("they are left out of the photos; --masks {} uses their alpha channels as masks of the object", folder);
    case PictureRole::Depth:
      return fmt::format("they are left out of the photos; --depth {} uses them", folder);
    case PictureRole::Confidence:
      return "they are left out; confidence maps are not used";
    case PictureRole::Labels:
      return "they are left out; --masks DIR uses masks of one class each, white where the photo shows it";
    case PictureRole::Pass:
      return "they are left out; passes of renderers are not used";
    case PictureRole::Normals:
      return "they are left out of the photos; --normals DIR uses maps in a folder of their own";
    case PictureRole::Copy:
      return "they are left out, the larger ones are used; give the folder of the copies to use those";
  }
  return {};
}

}  // namespace

std::vector<FolderNote> notes_of(const PhotoFolder& folder) {
  std::vector<FolderNote> notes;
  const std::string where = folder.folder.string();
  if (const size_t unread = skipped_photo_like(folder); unread > 0)
    notes.push_back({"PHOTO_TYPES_NOT_READ", true,
                     count(unread, "file holds a photo or video in a form that is not read",
                           "files hold photos or video in a form that is not read"),
                     skipped_text(folder), "convert them to JPEG or 16-bit TIFF to use them"});
  if (!folder.live_photos.empty())
    notes.push_back({"FILMS_OF_PHOTOS", false,
                     count(folder.live_photos.size(), "film belongs to a photo of the same name (Live Photo)",
                           "films belong to photos of the same name (Live Photos)"),
                     some(folder.live_photos), "left out; give a film by itself to use its frames"});
  for (const PictureRole role : kPictureRoles) {
    std::vector<const BesidePhoto*> files;
    for (const BesidePhoto& file : folder.beside)
      if (file.role == role) files.push_back(&file);
    if (files.empty()) continue;
    const std::string what = files.size() == 1 ? fmt::format("1 file is {} of another file", singular(role))
                                               : fmt::format("{} files are {} of other files", files.size(), plural(role));
    notes.push_back(
        {code_of(role), role == PictureRole::Mask || role == PictureRole::Cutout, what,
         some(files,
              [](const BesidePhoto* f) { return fmt::format("{} of {}", f->source, f->of.empty() ? "all photos" : f->of); }),
         hint_of(role, where)});
  }
  for (const SecondSet& set : folder.second_sets) {
    const auto named = [&](const std::string& name) { return name.empty() ? where : name; };
    notes.push_back({"PHOTOS_IN_TWO_VERSIONS", true,
                     fmt::format("{} and {} hold {} in two versions", named(set.used), named(set.left_out),
                                 count(set.photos, "photo", "photos")),
                     "the same names, much the same pictures",
                     fmt::format("{} is used, {} is left out; give the folder {} to use that", named(set.used),
                                 named(set.left_out), (folder.folder / set.left_out).string())});
  }
  if (!folder.versions.empty())
    notes.push_back(
        {"PHOTOS_IN_TWO_FORMATS", false,
         count(folder.versions.size(), "file holds a photo that another file holds too",
               "files hold photos that other files hold too"),
         some(folder.versions, [](const PhotoVersion& v) { return fmt::format("{} is left out for {}", v.source, v.of); }),
         "TIFF, PNG and EXR are used before raw, raw before HEIC and JPEG; move out of the folder what is not wanted"});
  if (!folder.like_photos.empty())
    notes.push_back({"PHOTOS_CALLED_LIKE_MASKS", false,
                     count(folder.like_photos.size(), "file is called like a mask or map of another one and looks like a photo",
                           "files are called like masks or maps of others and look like photos"),
                     some(folder.like_photos), "taken for photos; move them out of the folder if they are none"});
  const FolderFiles& listed = folder.listed;
  if (!listed.dangling.empty())
    notes.push_back({"LINKS_BROKEN", true, count(listed.dangling.size(), "link leads to nothing", "links lead to nothing"),
                     some(listed.dangling), "left out; is a disk missing, or was a folder moved?"});
  if (!listed.circles.empty())
    notes.push_back(
        {"LINKS_IN_A_CIRCLE", true,
         count(listed.circles.size(), "link leads to a folder that it lies in", "links lead to folders that they lie in"),
         some(listed.circles), "not followed"});
  if (!listed.repeated.empty())
    notes.push_back({"LINKS_TO_THE_SAME", false,
                     count(listed.repeated.size(), "link leads to what is in the folder already",
                           "links lead to what is in the folder already"),
                     some(listed.repeated), "counted once"});
  if (!listed.unreadable.empty())
    notes.push_back({"FOLDERS_CLOSED", true,
                     count(listed.unreadable.size(), "folder cannot be opened", "folders cannot be opened"),
                     some(listed.unreadable), "left out; check the permissions"});
  return notes;
}

}  // namespace vitrine
