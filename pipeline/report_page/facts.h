// A JSON document of the output folder, read with tolerance: a report is most wanted after a run that went wrong, so whatever is
// missing, damaged or of another type is an empty answer, never an error. (nlohmann's header stays in facts.cpp.)
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/file.h"

namespace vitrine {

class Facts {
 public:
  Facts() = default;  // knows nothing
  static Facts of_file(const fs::path& path);
  static Facts of_text(const std::string& json);

  bool known() const { return node_ != nullptr; }
  Facts member(std::string_view name) const;  // exactly this key
  Facts at(std::string_view path) const;      // "mesh.faces"
  std::vector<Facts> items() const;           // of an array
  std::vector<std::string> keys() const;      // of an object, in the file's order

  std::optional<double> number(std::string_view path = {}) const;  // finite
  std::optional<double> amount(std::string_view path = {}) const;  // a number from 0 to 10^15: bytes, seconds, counts
  std::optional<bool> boolean(std::string_view path = {}) const;
  std::string text(std::string_view path = {}) const;  // "" when it is no string

 private:
  Facts(std::shared_ptr<const void> document, const void* node) : document_(std::move(document)), node_(node) {}
  std::shared_ptr<const void> document_;
  const void* node_ = nullptr;
};

// A file of the folder as text, "" when it cannot be read or is larger than anything vitrine writes there.
std::string text_of_file(const fs::path& path);
// A comma-separated file with a first line of names, one map per row. Quotes as in RFC 4180.
std::vector<std::map<std::string, std::string>> rows_of_csv(const std::string& text);
std::optional<double> number_of(const std::string& text);

}  // namespace vitrine
