#include "pipeline/browser.h"

#include "core/foundation/base/error.h"
#include "core/foundation/base/process.h"
#include "pipeline/tool.h"

namespace vitrine {

void open_in_browser(const fs::path& page) {
  const auto opener = find_program("xdg-open");
  if (opener && run_and_tell({opener->string(), page.string()}) == 0) return;
  throw Error(ErrorKind::Dependency, "no program opens a browser here",
              {.why = opener ? "xdg-open found none" : "xdg-open is missing",
               .hint = "open the page by hand: " + page.string(),
               .code = "NO_BROWSER"});
}

}  // namespace vitrine
