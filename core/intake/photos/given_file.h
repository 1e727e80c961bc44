// Recognises a file that was given instead of a folder of photos, for the error message: an archive, a PDF document, one photo.
#pragma once

#include <filesystem>
#include <string>

namespace vitrine {

enum class FileKind : unsigned char { Archive, Document, Photo, Other };
// By its first bytes. Files that cannot be opened are Other.
FileKind kind_of_file(const std::filesystem::path& file);

struct GivenFile {
  std::string why, hint;  // of the error
};
GivenFile refusal_of_file(const std::filesystem::path& file);

}  // namespace vitrine
