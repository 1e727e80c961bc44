// HTML page in one file: the bundled page of a program (folder page/, page/page.cmake) with its data inserted.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/base/json.h"

namespace vitrine {

// vitrine-<stage>.html in the folder of the program.
std::filesystem::path empty_page_path(std::string_view stage);
// Throws Error{Dependency} if the build had no npm. `purpose`, for the message: "to view a scene in".
std::string empty_page(std::string_view stage, std::string_view purpose);
// Digest of the page for the cache key; "none" without a page.
std::string empty_page_digest(std::string_view stage);

// Text of a script element that browsers do not execute.
struct PagePart {
  std::string id, type, text;
};
PagePart json_part(std::string id, const nlohmann::ordered_json& json);  // escaped, so that the text cannot close the element
PagePart bytes_part(std::string id, std::string_view bytes);             // base64
// zlib stream (RFC 1950); browsers decode it with DecompressionStream("deflate").
std::string deflated(std::string_view bytes);

// Throws Error{Dependency} when the page has no placeholder for data: it belongs to another build.
std::string page_of(const std::string& empty_page, const std::vector<PagePart>& parts);

}  // namespace vitrine
