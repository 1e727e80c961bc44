// Finished projects of two balls (tests/stages/edit/two_balls.h) for compositions: folders as `vitrine run` leaves them.
#pragma once

#include <cstdlib>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/artifact/store.h"
#include "tests/stages/edit/two_balls.h"

namespace vitrine::test {

class Projects {
 public:
  Projects() {
    setenv("VITRINE_STAGE_DIR", VITRINE_BIN_DIR, 1);
    make("room", 'r');
    make("shelf", 's');
  }
  ~Projects() { unsetenv("VITRINE_STAGE_DIR"); }

  fs::path at(const std::string& name) const { return folder_.path() / name; }
  // A list of parts, as the lines below `parts:`.
  fs::path list(const std::string& parts) const {
    write_file(at("scene.yaml"), "parts:\n" + parts);
    return at("scene.yaml");
  }
  void forget(const std::string& project, const std::string& stage) const { remove_current_key(at(project), stage); }

  static const TwoBalls& balls() {
    static const TwoBalls scene;
    return scene;
  }

 private:
  // Another key of sfm: another frame and unit.
  void make(const std::string& name, char salt) const {
    write_file(at(name) / "vitrine.yaml", "");
    ArtifactStore store(store_of(at(name)));
    for (const auto& [stage, folder] : balls().artifacts()) {
      const std::string key(32, salt);
      PendingArtifact pending(store, stage, key);
      fs::copy(folder, pending.path(), fs::copy_options::recursive | fs::copy_options::overwrite_existing);
      Manifest manifest;
      manifest.stage = stage, manifest.key = key;
      pending.commit(manifest, "{}");
      set_current_key(at(name), stage, key);
    }
  }
  TemporaryFolder folder_;
};

}  // namespace vitrine::test
