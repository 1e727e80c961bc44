#include "pipeline/grey_card.h"

#include "core/base/error.h"
#include "core/config/photo_box.h"
#include "pipeline/given_inputs.h"

namespace vitrine {

void check_grey_card(const std::string& text, const fs::path& photos) {
  const auto box = parse_photo_box(text);
  if (!box)
    throw Error(ErrorKind::Usage, "the grey card cannot be found",
                {.where = text,
                 .why = "it must read photo:x,y,w,h: four whole numbers, the box at least one pixel wide and high",
                 .hint = "for example IMG_0007.jpg:410,220,60,40, pixels of images/IMG_0007.jpg in the output folder",
                 .code = "GREY_CARD"});
  const PhotoNames names(photos);
  if (names.empty() || names.has(box->photo)) return;  // no folder of photos to look at: ingest has something to say about that
  const std::string near = names.nearest(box->photo);
  throw Error(ErrorKind::Usage, "the grey card cannot be found",
              {.where = text,
               .why = fmt::format("no photo in {} is called '{}'", photos.string(), box->photo),
               .hint = near.empty() ? "give the name of one of the photos" : fmt::format("did you mean '{}'?", near),
               .code = "GREY_CARD"});
}

}  // namespace vitrine
