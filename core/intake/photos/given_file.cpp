#include "core/intake/photos/given_file.h"

#include <fstream>

#include "core/foundation/base/file.h"
#include "core/scene/image/probe.h"

namespace vitrine {

namespace {

struct Magic {
  std::string_view bytes;
  size_t at;
  FileKind kind;
};
// First bytes of the formats (APPNOTE.TXT of ZIP, RFC 1952, POSIX ustar, and the manuals of the others).
constexpr Magic kMagics[] = {
    {"PK\x03\x04", 0, FileKind::Archive}, {"PK\x05\x06", 0, FileKind::Archive},         {"\x1f\x8b", 0, FileKind::Archive},
    {"Rar!", 0, FileKind::Archive},       {"7z\xbc\xaf\x27\x1c", 0, FileKind::Archive}, {"\xfd\x37zXZ", 0, FileKind::Archive},
    {"BZh", 0, FileKind::Archive},        {"\x28\xb5\x2f\xfd", 0, FileKind::Archive},   {"ustar", 257, FileKind::Archive},
    {"%PDF-", 0, FileKind::Document},
};

}  // namespace

FileKind kind_of_file(const std::filesystem::path& file) {
  constexpr size_t kHead = 1 << 12;
  std::string head(kHead, '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<size_t>(std::max<std::streamsize>(in.gcount(), 0)));
  for (const Magic& m : kMagics)
    if (head.size() >= m.at + m.bytes.size() && std::string_view(head).substr(m.at, m.bytes.size()) == m.bytes) return m.kind;
  return probe_photo(head).format != PhotoFormat::Unknown ? FileKind::Photo : FileKind::Other;
}

GivenFile refusal_of_file(const std::filesystem::path& file) {
  std::error_code ec;
  const std::string folder = std::filesystem::absolute(file, ec).parent_path().string();
  switch (kind_of_file(file)) {
    case FileKind::Archive:
      return {"it is an archive, not a folder", "unpack it and give the folder of its photos"};
    case FileKind::Document:
      return {"it is a PDF document, not a folder",
              "export its pictures as JPEG or PNG into a folder (pdfimages -all FILE FOLDER/p) and give that"};
    case FileKind::Photo:
      return {"it is one photo, not a folder; a scene takes 20 to 60 photos from all sides",
              "give the folder that holds the photos: " + folder};
    case FileKind::Other:
      break;
  }
  return {"it is not a folder", "check the path and its permissions"};
}

}  // namespace vitrine
