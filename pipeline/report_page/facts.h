// Tolerant reader of a JSON document in the output folder. Reports must also work after failed runs: missing or damaged values,
// or values of another type, are empty, never an error. (nlohmann's header stays in facts.cpp.)
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/base/file.h"

namespace vitrine {

class Facts {
 public:
  Facts() = default;  // empty document
  static Facts of_file(const fs::path& path);
  static Facts of_text(const std::string& json);

  bool known() const { return node_ != nullptr; }
  Facts member(std::string_view name) const;  // exact key
  Facts at(std::string_view path) const;      // "mesh.faces"
  std::vector<Facts> items() const;           // of an array
  std::vector<std::string> keys() const;      // of an object, in file order

  std::optional<double> number(std::string_view path = {}) const;  // finite numbers only
  std::optional<double> amount(std::string_view path = {}) const;  // number from 0 to 10^15: bytes, seconds, counts
  std::optional<bool> boolean(std::string_view path = {}) const;
  std::string text(std::string_view path = {}) const;  // "" if it is not a string

 private:
  Facts(std::shared_ptr<const void> document, const void* node) : document_(std::move(document)), node_(node) {}
  std::shared_ptr<const void> document_;
  const void* node_ = nullptr;
};

// Content of a text file, "" if it cannot be read or exceeds the size of any file that vitrine writes.
std::string text_of_file(const fs::path& path);
// Parses a CSV file with a header line, one map per row. Quotes as in RFC 4180.
std::vector<std::map<std::string, std::string>> rows_of_csv(const std::string& text);
std::optional<double> number_of(const std::string& text);

}  // namespace vitrine
