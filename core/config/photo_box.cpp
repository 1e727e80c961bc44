#include "core/config/photo_box.h"

#include <charconv>

namespace vitrine {

std::optional<PhotoBox> parse_photo_box(std::string_view text) {
  const size_t colon = text.rfind(':');
  if (colon == std::string_view::npos || colon == 0) return std::nullopt;
  PhotoBox box{.photo = std::string(text.substr(0, colon))};
  const char *at = text.data() + colon, *end = text.data() + text.size();
  for (int* number : {&box.x, &box.y, &box.width, &box.height}) {
    if (at == end || (*at != ':' && *at != ',')) return std::nullopt;
    const auto [next, error] = std::from_chars(at + 1, end, *number);
    if (error != std::errc()) return std::nullopt;
    at = next;
  }
  if (at != end || box.x < 0 || box.y < 0 || box.width < 1 || box.height < 1) return std::nullopt;
  return box;
}

}  // namespace vitrine
