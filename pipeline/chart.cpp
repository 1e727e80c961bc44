#include "pipeline/chart.h"

#include "core/foundation/base/error.h"
#include "core/foundation/config/chart.h"
#include "pipeline/given_inputs.h"

namespace vitrine {

namespace {

void check_photo(const std::string& photo, const PhotoNames& names, const fs::path& photos, const char* what,
                 const std::string& where, const char* code) {
  if (names.empty() || names.has(photo)) return;  // photo folder unavailable: ingest reports that
  const std::string near = names.nearest(photo);
  throw Error(ErrorKind::Usage, what,
              {.where = where,
               .why = fmt::format("no photo in {} is called '{}'", photos.string(), photo),
               .hint = near.empty() ? "give the name of one of the photos" : fmt::format("did you mean '{}'?", near),
               .code = code});
}

}  // namespace

void check_grey_card(const std::string& text, const fs::path& photos) {
  constexpr const char* kWhat = "the grey card cannot be found";
  const auto box = parse_photo_box(text);
  if (!box)
    throw Error(ErrorKind::Usage, kWhat,
                {.where = text,
                 .why = "it must read photo:x,y,w,h: four whole numbers, the box at least one pixel wide and high",
                 .hint = "for example IMG_0007.jpg:410,220,60,40, pixels of images/IMG_0007.jpg in the output folder",
                 .code = "GREY_CARD"});
  check_photo(box->photo, PhotoNames(photos), photos, kWhat, text, "GREY_CARD");
}

void check_scale_bar(const std::string& text, const fs::path& photos) {
  const ScaleBar bar = parse_scale_bar(text);
  const PhotoNames names(photos);
  for (const ScaleBarMark& mark : bar.marks)
    check_photo(mark.photo, names, photos, "the scale bar cannot be found", text, "SCALE_BAR");
}

}  // namespace vitrine
