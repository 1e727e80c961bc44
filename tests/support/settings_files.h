// The files of settings that come with the project: a stage understands each of them.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "core/foundation/base/file.h"
#include "core/foundation/config/schema.h"
#include "stages/stage.h"

namespace vitrine::test {

// Applies every file of configs/<stage> to a stage of its own, which `check` is given then. The number of files.
inline size_t expect_settings_understood(
    const std::string& name, Stage (*make)(), const std::function<void(const Stage&)>& check = [](const Stage&) {}) {
  size_t files = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(VITRINE_SOURCE_DIR) / "configs" / name)) {
    SCOPED_TRACE(entry.path().string());
    const YamlFile file = read_yaml(entry.path().string());
    Stage stage = make();
    const YamlNode* section = file.root.find(name);
    if (section == nullptr) {
      ADD_FAILURE() << "no section " << name;
      continue;
    }
    ConfigErrors errors;
    apply_yaml(file, *section, stage.options, {.shown = name}, errors);
    errors.throw_if_any("");
    EXPECT_EQ(stage.problem(), "");
    check(stage);
    ++files;
  }
  return files;
}

}  // namespace vitrine::test
