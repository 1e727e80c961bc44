#include "pipeline/grey_card.h"

#include <algorithm>
#include <vector>

#include "core/base/error.h"
#include "core/config/photo_box.h"
#include "core/config/text.h"

namespace vitrine {

void check_grey_card(const std::string& text, const fs::path& photos) {
  const auto box = parse_photo_box(text);
  if (!box)
    throw Error(ErrorKind::Usage, "the grey card cannot be found",
                {.where = text,
                 .why = "it must read photo:x,y,w,h: four whole numbers, the box at least one pixel wide and high",
                 .hint = "for example IMG_0007.jpg:410,220,60,40, pixels of images/IMG_0007.jpg in the output folder",
                 .code = "GREY_CARD"});
  std::error_code ec;
  std::vector<std::string> names;
  for (fs::recursive_directory_iterator it(photos, ec), end; !ec && it != end; it.increment(ec)) {
    // As the ingest stage calls photos: an .exr becomes a .png, and of two that differ by their extension alone the second keeps
    // it in its stem.
    const fs::path file = it->path().lexically_relative(photos);
    const std::string extension = file.extension().string(), plain = fs::path(file).replace_extension().generic_string();
    const std::string twin = extension.empty() ? plain : plain + "_" + extension.substr(1);
    const std::string shown = extension == ".exr" || extension == ".EXR" ? ".png" : extension;
    for (const std::string& stem : {plain, twin})
      if (box->photo == stem || box->photo == stem + shown) return;
    names.push_back(file.generic_string());
  }
  if (names.empty()) return;  // no folder of photos to look at: ingest has something to say about that
  std::ranges::sort(names);
  const std::string near = nearest_word(box->photo, names);
  throw Error(ErrorKind::Usage, "the grey card cannot be found",
              {.where = text,
               .why = fmt::format("no photo in {} is called '{}'", photos.string(), box->photo),
               .hint = near.empty() ? "give the name of one of the photos" : fmt::format("did you mean '{}'?", near),
               .code = "GREY_CARD"});
}

}  // namespace vitrine
