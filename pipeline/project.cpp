#include "pipeline/project.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/folder_files.h"
#include "core/foundation/base/hash.h"
#include "core/foundation/base/log.h"
#include "core/foundation/config/schema.h"
#include "core/foundation/config/yaml.h"
#include "core/intake/photos/photo_files.h"

namespace vitrine {

namespace {
fs::path written_settings(const fs::path& project) { return store_of(project) / "settings.digest"; }
}  // namespace

bool is_project(const fs::path& folder) {
  std::error_code ec;
  return fs::is_regular_file(folder / "vitrine.yaml", ec);
}

fs::path project_of(const std::string& word) {
  const fs::path project = fs::absolute(word).lexically_normal();
  if (!is_project(project))
    throw Error(ErrorKind::Input, "this is no output folder of vitrine",
                {.where = project.string(),
                 .why = "it has no vitrine.yaml",
                 .hint = "vitrine run PHOTOS -o DIR makes one",
                 .code = "NO_PROJECT"});
  return project;
}

fs::path default_project(const fs::path& photos) {
  fs::path folder = fs::absolute(photos).lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();
  std::string name = (is_film_name(folder) && !fs::is_directory(folder) ? folder.stem() : folder.filename()).string();
  if ((name == "images" || name == "photos") && folder.has_parent_path()) name = folder.parent_path().filename().string();
  return fs::current_path() / (name + "-vitrine");
}

void write_project_settings(const fs::path& project, const Settings& settings) {
  OptionTable kept;
  for (const Option& o : settings.options.table.options) {
    const bool always = o.path == "version" || o.path == "preset" || o.path == "input.photos";
    if (!always && !settings.from_command.contains(o.path)) continue;
    kept.options.push_back(o);
  }
  const std::string text =
      "# Settings of this folder, read by `vitrine run`; edit freely. `vitrine config reference` lists all options,\n"
      "# `vitrine config show --origin` shows where each value comes from.\n" +
      yaml_text(kept);
  write_file(project / "vitrine.yaml", text);
  write_file(written_settings(project), digest_bytes(text).hex());
}

bool settings_untouched(const fs::path& project) {
  std::error_code ec;
  if (!fs::exists(written_settings(project), ec) || !is_project(project)) return false;
  return read_file(written_settings(project)) == digest_bytes(read_file(project / "vitrine.yaml")).hex();
}

fs::path result_folder(const fs::path& project, const fs::path& there, const std::string& target) {
  if (target.empty() || (lies_in(target, there) && lies_in(there, target))) return there;
  const fs::path folder = fs::absolute(target).lexically_normal();
  const YamlFile settings = read_yaml((project / "vitrine.yaml").string());
  const YamlNode* input = settings.root.kind == YamlNode::Kind::Map ? settings.root.find("input") : nullptr;
  const YamlNode* photos = input != nullptr && input->kind == YamlNode::Kind::Map ? input->find("photos") : nullptr;
  std::error_code ec;
  if (photos != nullptr && !photos->text.empty() && fs::is_directory(project / photos->text, ec) &&
      lies_in(folder, project / photos->text))
    throw Error(ErrorKind::Usage, "the output folder lies inside the folder of photos",
                {.where = folder.string(), .hint = "choose another one with -o", .code = "USAGE"});
  return folder;
}

ProjectLock::ProjectLock(const fs::path& project, LockKind kind) : kind_(kind) {
  const fs::path file = project / ".lock";
  fd_ = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd_ < 0) throw_write_error(file, errno);
  char owner[256] = {};
  if (flock(fd_, (kind == LockKind::Shared ? LOCK_SH : LOCK_EX) | LOCK_NB) != 0) {
    const int saved = errno;
    const ssize_t n = pread(fd_, owner, sizeof owner - 1, 0);
    close(fd_);
    if (saved != EWOULDBLOCK)
      throw Error(ErrorKind::Resource, "cannot lock the output folder",
                  {.where = file.string(),
                   .why = std::strerror(saved),
                   .hint = "choose a folder on a local disk with -o",
                   .code = "NO_LOCKS"});
    throw Error(ErrorKind::Locked, "another run works in this folder",
                {.where = project.string(),
                 .why = n > 0 ? std::string("it is ") + owner : std::string("it has just started, or computes single frames"),
                 .hint = "wait for it, stop it, or choose another folder with -o",
                 .code = "LOCKED"});
  }
  if (kind == LockKind::Shared) return;  // without a name: several hold it
  if (pread(fd_, owner, sizeof owner - 1, 0) > 0) log_info("note: taking over the folder from a run that was killed ({})", owner);
  char host[128] = "unknown host";
  gethostname(host, sizeof host - 1);
  const std::string mine = fmt::format("process {} on {}", getpid(), host);
  if (ftruncate(fd_, 0) != 0 || pwrite(fd_, mine.data(), mine.size(), 0) < 0) {
    const int saved = errno;
    close(fd_);
    throw_write_error(file, saved);
  }
}

ProjectLock::~ProjectLock() {
  // An empty file marks a regular end. It is not removed: another process may wait on this inode.
  if (kind_ == LockKind::Exclusive && ftruncate(fd_, 0) == 0) fsync(fd_);
  close(fd_);
}

PublishingLock::PublishingLock(const fs::path& project) {
  const fs::path file = store_of(project) / "publishing.lock";
  fd_ = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd_ < 0) throw_write_error(file, errno);
  while (flock(fd_, LOCK_EX) != 0) {
    if (errno == EINTR) continue;
    const int saved = errno;
    close(fd_);
    throw_write_error(file, saved);
  }
}

PublishingLock::~PublishingLock() { close(fd_); }

}  // namespace vitrine
