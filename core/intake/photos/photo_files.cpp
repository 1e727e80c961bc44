#include "core/intake/photos/photo_files.h"

#include <algorithm>
#include <set>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/picture_file.h"
#include "core/intake/photos/given_file.h"
#include "core/intake/photos/photo_versions.h"
#include "core/intake/photos/sorted_pictures.h"

namespace vitrine {

namespace {

const char* const kExtensions[] = {".jpg", ".jpeg", ".png", ".tif", ".tiff", ".exr"};
const char* const kPhotoLike[] = {".webp", ".bmp", ".gif", ".jp2", ".jxl", ".hdr"};
const char* const kFilms[] = {".mp4", ".mov", ".m4v", ".mkv", ".webm", ".avi", ".mts", ".m2ts", ".3gp", ".mpg", ".mpeg"};

template <size_t N>
bool contains(const char* const (&list)[N], const std::string& word) {
  return std::find(std::begin(list), std::end(list), word) != std::end(list);
}

[[noreturn]] void throw_unreadable(const fs::path& folder, const std::string& why,
                                   const std::string& hint = "check the path and its permissions") {
  throw Error(ErrorKind::Input, "cannot read the folder of photos",
              {.where = folder.string(), .why = why, .hint = hint, .code = "PHOTOS_UNREADABLE"});
}

// Replaces control characters and invalid UTF-8 by '_', for JSON and text lists.
std::string printable(const std::string& s) {
  std::string out;
  for (size_t i = 0; i < s.size();) {
    const size_t length = utf8_length(std::string_view(s).substr(i));
    if (length == 0 || (length == 1 && static_cast<unsigned char>(s[i]) < 0x20) || s[i] == 0x7f) {
      out += '_';
      ++i;
    } else {
      out.append(s, i, length);
      i += length;
    }
  }
  return out;
}

// "; 2 links lead to nothing; 1 folder cannot be opened", for a folder without photos.
std::string closed_text(const FolderFiles& listed) {
  std::string text;
  const auto add = [&](size_t n, const char* one, const char* several) {
    if (n > 0) text += fmt::format("; {} {}", n, n == 1 ? one : several);
  };
  add(listed.dangling.size(), "link leads to nothing", "links lead to nothing");
  add(listed.unreadable.size(), "folder cannot be opened", "folders cannot be opened");
  return text;
}

// Marks films that share folder and stem with a photo of any type.
void mark_live_photos(const std::vector<fs::path>& files, std::vector<FilmFile>& films) {
  std::set<std::string> photos;  // without extension, in lower case
  const auto stem = [](const fs::path& file) { return lowered(fs::path(file).replace_extension().generic_string()); };
  for (const fs::path& file : files) {
    const std::string extension = lowered(file.extension().string());
    if (contains(kExtensions, extension) || contains(kPhotoLike, extension)) photos.insert(stem(file));
  }
  for (FilmFile& film : films) film.of_photo = photos.contains(stem(film.source));
}

}  // namespace

bool is_film_name(const fs::path& path) { return contains(kFilms, lowered(path.extension().string())); }

bool gives_film_frames(const fs::path& given) {
  std::error_code ec;
  if (!fs::is_directory(given, ec)) return is_film_name(given);
  try {
    return !std::ranges::all_of(find_photos(given, FilmsAre::Photos).films, &FilmFile::of_photo);
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Input) throw;
    return false;  // no photo and no film
  }
}

PhotoFolder find_photos(const fs::path& folder, FilmsAre films) {
  std::error_code error;
  if (!fs::exists(folder, error)) throw_unreadable(folder, "it does not exist");
  if (!fs::is_directory(folder, error)) {
    if (is_film_name(folder))
      throw Error(ErrorKind::Input, "a film cannot be read here",
                  {.where = folder.string(),
                   .why = "`vitrine run` and `vitrine inspect` cut films into frames, others read photos",
                   .hint = "vitrine run FILM -o DIR --to ingest, then give DIR",
                   .code = "PHOTOS_UNREADABLE"});
    const GivenFile file = refusal_of_file(folder);
    throw_unreadable(folder, file.why, file.hint);
  }
  PhotoFolder found;
  found.folder = folder;
  found.listed = files_below(folder, ReachedTwice::Once, error);
  if (error) throw_unreadable(folder, error.message());
  for (const fs::path& file : found.listed.files) {
    const std::string extension = lowered(file.extension().string());
    if (contains(kExtensions, extension) || has_heif_extension(extension) || has_raw_extension(extension))
      found.photos.push_back({.path = folder / file, .source = file.generic_string(), .name = {}, .stem = {}});
    else
      ++found.skipped[extension];
    if (contains(kFilms, extension)) found.films.push_back({folder / file, file.generic_string()});
  }
  mark_live_photos(found.listed.files, found.films);
  found.listed.files.clear();
  if (found.photos.empty() && (films == FilmsAre::Skipped || found.films.empty())) {
    const std::string others = skipped_text(found);
    throw Error(ErrorKind::Input, "there are no photos in this folder",
                {.where = folder.string(),
                 .why = "looked for .jpg .jpeg .png .tif .tiff .exr .heic .heif .hif .avif and raw photos (also in sub-folders); found " +
                        (others.empty() ? "no files" : others) + closed_text(found.listed),
                 .hint = "give the folder that holds the photos; convert others to JPEG or 16-bit TIFF first",
                 .code = "NO_PHOTOS"});
  }
  sort_pictures(found);
  leave_out_versions(found);
  assign_names(found.photos);
  std::vector<fs::path> paths;
  for (const PhotoFile& photo : found.photos) paths.push_back(photo.path);
  const std::vector<RawBalance> balances = common_balance(paths);
  for (size_t i = 0; i < balances.size(); ++i) found.photos[i].balance = balances[i];
  return found;
}

void assign_names(std::vector<PhotoFile>& photos) {
  std::set<std::string> taken;
  for (PhotoFile& photo : photos) {
    const fs::path source(printable(photo.source));
    std::string extension = source.extension().string();
    const std::string plain = fs::path(source).replace_extension().generic_string();
    photo.stem = plain;
    for (int n = 1; !taken.insert(photo.stem).second; ++n) {
      photo.stem = fmt::format("{}_{}", plain, extension.substr(1));
      if (n > 1) photo.stem += fmt::format("_{}", n);
    }
    // The sfm stage writes an 8-bit picture under this name, for which .exr, .heic and raw are not possible.
    constexpr const char* kWritten[] = {".jpg", ".jpeg", ".png", ".tif", ".tiff"};
    if (!contains(kWritten, lowered(extension))) extension = ".png";
    photo.name = photo.stem + extension;
  }
}

PhotoHead read_photo_head(const fs::path& path, const RawBalance& balance) {
  const auto throw_unusable = [&](std::string why) {
    throw Error(
        ErrorKind::Input, "a photo cannot be used",
        {.where = path.string(), .why = std::move(why), .hint = "replace it or take it out of the folder", .code = "BAD_PHOTO"});
  };
  const std::string bytes = read_file(path);
  PictureFile file = examine_picture(bytes, path.extension().string());
  if (!file.refusal.empty()) throw_unusable(file.refusal);
  if (file.probe.format == PhotoFormat::Exr) file.notes = exr_notes(path);
  PhotoHead head{.probe = file.probe,
                 .exif = parse_exif(exif_block(bytes)),
                 .gpano = parse_gpano(bytes),
                 .digest = digest_bytes(bytes),
                 .notes = std::move(file.notes),
                 .aside = std::move(file.aside),
                 .color = {},
                 .alpha = has_alpha(bytes, file.probe.format),
                 .balance = balance};
  if (file.probe.format == PhotoFormat::Tiff) head.exif.orientation = file.probe.orientation;  // of the selected page
  if (file.probe.format == PhotoFormat::Heif) head.exif.orientation = 1;  // decoded upright
  if (file.probe.format == PhotoFormat::Raw) {
    const RawHead raw = raw_head(path);
    if (!raw.problem.empty()) throw_unusable(raw.problem);
    add_raw_facts(head.exif, raw.facts);
    head.probe.width = uint64_t(raw.facts.width), head.probe.height = uint64_t(raw.facts.height);
  }
  head.color = color_of(bytes, head.probe, head.exif);
  if (!head.color.refusal.empty()) throw_unusable(head.color.refusal);
  return head;
}

std::string skipped_text(const PhotoFolder& folder) {
  std::string text;
  for (const auto& [extension, count] : folder.skipped)
    text +=
        fmt::format("{}{} x {}", text.empty() ? "" : ", ", count, extension.empty() ? "without extension" : printable(extension));
  return text;
}

size_t skipped_photo_like(const PhotoFolder& folder) {
  size_t count = 0;
  for (const auto& [extension, n] : folder.skipped)
    if (contains(kPhotoLike, extension) || contains(kFilms, extension)) count += n;
  return count;
}

}  // namespace vitrine
