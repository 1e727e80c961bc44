// A page for people as one HTML file: what the build made of a program's folder page/ (page/page.cmake), with its data put in.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/json.h"

namespace vitrine {

// vitrine-<stage>.html beside the program.
std::filesystem::path empty_page_path(std::string_view stage);
// Throws Error{Dependency} where the build had no npm. `purpose`: what the page is for, "to view a scene in".
std::string empty_page(std::string_view stage, std::string_view purpose);
// Of its bytes, for the cache key; "none".
std::string empty_page_digest(std::string_view stage);

// The text of a script element that no browser runs.
struct PagePart {
  std::string id, type, text;
};
PagePart json_part(std::string id, const nlohmann::ordered_json& json);  // nothing in it ends the element
PagePart bytes_part(std::string id, std::string_view bytes);             // as base64

// Throws Error{Dependency} when the page has no place for data: it belongs to another build.
std::string page_of(const std::string& empty_page, const std::vector<PagePart>& parts);

}  // namespace vitrine
