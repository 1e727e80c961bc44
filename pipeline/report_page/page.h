// report.html: everything a person wants to know of an output folder on one page, in one file that asks the network for nothing.
// Reads the folder only; whatever part of it is missing is left out.
#pragma once

#include <string>

#include "core/base/file.h"

namespace vitrine {

struct PageDesc {
  fs::path project;
  std::string typed = {};  // the folder as it is to be typed in a command; empty: project
};

// What the page depends on, as a digest: a page that carries it is up to date.
std::string page_state(const PageDesc& desc);
std::string report_page(const PageDesc& desc);
// The state that a page was made from; empty when the file is none of ours.
std::string state_of_page(const fs::path& file);

}  // namespace vitrine
