// What a file is that is none of the pictures we read, by its first bytes: other pictures, films, archives, pages and pointers
// that downloads leave under the name of a photo. So that a whole file is not called damaged.
#pragma once

#include <string>
#include <string_view>

namespace vitrine {

struct FileKind {
  std::string name;        // "a HEIC photo"; empty when it is not known
  std::string advice;      // what to do with it
  bool decodable = false;  // our codecs read it where it is no photo (masks): BMP, WebP, PNM
};

FileKind file_kind(std::string_view bytes);
// "it is a HEIC photo, called .jpg: ..."; for unknown content its first bytes. `extension` with its dot, or empty.
std::string foreign_content(std::string_view bytes, std::string_view extension);

}  // namespace vitrine
