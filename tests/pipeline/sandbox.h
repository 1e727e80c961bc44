// A folder with three photos and presets of its own; `vitrine` is run in it with the three test stages.
#pragma once

#include "tests/support/vitrine_process.h"

namespace vitrine {

class Sandbox : public VitrineProcess {
 protected:
  Sandbox() {
    write_file(photos() / "a.jpg", "one");
    write_file(photos() / "ä b.jpg", "three");
    write_file(photos() / "c.jpg", "seven");
    write_file(folder.path() / "conf/pipelines/standard.yaml", "collect:\n  repeat: 2\n");
    write_file(folder.path() / "conf/pipelines/preview.yaml", "upper:\n  word: quick\n");
    setenv("VITRINE_STAGE_DIR", VITRINE_TEST_STAGE_DIR, 1);
    setenv("VITRINE_CONFIG_DIR", (folder.path() / "conf").c_str(), 1);
  }

  fs::path photos() const final { return folder.path() / "my photos/images"; }
};

}  // namespace vitrine
