#include "core/foundation/base/checkpoint.h"

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/hash.h"

namespace vitrine {

namespace {

constexpr std::string_view kMagic = "vitrine-checkpoint 6\n";
constexpr size_t kDigestSize = 32;

}  // namespace

void write_checkpoint(const std::filesystem::path& path, const std::string& state) {
  write_file(path, std::string(kMagic) + digest_bytes(state).hex() + state);
}

std::optional<std::string> read_checkpoint(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  std::string bytes = read_file(path);
  const auto damaged = [&](std::string why) {
    return Error(ErrorKind::Input, "a checkpoint cannot be used",
                 {.where = path.string(), .why = std::move(why), .hint = "delete it to start over", .code = "BAD_CHECKPOINT"});
  };
  if (!bytes.starts_with(kMagic) || bytes.size() < kMagic.size() + kDigestSize) throw damaged("it has another format");
  std::string state = bytes.substr(kMagic.size() + kDigestSize);
  if (digest_bytes(state).hex() != std::string_view(bytes).substr(kMagic.size(), kDigestSize))
    throw damaged("its digest does not match");
  return state;
}

}  // namespace vitrine
