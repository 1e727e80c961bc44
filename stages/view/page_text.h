// The page's text: what the build made of page/ (view/page.cmake), with a scene put in.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/json.h"

namespace vitrine {

// vitrine-view.html beside the program.
std::filesystem::path empty_page_path();
// Throws Error{Dependency} where the build had no npm.
std::string empty_page();

// `scene` and `photos` as JSON, `blocks` deflated; all in script elements that no browser runs. Throws Error{Dependency} when the
// page has no place for them: it belongs to another build.
struct PageScene {
  nlohmann::ordered_json scene, photos;
  std::string blocks;
};
std::string page_of(const std::string& empty_page, const PageScene& scene);

}  // namespace vitrine
