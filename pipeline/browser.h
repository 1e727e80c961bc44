// Opens HTML pages in the user's browser (--open).
#pragma once

#include "core/foundation/base/file.h"

namespace vitrine {

// Throws Error{Dependency} if no program opens a browser.
void open_in_browser(const fs::path& page);

}  // namespace vitrine
