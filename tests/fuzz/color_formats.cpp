// Colour profiles: alone, and inside of photos.
#include "core/scene/image/color_profile.h"
#include "tests/fuzz/entry.h"
#include "tests/stages/ingest/tagged_photos.h"

namespace vitrine {

void fuzz_icc(std::span<const uint8_t> bytes) {
  refuses_or_reads([&] {
    const IccProfile icc = icc_profile(text_of(bytes));
    if (!icc.profile && icc.problem.empty()) throw std::logic_error("a profile is refused without a reason");
    if (!icc.profile) return;
    ImageF image(16, 16, 3);
    for (size_t i = 0; i < image.data().size(); ++i) image.data()[i] = float(i * 37 % 256) / 255.f;
    ImageF wide = image;
    for (float& v : wide.data()) v = 3 * v - 1;
    icc.profile->to_linear(image);
    icc.profile->float_to_linear(wide);
    for (const ImageF* made : {&image, &wide})
      for (float v : made->data())
        if (!std::isfinite(v)) throw std::logic_error("a profile gives a number that is none");
  });
}

std::vector<std::string> icc_corpus() {
  using namespace test;
  cmsToneCurve* const gamma = cmsBuildGamma(nullptr, 2.2);
  const Profile grey = owned(cmsCreateGrayProfile(cmsD50_xyY(), gamma));
  cmsFreeToneCurve(gamma);
  const uint16_t few[] = {0, 9000, 30000, 65535};
  return {icc_bytes(display_p3()), icc_bytes(adobe_rgb()), icc_bytes(grey), icc_bytes(table_profile(prophoto(), 3)),
          icc_bytes(rgb_profile(kRec709, cmsBuildTabulatedToneCurve16(nullptr, 4, few), "table"))};
}

std::vector<std::string> tagged_photo_corpus() {
  using namespace test;
  Image8 image(24, 18, 3);
  for (size_t i = 0; i < image.data().size(); ++i) image.data()[i] = static_cast<uint8_t>(i * 37);
  const std::string icc = icc_bytes(display_p3());
  const auto made = [&](const char* name, auto&& tag) {
    const fs::path path = fuzz_folder() / name;
    write_ldr(path, image);
    tag(path);
    return read_file(path);
  };
  return {made("made.jpg",
               [&](const fs::path& p) {
                 add_icc_to_jpeg(p, icc, 3, {2, 3, 1});
               }),
          made("made.png", [&](const fs::path& p) { add_to_png(p, icc_chunk(icc)); }),
          made("made.png",
               [&](const fs::path& p) {
                 add_to_png(p, numbers_chunk("gAMA", {55556}) +
                                   numbers_chunk("cHRM", {31270, 32900, 64000, 33000, 21000, 71000, 15000, 6000}));
               }),
          made("made.png", [&](const fs::path& p) { add_to_png(p, png_chunk("cICP", std::string("\x0c\x0d\0\1", 4))); }),
          tagged_tiff(image, icc),
          tagged_tiff(image, icc, true)};
}

}  // namespace vitrine
