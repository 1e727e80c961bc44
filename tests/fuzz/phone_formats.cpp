// HEIC, AVIF and raw photos, XMP of panoramas. Builds without libheif or LibRaw have the readers of boxes and no corpus of that format.
#include "core/intake/photos/linear_photo.h"
#include "core/intake/photos/panorama.h"
#include "core/intake/photos/photo_files.h"
#include "core/scene/image/heif_file.h"
#include "stages/ingest/develop.h"
#include "tests/fuzz/entry.h"
#include "tests/support/dng_file.h"
#ifdef VITRINE_WITH_LIBHEIF
#include "tests/support/heif_writer.h"
#include "tests/support/tiny_photos.h"
#endif

namespace vitrine {

void fuzz_heif(std::span<const uint8_t> bytes) {
  const std::string_view text = text_of(bytes);
  const HeifFile file = heif_file(text);
  if (without_shared_auxiliaries(text, file).size() != text.size()) throw std::logic_error("bytes are lost");
  if (file.icc.size() > text.size() || file.exif.size() > text.size() + 6) throw std::logic_error("more than the file has");
  const fs::path path = input_file("photo.heic", text);
  refuses_or_reads([&] { ingest::develop(path, 64); });
  refuses_or_reads([&] { reduced_photo(path, read_photo_head(path), 16); });
}

void fuzz_raw(std::span<const uint8_t> bytes) {
  const fs::path path = input_file("photo.dng", text_of(bytes));
  refuses_or_reads([&] { ingest::develop(path, 64); });
  refuses_or_reads([&] { reduced_photo(path, read_photo_head(path), 16); });
}

void fuzz_gpano(std::span<const uint8_t> bytes) {
  const GPano xmp = parse_gpano(text_of(bytes));
  for (int size : {xmp.full_width, xmp.full_height, xmp.cropped_width, xmp.cropped_height})
    if (size < 0 || size > 1 << 20) throw std::logic_error("a size outside of the range of pictures");
  panorama_of(xmp, 4096, 2048, [] { return ImageF(8, 4, 3); });
}

std::vector<std::string> gpano_corpus() {
  const std::string begin = "<x:xmpmeta><rdf:Description xmlns:GPano=\"http://ns.google.com/photos/1.0/panorama/\"";
  return {begin + " GPano:ProjectionType=\"equirectangular\" GPano:FullPanoWidthPixels=\"4096\" "
                  "GPano:CroppedAreaImageHeightPixels='2048'/></x:xmpmeta>",
          begin + "><GPano:ProjectionType>cylindrical</GPano:ProjectionType><GPano:FullPanoHeightPixels>77<"
                  "/GPano:FullPanoHeightPixels></rdf:Description></x:xmpmeta>"};
}

std::vector<std::string> heif_corpus() {
#ifdef VITRINE_WITH_LIBHEIF
  using namespace test;
  if (heif_encodes(heif_compression_HEVC)) {
    const auto image = [](int channels) {
      Image8 out(32, 24, channels);
      for (size_t i = 0; i < out.data().size(); ++i) out.data()[i] = static_cast<uint8_t>(i * 7);
      return out;
    };
    const std::string exif = exif_bytes({{0x010f, 'a', 0, 1, "Maker"}}, {{0x829a, 'r', 1, 125}, {0xa405, 's', 35}}).substr(6);
    const std::string alpha = heif_bytes(image(4), {.alpha = true}), shared = with_shared_auxiliary(alpha);
    return {heif_bytes(image(3), {.orientation = 6, .exif = exif}), heif_bytes(image(3), {.bits = 10, .primaries = 12}), alpha,
            shared.empty() ? alpha : shared};
  }
#endif
  return {
      std::string("\0\0\0\x18"
                  "ftypheic\0\0\0\0mif1heic\0\0\0\x08meta",
                  32)};
}

std::vector<std::string> raw_corpus() {
  const auto grey = [](int, int) { return Vec3d{0.4, 0.4, 0.4}; };
  return {test::dng_bytes({.width = 32, .height = 24}, grey),
          test::dng_bytes({.width = 32, .height = 24, .orientation = 6}, grey),
          test::dng_bytes({.width = 32, .height = 24, .matrix = false}, grey)};
}

}  // namespace vitrine
