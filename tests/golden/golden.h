// Text that is kept beside a test (tests/golden/*.txt) and compared word for word; with VITRINE_RENEW_GOLDEN=1 it is written
// anew.
#pragma once

#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/foundation/base/file.h"

namespace vitrine::golden {

inline std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

inline std::string replaced(std::string text, const std::string& part, const std::string& by) {
  for (size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += by.size()) text.replace(at, part.size(), by);
  return text;
}

// Compares with tests/golden/<name>, and shows the first line that differs with the two before it.
inline void expect_golden(const std::string& name, const std::string& text) {
  const fs::path file = fs::path(VITRINE_SOURCE_DIR) / "tests/golden" / name;
  if (std::getenv("VITRINE_RENEW_GOLDEN") != nullptr) {
    write_file(file, text);
    return;
  }
  const std::vector<std::string> kept = fs::exists(file) ? lines_of(read_file(file)) : std::vector<std::string>(),
                                 now = lines_of(text);
  size_t i = 0;
  while (i < kept.size() && i < now.size() && kept[i] == now[i]) ++i;
  if (i == kept.size() && i == now.size()) return;
  const auto line = [](const std::vector<std::string>& lines, size_t n) { return n < lines.size() ? lines[n] : "(its end)"; };
  ADD_FAILURE() << "tests/golden/" << name << ":" << i + 1 << " is\n  " << line(kept, i) << "\nand would now be\n  "
                << (i >= 2 ? line(now, i - 2) + "\n  " : "") << (i >= 1 ? line(now, i - 1) + "\n  " : "") << line(now, i)
                << "\nIf that is better: VITRINE_RENEW_GOLDEN=1 build/bin/test_golden, read `git diff tests/golden`, commit it";
}

}  // namespace vitrine::golden
