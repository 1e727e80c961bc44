// Output folder of a run: its contents (README), its settings file, and its lock.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/artifact/manifest.h"
#include "core/foundation/base/file.h"
#include "pipeline/settings.h"

namespace vitrine {

bool is_project(const fs::path& folder);  // true if an earlier run made it: it has vitrine.yaml
// True if `vitrine compose` made it: there are no photos to compute it from.
bool is_composition(const fs::path& folder);
// The output folder named on the command line. Throws Error{Input} if it is none.
fs::path project_of(const std::string& word);
// Output folder of `vitrine run PHOTOS` without -o.
fs::path default_project(const fs::path& photos);
// Writes PROJECT/vitrine.yaml: photos, preset and all options given on the command line.
void write_project_settings(const fs::path& project, const Settings& settings);
// True if vitrine.yaml is as write_project_settings wrote it. Then `vitrine run PHOTOS -o PROJECT` replaces it; an edited file is
// a settings layer that no command overwrites.
bool settings_untouched(const fs::path& project);

// Folder for results of a finished project: `target` from -o, or `there` if both are the same folder. Throws Error{Usage} if it
// lies inside the photo folder, where the next run would read the results as photos.
fs::path result_folder(const fs::path& project, const fs::path& there, const std::string& target);

// Lock of an output folder during a run; the system releases it when the process ends. Throws Error{Locked} with the owner's pid
// and host if another run holds it. A stale lock of a killed run is taken over with a note. Shared: several processes, also on
// other machines, that read the current artifacts and add to the store.
enum class LockKind { Exclusive, Shared };
class ProjectLock {
 public:
  explicit ProjectLock(const fs::path& project, LockKind kind = LockKind::Exclusive);
  ~ProjectLock();
  ProjectLock(const ProjectLock&) = delete;
  ProjectLock& operator=(const ProjectLock&) = delete;

 private:
  int fd_ = -1;
  LockKind kind_;
};

// For processes that share the lock of a folder: one at a time links its files into it. Waits for the others.
class PublishingLock {
 public:
  explicit PublishingLock(const fs::path& project);
  ~PublishingLock();
  PublishingLock(const PublishingLock&) = delete;
  PublishingLock& operator=(const PublishingLock&) = delete;

 private:
  int fd_ = -1;
};

// PROJECT/export has two writers: `vitrine run` links the files of its export stage, `vitrine export` adds formats or options on
// request. Requested files stay: a run does not touch a format while any file that `vitrine export` wrote for it exists.
// .cache/exported.json lists the requested files; export/formats.json lists all formats.

inline constexpr std::string_view kExportStage = "export";

struct ExportDesc {
  fs::path project, target;
  bool overwrite = false;
};
// Links the files of an export artifact into `target`. Throws Error{Input} and changes nothing if other files would be replaced.
void put_export(const fs::path& entry, const Manifest& manifest, const ExportDesc& desc);

// Like publish(), for the export stage of a run. Returns the formats kept as `vitrine export` wrote them.
std::vector<std::string> publish_export(const fs::path& entry, const Manifest& manifest, const fs::path& project,
                                        const Manifest* before);

}  // namespace vitrine
