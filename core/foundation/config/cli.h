// Command line parser shared by all executables. A flag is declared once with letter, value name, description and target
// variable; parsing, "did you mean" and --help are derived from it. kebab-case; underscores are accepted.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace vitrine {

class CommandLine {
 public:
  // `usage`: text after the program name in help; `summary`: one sentence below it.
  CommandLine(std::string program, std::string usage, std::string summary)
      : program_(std::move(program)), usage_(std::move(usage)), summary_(std::move(summary)) {}

  void flag(std::string_view name, char letter, bool& target, std::string_view doc);
  void value(std::string_view name, char letter, std::string_view value, std::string& target, std::string_view doc);
  void value(std::string_view name, char letter, std::string_view value, int& target, int low, std::string_view doc);
  void values(std::string_view name, char letter, std::string_view value, std::vector<std::string>& target, std::string_view doc);
  void section(std::string_view title);  // starts a new section in help

  // Returns the positional arguments in order. Throws Error{Usage}: unknown flag, missing or invalid value, more than `most`
  // arguments.
  std::vector<std::string> parse(const std::vector<std::string>& arguments, size_t most = size_t(-1)) const;
  // `tail` is appended (options or sub-commands).
  std::string help(std::string_view tail = {}) const;

 private:
  struct Flag {
    std::string name, value, doc;  // empty value name: a switch
    char letter = 0;
    std::function<void(const std::string&)> set;
    std::string section;
  };
  const Flag* find(std::string_view name) const;
  void add(std::string_view name, char letter, std::string_view value, std::string_view doc,
           std::function<void(const std::string&)> set);
  [[noreturn]] void usage_error(const std::string& message, const std::string& hint = {}) const;
  std::string program_, usage_, summary_, section_;
  std::vector<Flag> flags_;
};

// "4GiB", "512M", "80%" (of `whole`), "1000000". Throws Error{Usage} with `where`.
size_t parse_bytes(std::string_view text, size_t whole, std::string_view where);

}  // namespace vitrine
