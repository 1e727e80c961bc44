// Recognises files that were given, by their content: one given instead of a folder of photos, for the error message (an archive,
// a PDF document, one photo), and documents of other programs (JSON, XML), before a reader is chosen.
#pragma once

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vitrine {

enum class FileKind : unsigned char { Archive, Document, Photo, Other };
// By its first bytes. Files that cannot be opened are Other.
FileKind kind_of_file(const std::filesystem::path& file);

struct GivenFile {
  std::string why, hint;  // of the error
};
GivenFile refusal_of_file(const std::filesystem::path& file);

// Keys of the document, or of the first object of a list.
struct JsonOutline {
  bool list = false;
  bool complete = false;          // well-formed as far as it was read
  std::vector<std::string> keys;  // in file order, each once
  bool has(std::string_view key) const { return std::find(keys.begin(), keys.end(), key) != keys.end(); }
};

// An empty outline: neither JSON nor XML.
struct DocumentOutline {
  bool empty = false;               // nothing but space
  std::optional<JsonOutline> json;  // the text starts like an object or a list
  std::string xml_root;             // name of the root element; empty: no XML
};
// Reads the whole file but builds no document: fast and with little memory also for large files. A document that is not
// well-formed has the keys before its first mistake. Throws Error{Input}: unreadable, or UTF-16.
DocumentOutline document_outline(const std::filesystem::path& file);

}  // namespace vitrine
