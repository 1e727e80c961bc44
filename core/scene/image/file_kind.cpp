#include "core/scene/image/file_kind.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace vitrine {

namespace {

using namespace std::string_view_literals;

constexpr std::string_view kConvert = "convert it to JPEG or 16-bit TIFF";
constexpr std::string_view kDevelop = "develop it and export a 16-bit TIFF or a JPEG", kRaw = "a raw photo";
constexpr std::string_view kFetch = "fetch the picture itself";
constexpr std::string_view kUnpack = "unpack it";
constexpr std::string_view kFrames = "extract its frames as pictures";

struct Magic {
  size_t at;
  std::string_view bytes, name, advice;
};

// The first match is used.
constexpr Magic kMagics[] = {
    {0, "\0\0\0\x0cJXL \r\n\x87\n"sv, "a JPEG XL picture", kConvert},
    {0, "\xff\x0a"sv, "a JPEG XL picture", kConvert},
    {0, "\0\0\0\x0cjP  \r\n\x87\n"sv, "a JPEG 2000 picture", kConvert},
    {0, "\xff\x4f\xff\x51"sv, "a JPEG 2000 picture", kConvert},
    {0, "II\xbc"sv, "a JPEG XR picture", kConvert},
    {0, "GIF8"sv, "a GIF", kConvert},
    {0, "8BPS"sv, "a Photoshop document", kConvert},
    {0, "gimp xcf"sv, "a GIMP document", kConvert},
    {0, "#?RADIANCE"sv, "a Radiance HDR picture", "convert it to OpenEXR"},
    {0, "#?RGBE"sv, "a Radiance HDR picture", "convert it to OpenEXR"},
    {0, "\x76\x2f\x31\x01"sv, "an OpenEXR picture", "save it as PNG"},
    {0, "qoif"sv, "a QOI picture", kConvert},
    {0, "DDS "sv, "a DDS texture", kConvert},
    {0, "\xabKTX"sv, "a KTX texture", kConvert},
    {0, "BPG\xfb"sv, "a BPG picture", kConvert},
    {0, "FLIF"sv, "a FLIF picture", kConvert},
    {0, "SIMPLE  ="sv, "a FITS picture", kConvert},
    {128, "DICM"sv, "a DICOM picture", kConvert},
    {0, "icns"sv, "an icon of macOS", "take it out of the folder"},
    {0, "FUJIFILMCCD-RAW"sv, "a raw photo (RAF)", kDevelop},
    {0, "IIRO"sv, "a raw photo (ORF)", kDevelop},
    {0, "IIRS"sv, "a raw photo (ORF)", kDevelop},
    {0, "MMOR"sv, "a raw photo (ORF)", kDevelop},
    {0, "IIU\0"sv, "a raw photo (RW2)", kDevelop},
    {0, "\0MRM"sv, "a raw photo (MRW)", kDevelop},
    {0, "FOVb"sv, "a raw photo (X3F)", kDevelop},
    {6, "HEAPCCDR"sv, "a raw photo (CRW)", kDevelop},
    {0, "\x1a\x45\xdf\xa3"sv, "a film (Matroska, WebM)", kFrames},
    {0, "%PDF"sv, "a PDF", "export its pictures"},
    {0, "PK\x03\x04"sv, "a ZIP archive", kUnpack},
    {0, "7z\xbc\xaf\x27\x1c"sv, "a 7z archive", kUnpack},
    {0, "Rar!"sv, "a RAR archive", kUnpack},
    {0, "\x1f\x8b"sv, "a gzip archive", kUnpack},
    {0, "\x28\xb5\x2f\xfd"sv, "a zstd archive", kUnpack},
    {0, "BZh"sv, "a bzip2 archive", kUnpack},
    {257, "ustar"sv, "a tar archive", kUnpack},
    {0, "\0\x05\x16\x07"sv, "a resource fork of macOS (AppleDouble)", "take it out of the folder"},
    {0,
     "\0\0\0\x01"
     "Bud1"sv,
     "a folder file of macOS", "take it out of the folder"},
    {0, "bplist"sv, "a property list of macOS", "take it out of the folder"},
    {0, "version https://git-lfs"sv, "a pointer of Git LFS", "fetch the picture itself with: git lfs pull"},
    {0, "/annex/objects/"sv, "a pointer of git-annex", "fetch the picture itself with: git annex get"},
    {0, "../.git/annex/"sv, "a pointer of git-annex", "fetch the picture itself with: git annex get"},
    {0, "\x89PNG"sv, "a PNG whose line ends were converted (a transfer as text)", "copy it again as binary"},
};

FileKind boxed_kind(std::string_view b) {  // ISO base media: size of the first box, "ftyp", brands
  const size_t size = std::min<size_t>(static_cast<unsigned char>(b[2]) << 8 | static_cast<unsigned char>(b[3]), b.size());
  const std::string_view major = b.substr(8, 4), brands = b.substr(8, std::max<size_t>(size, 12) - 8);
  const auto among = [&](std::initializer_list<std::string_view> words) {
    return std::any_of(words.begin(), words.end(), [&](std::string_view w) { return brands.find(w) != std::string_view::npos; });
  };
  if (major == "crx ") return {.name = "a raw photo (CR3)", .advice = std::string(kDevelop), .raw = true};
  if (among({"avif", "avis"})) return {.name = "an AVIF picture", .advice = std::string(kConvert), .heif = true};
  if (among({"heic", "heix", "heim", "heis", "hevc", "hevx", "mif1", "msf1"}))
    return {.name = "a HEIC photo",
            .advice = fmt::format("{} (on an iPhone: Settings, Camera, Formats, \"Most Compatible\")", kConvert),
            .heif = true};
  if (major == "qt  ") return {"a film (QuickTime)", std::string(kFrames)};
  return {"a film (MP4)", std::string(kFrames)};
}

// Markup and text. A byte order mark and white space may precede.
FileKind text_kind(std::string_view b) {
  constexpr size_t kLooked = 1024;
  std::string start(b.substr(0, kLooked));
  if (start.starts_with("\xef\xbb\xbf")) start.erase(0, 3);
  start.erase(0, std::min(start.find_first_not_of(" \t\r\n"), start.size()));
  std::transform(start.begin(), start.end(), start.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; });
  if (start.empty()) return {};
  const bool control = std::any_of(start.begin(), start.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\r' && c != '\n' && c != '\f';
  });
  if (control) return {};
  const auto has = [&](std::string_view word) { return start.find(word) != std::string::npos; };
  if (start.starts_with("<svg") || (start.starts_with("<?xml") && has("<svg"))) return {"an SVG drawing", std::string(kConvert)};
  if (start.starts_with("<!doctype html") || start.starts_with("<html") || has("<html") || has("<head"))
    return {"a web page, not a picture (a download that failed)", std::string(kFetch)};
  if (start.starts_with("<?xml")) return {"an XML file (perhaps a download that failed)", std::string(kFetch)};
  if (start.starts_with("{") || start.starts_with("["))
    return {"a JSON file (perhaps a download that failed)", std::string(kFetch)};
  const bool ascii = std::all_of(start.begin(), start.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; });
  if (ascii) return {"a text file, not a picture", std::string(kFetch)};
  return {};
}

// Image data that do not start at the first byte.
FileKind shifted_kind(std::string_view b) {
  constexpr size_t kLooked = 4096;
  const std::string_view start = b.substr(0, kLooked);
  for (const auto& [magic, name] : {std::pair{"\xff\xd8\xff"sv, "JPEG"sv}, {"\x89PNG\r\n\x1a\n"sv, "PNG"sv}})
    if (const size_t at = start.find(magic); at != std::string_view::npos && at > 0)
      return {fmt::format("a {} behind {} bytes that do not belong to it", name, at),
              fmt::format("save it again, or cut off its first {} bytes", at)};
  return {};
}

}  // namespace

FileKind file_kind(std::string_view b) {
  if (b.size() >= 12 && b.substr(4, 4) == "ftyp") return boxed_kind(b);
  if (b.size() >= 12 && b.substr(4, 4) == "moov") return {"a film (QuickTime)", std::string(kFrames)};
  if (b.starts_with("RIFF") && b.size() >= 12) {
    if (b.substr(8, 4) == "WEBP") return {"a WebP picture", std::string(kConvert), true};
    return {"a film or sound (RIFF)", std::string(kFrames)};
  }
  if (b.starts_with("BM") && b.size() >= 26 && b.substr(6, 4) == "\0\0\0\0"sv)
    return {"a BMP picture", std::string(kConvert), true};
  if (b.size() > 3 && b[0] == 'P' && ((b[1] >= '1' && b[1] <= '7') || b[1] == 'f' || b[1] == 'F') &&
      (b[2] == '\n' || b[2] == ' ' || b[2] == '\r' || b[2] == '\t'))
    return {"a PNM or PFM picture", std::string(kConvert), true};
  for (const Magic& m : kMagics)
    if (b.size() >= m.at && b.substr(m.at).starts_with(m.bytes))
      return {.name = std::string(m.name), .advice = std::string(m.advice), .raw = m.name.starts_with(kRaw)};
  if (!b.empty() && std::all_of(b.begin(), b.end(), [](char c) { return c == '\0'; }))
    return {"a file of zeros (an interrupted copy, or a failing card)", "copy it again"};
  if (FileKind kind = text_kind(b); !kind.name.empty()) return kind;
  return shifted_kind(b);
}

std::string foreign_content(std::string_view b, std::string_view extension) {
  const FileKind kind = file_kind(b);
  const std::string called = extension.empty() ? "" : fmt::format(", called {}", extension);
  if (!kind.name.empty()) return fmt::format("it is {}{}: {}", kind.name, called, kind.advice);
  std::string hex;
  for (const char c : b.substr(0, 8)) hex += fmt::format("{}{:02x}", hex.empty() ? "" : " ", static_cast<unsigned char>(c));
  return fmt::format("its content is no picture that is known (it begins with the bytes {})", hex);
}

}  // namespace vitrine
