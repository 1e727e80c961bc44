// Output folder of a run: its contents (README), its settings file, and its lock.
#pragma once

#include <string>

#include "pipeline/settings.h"

namespace vitrine {

bool is_project(const fs::path& folder);  // true if an earlier run made it: it has vitrine.yaml
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
// and host if another run holds it. A stale lock of a killed run is taken over with a note.
class ProjectLock {
 public:
  explicit ProjectLock(const fs::path& project);
  ~ProjectLock();
  ProjectLock(const ProjectLock&) = delete;
  ProjectLock& operator=(const ProjectLock&) = delete;

 private:
  int fd_ = -1;
};

}  // namespace vitrine
