#include "core/intake/photos/named_file.h"

#include <algorithm>
#include <string>
#include <vector>

#include "core/foundation/base/file.h"
#include "core/foundation/base/folder_files.h"

namespace vitrine {

std::optional<fs::path> named_file(const fs::path& folder, const JsonAt& written) {
  std::string text = written.text();
  std::error_code ec;
  if (!fs::exists(folder / text, ec)) std::replace(text.begin(), text.end(), '\\', '/');
  const fs::path path = fs::path(text).lexically_normal();
  std::vector<fs::path> ends{path};
  for (auto first = path.begin(); first != path.end(); ++first) {
    fs::path end;
    for (auto part = first; part != path.end(); ++part) end /= *part;
    if (std::distance(first, path.end()) > 1) ends.push_back(end);
  }
  for (const fs::path& end : ends)
    if (stays_below(end) && fs::is_regular_file(folder / end, ec)) return path_inside(folder, end);
  if (stays_below(path) || !fs::exists(path.is_absolute() ? path : folder / path, ec)) return std::nullopt;
  written.fail("'" + text + "' is not a path inside the folder of this file");
}

std::vector<BesidePhoto> companions_in(const fs::path& folder) {
  try {
    return find_photos(folder).beside;
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Input) throw;
    return {};
  }
}

}  // namespace vitrine
