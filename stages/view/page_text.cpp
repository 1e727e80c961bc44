#include "stages/view/page_text.h"

#include "core/base/base64.h"
#include "core/base/error.h"
#include "core/base/file.h"

namespace vitrine {

namespace {

constexpr std::string_view kPlace = "<!-- the scene -->";

// Nothing in it ends the element that holds it.
std::string quoted(const nlohmann::ordered_json& json) {
  std::string out;
  for (const char c : json.dump()) out += c == '<' ? std::string("\\u003c") : std::string(1, c);
  return out;
}

std::string element(std::string_view id, std::string_view type, std::string_view text) {
  return fmt::format("<script type=\"{}\" id=\"{}\">{}</script>\n", type, id, text);
}

}  // namespace

fs::path empty_page_path() { return fs::read_symlink("/proc/self/exe").parent_path() / "vitrine-view.html"; }

std::string empty_page() {
  const fs::path path = empty_page_path();
  std::error_code ec;
  if (!fs::exists(path, ec))
    throw Error(ErrorKind::Dependency, "this build of vitrine has no page to view a scene in",
                {.where = path.string(),
                 .why = "npm was missing when vitrine was built, or could not install the page's packages",
                 .hint = "apt-get install nodejs npm, then cmake --build build",
                 .code = "NO_PAGE"});
  return read_file(path);
}

std::string page_of(const std::string& empty_page, const PageScene& scene) {
  const size_t at = empty_page.find(kPlace);
  if (at == std::string::npos)
    throw Error(ErrorKind::Dependency, "the page of this build has no place for a scene",
                {.where = empty_page_path().string(), .hint = "cmake --build build", .code = "NO_PAGE"});
  return empty_page.substr(0, at) + element("scene", "application/json", quoted(scene.scene)) +
         element("photos", "application/json", quoted(scene.photos)) + element("blocks", "text/plain", base64(scene.blocks)) +
         empty_page.substr(at + kPlace.size());
}

}  // namespace vitrine
