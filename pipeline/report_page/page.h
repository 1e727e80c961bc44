// Writes report.html: a single file without network requests that describes an output folder. Reads only that folder; sections
// with missing data are omitted.
#pragma once

#include <string>

#include "core/foundation/base/file.h"

namespace vitrine {

struct PageDesc {
  fs::path project;
  std::string typed = {};  // folder as typed in a command; empty: project
};

// Digest of everything the page depends on; stored in the page to detect outdated pages.
std::string page_state(const PageDesc& desc);
std::string report_page(const PageDesc& desc);
// Digest stored in a page; empty if vitrine did not write the file.
std::string state_of_page(const fs::path& file);

}  // namespace vitrine
