// A box in one photo as a user writes it, "photo:x,y,w,h": left, top, width and height in pixels.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace vitrine {

struct PhotoBox {
  std::string photo;
  int x = 0, y = 0, width = 0, height = 0;
};

// Nothing when the text is not of that form, or the box is empty or begins outside (below 0). The name may hold colons.
std::optional<PhotoBox> parse_photo_box(std::string_view text);

}  // namespace vitrine
