#include "core/intake/photos/photo_versions.h"

#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/intake/photos/raw_photo.h"
#include "core/scene/image/ldr.h"

namespace vitrine {

namespace {

enum class Kind { Jpeg, Heif, Raw, Developed };  // the preferred last

Kind kind_of(const PhotoFile& photo) {
  const std::string extension = lowered(photo.path.extension().string());
  if (has_raw_extension(extension)) return Kind::Raw;
  if (has_heif_extension(extension)) return Kind::Heif;
  return extension == ".jpg" || extension == ".jpeg" ? Kind::Jpeg : Kind::Developed;
}

bool is_readable(Kind kind, const fs::path& path) {
  try {
    if (kind == Kind::Raw) return raw_head(path).problem.empty();
    return kind != Kind::Heif || !read_srgb8(path).empty();
  } catch (const Error& e) {
    if (e.kind() == ErrorKind::Input) return false;
    throw;
  }
}

std::string time_of(const fs::path& path) { return parse_exif(exif_block(read_file(path))).time; }

bool same_time(const fs::path& a, const fs::path& b) {
  const std::string first = time_of(a), second = time_of(b);
  return first.empty() || second.empty() || first == second;
}

}  // namespace

bool has_heif_extension(const std::string& extension) {
  return extension == ".heic" || extension == ".heif" || extension == ".hif" || extension == ".avif";
}

void leave_out_versions(PhotoFolder& folder) {
  std::map<std::string, std::vector<size_t>> groups;
  for (size_t i = 0; i < folder.photos.size(); ++i)
    groups[lowered(fs::path(folder.photos[i].source).replace_extension().generic_string())].push_back(i);
  std::map<Kind, bool> readable;  // by the first file of a kind
  const auto rank = [&](size_t i) {
    const Kind kind = kind_of(folder.photos[i]);
    if (!readable.contains(kind)) readable[kind] = is_readable(kind, folder.photos[i].path);
    return readable[kind] ? static_cast<int>(kind) + 1 : 0;
  };
  std::vector<uint8_t> out(folder.photos.size(), 0);
  for (auto& [stem, files] : groups) {
    const bool camera_file = std::any_of(files.begin(), files.end(), [&](size_t i) {
      const Kind kind = kind_of(folder.photos[i]);
      return kind == Kind::Heif || kind == Kind::Raw;
    });
    if (files.size() < 2 || !camera_file) continue;
    const size_t used = *std::max_element(files.begin(), files.end(), [&](size_t a, size_t b) { return rank(a) < rank(b); });
    for (const size_t i : files) {
      if (i == used || !same_time(folder.photos[i].path, folder.photos[used].path)) continue;
      out[i] = 1;
      folder.versions.push_back({.source = folder.photos[i].source, .of = folder.photos[used].source});
    }
  }
  for (BesidePhoto& file : folder.beside)
    for (const PhotoVersion& version : folder.versions)
      if (file.of == version.source) file.of = version.of;
  std::vector<PhotoFile> kept;
  for (size_t i = 0; i < out.size(); ++i)
    if (!out[i]) kept.push_back(std::move(folder.photos[i]));
  folder.photos = std::move(kept);
}

}  // namespace vitrine
