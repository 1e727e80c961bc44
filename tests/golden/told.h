// Collects what programs answer to mistakes: each call with its message, without what differs from machine to machine.
#pragma once

#include <regex>

#include "tests/e2e/tiny_room.h"
#include "tests/golden/golden.h"

namespace vitrine {

class Told : public TinyRoom {
 protected:
  using Words = std::vector<std::string>;

  // words[0] is a program of vitrine; it runs in the folder of the test, where relative paths begin.
  void told(const std::string& mistake, Words words) {
    const std::string shown = join_command(words);
    words[0] = std::string(VITRINE_BIN_DIR) + "/" + words[0];
    std::string said;
    const ProcessResult r =
        run_process({.arguments = words, .working_folder = folder.path(), .on_line = [&](std::string_view line) {
                       said.append(line) += '\n';
                     }});
    const std::string message = message_in(said);
    EXPECT_EQ(r.signal, 0) << shown << "\n" << said;
    EXPECT_TRUE(message.find("error: ") != std::string::npos) << shown << "\n" << said;
    EXPECT_TRUE(message.find("\n  try    ") != std::string::npos) << shown << "\n" << said;
    all_ += fmt::format("# {}\n$ {}\n{}exit {}\n\n", mistake, everywhere(shown), everywhere(message), r.exit_code);
  }
  // A file in the folder of the test.
  std::string put(const std::string& name, const std::string& text) const {
    write_file(folder.path() / name, text);
    return name;
  }
  const std::string& all() const { return all_; }

 private:
  // From the line that says that something went wrong, without the stages before it and the page about it.
  static std::string message_in(const std::string& said) {
    std::string message;
    for (const std::string& line : golden::lines_of(said)) {
      const bool fails = line.find("error: ") != std::string::npos || line.find("FAILED  ") != std::string::npos;
      if ((fails || !message.empty()) && !line.starts_with("report: ")) message += line + "\n";
    }
    return message;
  }
  std::string everywhere(std::string text) const {
    text = golden::replaced(text, folder.path().string(), "HERE");
    text = golden::replaced(text, VITRINE_BIN_DIR, "BIN");
    static const std::regex kKey("[0-9a-f]{32}");
    return std::regex_replace(text, kKey, "KEY");
  }

  std::string all_;
};

}  // namespace vitrine
