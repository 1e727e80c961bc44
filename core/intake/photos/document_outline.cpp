#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/intake/photos/given_file.h"

namespace vitrine {

namespace {

// Collects keys without building the document.
class OutlineReader : public nlohmann::json_sax<nlohmann::json> {
 public:
  JsonOutline outline;

  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(number_integer_t) override { return true; }
  bool number_unsigned(number_unsigned_t) override { return true; }
  bool number_float(number_float_t, const string_t&) override { return true; }
  bool string(string_t&) override { return true; }
  bool binary(binary_t&) override { return true; }
  bool start_object(size_t) override {
    ++depth_;
    return true;
  }
  bool key(string_t& name) override {
    if (depth_ == (outline.list ? 2u : 1u) && !outline.has(name) && outline.keys.size() < kMostKeys) outline.keys.push_back(name);
    return true;
  }
  bool end_object() override {
    --depth_;
    outline.complete = depth_ == (outline.list ? 1u : 0u);
    return !outline.complete;  // nothing more is needed
  }
  bool start_array(size_t) override {
    if (depth_ == 0) outline.list = true;
    ++depth_;
    return true;
  }
  bool end_array() override {
    --depth_;
    outline.complete = depth_ == 0;
    return true;
  }
  bool parse_error(size_t, const std::string&, const nlohmann::json::exception&) override { return false; }

 private:
  static constexpr size_t kMostKeys = 64;
  size_t depth_ = 0;
};

bool starts_with_at(std::string_view text, size_t at, std::string_view start) { return text.substr(at).starts_with(start); }

// Skips the declaration, comments and the document type.
std::string xml_root(std::string_view text, size_t at) {
  while (at != std::string_view::npos && at < text.size()) {
    if (starts_with_at(text, at, "<!--")) {
      at = text.find("-->", at);
      at = at == std::string_view::npos ? at : at + 3;
    } else if (starts_with_at(text, at, "<?") || starts_with_at(text, at, "<!")) {
      at = text.find('>', at);
      at = at == std::string_view::npos ? at : at + 1;
    } else if (text[at] == '<') {
      const size_t end = text.find_first_of(" \t\r\n/>", at + 1);
      return end == std::string_view::npos ? std::string() : std::string(text.substr(at + 1, end - at - 1));
    } else {
      return {};
    }
    at = text.find_first_not_of(" \t\r\n", at == std::string_view::npos ? text.size() : at);
  }
  return {};
}

}  // namespace

DocumentOutline document_outline(const std::filesystem::path& file) {
  const std::string text = read_text_file(file);
  DocumentOutline out;
  const size_t first = text.find_first_not_of(" \t\r\n");
  out.empty = first == std::string::npos;
  if (out.empty) return out;
  if (text[first] == '{' || text[first] == '[') {
    OutlineReader reader;
    nlohmann::json::sax_parse(text, &reader);
    out.json = std::move(reader.outline);
  } else if (text[first] == '<') {
    out.xml_root = xml_root(text, first);
  }
  return out;
}

}  // namespace vitrine
