#include "stages/page_text.h"

#include <zlib.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/hash.h"
#include "core/foundation/base/json.h"

namespace vitrine {

namespace {

constexpr std::string_view kPlace = "<!-- the data -->";

fs::path beside_program() { return fs::read_symlink("/proc/self/exe").parent_path(); }

}  // namespace

fs::path empty_page_path(std::string_view stage) { return beside_program() / fmt::format("vitrine-{}.html", stage); }

std::string empty_page(std::string_view stage, std::string_view purpose) {
  const fs::path path = empty_page_path(stage);
  std::error_code ec;
  if (!fs::exists(path, ec))
    throw Error(ErrorKind::Dependency, fmt::format("this build of vitrine has no page {}", purpose),
                {.where = path.string(),
                 .why = "npm was missing when vitrine was built, or could not install the page's packages",
                 .hint = "apt-get install nodejs npm, then cmake --build build",
                 .code = "NO_PAGE"});
  return read_file(path);
}

std::string empty_page_digest(std::string_view stage) {
  std::error_code ec;
  const fs::path path = empty_page_path(stage);
  return fs::exists(path, ec) ? digest_file(path).short_hex() : "none";
}

PagePart json_part(std::string id, const nlohmann::ordered_json& json) {
  std::string text;
  for (const char c : json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace))
    text += c == '<' ? std::string("\\u003c") : std::string(1, c);
  return {std::move(id), "application/json", std::move(text)};
}

PagePart bytes_part(std::string id, std::string_view bytes) { return {std::move(id), "text/plain", base64(bytes)}; }

std::string deflated(std::string_view bytes) {
  uLongf size = compressBound(bytes.size());
  std::string out(size, '\0');
  const int result = compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                               bytes.size(), Z_BEST_COMPRESSION);
  VITRINE_CHECK(result == Z_OK, "zlib: {}", result);
  out.resize(size);
  return out;
}

std::string page_of(const std::string& empty_page, const std::vector<PagePart>& parts) {
  const size_t at = empty_page.find(kPlace);
  if (at == std::string::npos)
    throw Error(ErrorKind::Dependency, "the page of this build has no place for its data",
                {.where = beside_program().string(), .hint = "cmake --build build", .code = "NO_PAGE"});
  std::string page = empty_page.substr(0, at);
  for (const PagePart& part : parts)
    page += fmt::format("<script type=\"{}\" id=\"{}\">{}</script>\n", part.type, part.id, part.text);
  return page + empty_page.substr(at + kPlace.size());
}

}  // namespace vitrine
