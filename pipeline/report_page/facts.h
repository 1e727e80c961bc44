// Tolerant reader of a JSON document in the output folder. Reports must also work after failed runs: missing or damaged values,
// or values of another type, are empty, never an error. (nlohmann's header stays in facts.cpp.)
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
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

// Evaluates the values and texts that stages declare for their reports (core/foundation/artifact/stage_report.h). A path
// component "*" matches all items of an array, or all members of an object. Placeholders in a text:
//   {mesh.faces:n}          a count, digits in groups of three; several values are summed  {psnr:1}  a number with one decimal
//   {a,b:1}                 the maximum; all must exist                                    {source}  a text
//   {views:view,views}      singular or plural                                             {verdict=thin,thick}  one of these
//   texts {layers.*.count:parts}  "40 000 front, 15 000 back": at least two members with their names

// nullopt if a value is missing.
std::optional<std::string> fact_text(const std::string& text, const Facts& report);
// Numbers at a path, with the names of their members. `only`: restricts to items whose member of this name is true.
std::vector<std::pair<std::string, double>> numbers_at(const Facts& report, std::string_view path, std::string_view only = {});

}  // namespace vitrine
