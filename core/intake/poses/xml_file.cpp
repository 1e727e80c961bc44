#include "core/intake/poses/xml_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/config/json_file.h"

namespace vitrine {

XmlFile::XmlFile(const fs::path& path, const char* format, const char* hint)
    : path_(path), format_(format), hint_(hint), text_(read_text_file(path)) {
  const pugi::xml_parse_result result =
      document_.load_buffer(text_.data(), text_.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!result) fail_at(result.offset, fmt::format("it is no XML: {}", result.description()));
}

void XmlFile::fail_at(std::ptrdiff_t byte, const std::string& why) const {
  std::string where = path_.string();
  if (byte >= 0) {
    const TextPlace place = place_in_text(text_, std::min(static_cast<size_t>(byte), text_.size()));
    where += fmt::format(":{}:{}", place.line, place.column);
  }
  throw Error(ErrorKind::Input, fmt::format("this is not a usable {}", format_),
              {.where = where, .why = why, .hint = hint_, .code = "BAD_XML"});
}

void XmlFile::fail(pugi::xml_node at, const std::string& why) const { fail_at(at ? at.offset_debug() : -1, why); }

pugi::xml_node XmlFile::child(pugi::xml_node parent, const char* name) const {
  const pugi::xml_node found = parent.child(name);
  if (!found) fail(parent, fmt::format("<{}> has no <{}>", parent.name(), name));
  return found;
}

std::vector<double> XmlFile::parsed(pugi::xml_node at, const std::string& what, const char* text, size_t count) const {
  std::vector<double> out;
  const char* const end = text + std::strlen(text);
  for (const char* c = text; true;) {
    while (c != end && std::strchr(" \t\r\n", *c) != nullptr) ++c;
    if (c == end) break;
    double value = 0;
    const auto [next, error] = std::from_chars(*c == '+' ? c + 1 : c, end, value);
    if (error != std::errc() || !std::isfinite(value) || out.size() == count)
      fail(at, fmt::format("{}: expected {}", what, count == 1 ? "a number" : fmt::format("{} numbers", count)));
    out.push_back(value);
    c = next;
  }
  if (out.size() < count) fail(at, fmt::format("{}: {} of {} numbers", what, out.size(), count));
  return out;
}

std::vector<double> XmlFile::numbers(pugi::xml_node element, size_t count) const {
  return parsed(element, fmt::format("<{}>", element.name()), element.text().get(), count);
}

double XmlFile::number_of_child(pugi::xml_node parent, const char* name, double otherwise) const {
  const pugi::xml_node found = parent.child(name);
  return found ? number(found) : otherwise;
}

double XmlFile::attribute(pugi::xml_node element, const char* name) const {
  return parsed(element, fmt::format("{} of <{}>", name, element.name()), element.attribute(name).value(), 1)[0];
}

}  // namespace vitrine
