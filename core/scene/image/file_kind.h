// Detection of unsupported file types by their first bytes: other image formats, videos, archives, and HTML pages or Git LFS
// pointers that downloads save under a photo's name. Avoids reporting an intact file as damaged.
#pragma once

#include <string>
#include <string_view>

namespace vitrine {

struct FileKind {
  std::string name;        // "a HEIC photo"; empty if unknown
  std::string advice;      // suggested action
  bool decodable = false;  // supported for masks, not for photos: BMP, WebP, PNM
  bool heif = false;       // HEIC or AVIF (core/scene/image/heif_file.h)
  bool raw = false;        // raw photo that is no TIFF (those: core/scene/image/tiff_pages.h)
};

FileKind file_kind(std::string_view bytes);
// "it is a HEIC photo, called .jpg: ..."; for unknown content its first bytes. `extension` includes the dot, or is empty.
std::string foreign_content(std::string_view bytes, std::string_view extension);

}  // namespace vitrine
