#include "core/base/text_file.h"

#include <algorithm>
#include <string_view>

#include "core/base/error.h"
#include "core/base/file.h"

namespace vitrine {

namespace {

// Texts of these formats begin with ASCII: every second or fourth byte of wider encodings is zero.
const char* wide_encoding(std::string_view bytes) {
  using namespace std::string_view_literals;
  if (bytes.starts_with("\xff\xfe\0\0"sv) || bytes.starts_with("\0\0\xfe\xff"sv)) return "UTF-32";
  if (bytes.starts_with("\xff\xfe"sv) || bytes.starts_with("\xfe\xff"sv)) return "UTF-16";
  if (bytes.size() >= 4 && (bytes[0] == 0) != (bytes[1] == 0) && (bytes[0] == 0) == (bytes[2] == 0) &&
      (bytes[1] == 0) == (bytes[3] == 0))
    return "UTF-16";
  return nullptr;
}

}  // namespace

std::string read_text_file(const fs::path& path) {
  std::string text = read_file(path);
  if (const char* encoding = wide_encoding(text))
    throw Error(ErrorKind::Input, "a text file has the wrong encoding",
                {.where = path.string(),
                 .why = std::string("it is ") + encoding + " text",
                 .hint = "save it as UTF-8 (Notepad: Save as, Encoding; PowerShell: Out-File -Encoding utf8)",
                 .code = "TEXT_ENCODING"});
  if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
  return text;
}

}  // namespace vitrine
