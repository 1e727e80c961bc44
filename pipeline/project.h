// The output folder of a run: what stands in it (README), its settings file, and the lock that one run at a time holds.
#pragma once

#include <string>

#include "pipeline/settings.h"

namespace vitrine {

bool is_project(const fs::path& folder);  // made by an earlier run: it has vitrine.yaml
// The output folder that a command line names. Error{Input} when it is none.
fs::path project_of(const std::string& word);
// The folder for `vitrine run PHOTOS` without -o.
fs::path default_project(const fs::path& photos);
// Writes PROJECT/vitrine.yaml: the photos, the preset and everything given on the command line.
void write_project_settings(const fs::path& project, const Settings& settings);
// Whether vitrine.yaml is as write_project_settings left it. As long as it is, `vitrine run PHOTOS -o PROJECT` sets the project
// up anew; once somebody has edited it, it is a layer of settings that no command touches.
bool settings_untouched(const fs::path& project);

// Where results of a finished project go when -o names a folder: `target`, or `there` itself when it is the same folder by
// another path. Throws Error{Usage} when it lies in the folder of the photos, whose next run would take the results for photos.
fs::path result_folder(const fs::path& project, const fs::path& there, const std::string& target);

// Held while a run works in the folder, released by the system however the process ends. Error{Locked} with the owner's pid and
// host when another run holds it. A lock left behind by a killed run is taken over with a note.
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
