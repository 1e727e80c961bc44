#include "core/artifact/publish.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/hash.h"

namespace vitrine {

void publish(const fs::path& entry, const Manifest& manifest, const fs::path& folder, const Manifest* before,
             const std::set<std::string>& kept) {
  std::error_code ec;
  if (before != nullptr) {
    std::set<std::string> stay = kept;
    for (const OutputFile& file : manifest.outputs) stay.insert(file.path);
    for (const OutputFile& old : before->outputs) {
      const fs::path target = folder / old.path;
      const bool ours = !stay.contains(old.path) && fs::is_regular_file(target, ec) && fs::file_size(target, ec) == old.bytes &&
                        digest_file(target).hex() == old.digest;
      if (ours) fs::remove(target, ec);
      fs::remove(target.parent_path(), ec);  // succeeds only when empty
    }
  }
  for (const OutputFile& file : manifest.outputs) {
    if (kept.contains(file.path)) continue;
    const fs::path from = entry / file.path, to = folder / file.path;
    if (!fs::equivalent(from, to, ec)) link_or_copy(from, to);
  }
}

}  // namespace vitrine
