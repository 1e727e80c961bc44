// Pages of HTML that commands show to the person who asked (--open).
#pragma once

#include "core/base/file.h"

namespace vitrine {

// Throws Error{Dependency} where no program opens a browser.
void open_in_browser(const fs::path& page);

}  // namespace vitrine
