#include "core/foundation/artifact/store.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <csignal>

#include <fcntl.h>
#include <sys/file.h>

#include "core/foundation/base/error.h"

namespace vitrine {

namespace {

constexpr std::string_view kTemporaryMark = ".tmp-";

// Process id in "<key>.tmp-<pid>"; 0 for other names.
int owner_of(const std::string& name) {
  const size_t at = name.rfind(kTemporaryMark);
  if (at == std::string::npos) return 0;
  int pid = 0;
  std::from_chars(name.data() + at + kTemporaryMark.size(), name.data() + name.size(), pid);
  return pid;
}

// Whether the process of the temporary folder `name` holds the lock of its key: on another machine, its id means nothing here.
bool owner_works(const fs::path& stage, const std::string& name) {
  const fs::path lock = stage / (name.substr(0, name.find('.')) + ".scratch") / ".lock";
  const int fd = open(lock.c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) return false;
  const bool held = flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  close(fd);
  return held;
}

bool alive(int pid) { return pid > 0 && (kill(pid, 0) == 0 || errno == EPERM); }

void sync_file(const fs::path& path) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) throw_write_error(path, errno);
  const int rc = fsync(fd);
  const int saved = errno;
  close(fd);
  if (rc != 0 && saved != EINVAL) throw_write_error(path, saved);
}

size_t bytes_below(const fs::path& folder) {
  size_t bytes = 0;
  std::error_code ec;
  for (const auto& e : fs::recursive_directory_iterator(folder, ec))
    if (e.is_regular_file(ec)) bytes += e.file_size(ec);
  return bytes;
}

std::vector<fs::path> folders_in(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code ec;
  for (const auto& e : fs::directory_iterator(folder, ec))
    if (e.is_directory(ec)) found.push_back(e.path());
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

std::vector<OutputFile> artifact_files(DigestCache& digests, const fs::path& folder) {
  std::vector<OutputFile> files = digests.artifact_files(folder);
  std::erase_if(files, [](const OutputFile& f) { return f.path == kManifestName || f.path == kTimingName; });
  return files;
}

ArtifactStore::ArtifactStore(fs::path root) : root_(std::move(root)), digests_(root_ / "digests.txt") {}

std::optional<Manifest> ArtifactStore::find(std::string_view stage, std::string_view key) const {
  const fs::path file = entry(stage, key) / kManifestName;
  std::error_code ec;
  if (!fs::exists(file, ec)) return std::nullopt;
  return manifest_from_json(read_file(file), file.string());
}

std::string ArtifactStore::damage(const fs::path& folder) {
  const fs::path file = folder / kManifestName;
  Manifest m;
  try {
    m = manifest_from_json(read_file(file), file.string());
    const std::vector<OutputFile> now = artifact_files(digests_, folder);
    for (const OutputFile& want : m.outputs) {
      const auto have = std::find_if(now.begin(), now.end(), [&](const OutputFile& f) { return f.path == want.path; });
      if (have == now.end()) return fmt::format("{} is missing", want.path);
      if (have->bytes != want.bytes) return fmt::format("{} has {} bytes instead of {}", want.path, have->bytes, want.bytes);
      if (have->digest != want.digest) return fmt::format("{} has other contents than when it was written", want.path);
    }
    if (now.size() != m.outputs.size()) return fmt::format("it holds {} files instead of {}", now.size(), m.outputs.size());
    if (content_digest_of(m.outputs) != m.content_digest) return "the manifest does not agree with itself";
  } catch (const Error& e) {
    return e.message();
  }
  return {};
}

void ArtifactStore::remove(std::string_view stage, std::string_view key) const {
  // Renamed before removal: a partly removed folder must not look committed.
  const fs::path from = entry(stage, key), aside = root_ / stage / fmt::format("{}{}{}", key, kTemporaryMark, getpid());
  std::error_code ec;
  fs::remove_all(aside, ec);
  fs::rename(from, aside, ec);
  if (ec) throw_write_error(from, ec.value());
  fs::remove_all(aside, ec);
  if (ec) throw_write_error(aside, ec.value());
}

int ArtifactStore::sweep(std::string_view stage) const {
  int removed = 0;
  for (const fs::path& folder : folders_in(root_ / stage)) {
    const int pid = owner_of(folder.filename().string());
    if (pid == 0 || alive(pid) || owner_works(root_ / stage, folder.filename().string())) continue;
    std::error_code ec;
    fs::remove_all(folder, ec);
    if (!ec) ++removed;
  }
  return removed;
}

std::vector<ArtifactStore::Entry> ArtifactStore::entries() const {
  std::vector<Entry> all;
  for (const fs::path& stage : folders_in(root_))
    for (const fs::path& folder : folders_in(stage))
      all.push_back({stage.filename().string(), folder.filename().string(), folder, bytes_below(folder),
                     fs::exists(folder / kManifestName) && owner_of(folder.filename().string()) == 0});
  return all;
}

PendingArtifact::PendingArtifact(ArtifactStore& store, std::string_view stage, std::string_view key)
    : store_(store),
      stage_(stage),
      key_(key),
      path_(store.root() / stage / fmt::format("{}{}{}", key, kTemporaryMark, getpid())) {
  std::error_code ec;
  fs::remove_all(path_, ec);
  make_folders(path_);
}

PendingArtifact::~PendingArtifact() {
  std::error_code ignored;
  if (!committed_) fs::remove_all(path_, ignored);
}

fs::path PendingArtifact::commit(Manifest& manifest, std::string_view timing_json) {
  manifest.outputs = artifact_files(store_.digests(), path_);
  manifest.content_digest = content_digest_of(manifest.outputs);
  for (const OutputFile& file : manifest.outputs) sync_file(path_ / file.path);
  write_file(path_ / kTimingName, timing_json);
  write_file(path_ / kManifestName, to_json(manifest));
  sync_folder(path_);
  const fs::path final_path = store_.entry(stage_, key_);
  std::error_code ec;
  if (fs::exists(final_path, ec)) {
    const fs::path old = store_.root() / stage_ / fmt::format("{}.old{}{}", key_, kTemporaryMark, getpid());
    fs::remove_all(old, ec);
    fs::rename(final_path, old, ec);
    if (ec) throw_write_error(final_path, ec.value());
  }
  fs::rename(path_, final_path, ec);
  if (ec) throw_write_error(final_path, ec.value());
  committed_ = true;
  sync_folder(final_path.parent_path());
  fs::remove_all(store_.root() / stage_ / fmt::format("{}.old{}{}", key_, kTemporaryMark, getpid()), ec);
  return final_path;
}

}  // namespace vitrine
