// HEIC and AVIF files written by libheif's encoders, with the properties that phones write; and changes of their boxes.
#pragma once

#include <libheif/heif.h>

#include <cstring>
#include <stdexcept>
#include <string>

#include "core/scene/image/image.h"

// x265 keeps tables of its encoders until the process ends. LeakSanitizer reads this list; its library finds only visible
// symbols.
extern "C" __attribute__((used, weak, visibility("default"))) const char* __lsan_default_suppressions() {
  return "leak:libx265.so\n";
}

namespace vitrine::test {

struct HeifDesc {
  heif_compression_format format = heif_compression_HEVC;
  int bits = 8;
  int orientation = 1;  // EXIF 1..8, as the boxes irot and imir
  int primaries = 1, transfer = 13;
  std::string icc = {};   // replaces the code points
  std::string exif = {};  // TIFF structure
  bool alpha = false;     // the image has 4 channels
  int quality = 0;        // 0: lossless
};

inline bool heif_encodes(heif_compression_format format) { return heif_have_encoder_for_format(format) != 0; }

inline void expect_ok(const heif_error& error) {
  if (error.code != heif_error_Ok) throw std::runtime_error(error.message);
}

// `samples`: of `bits` bits, in the low bits.
inline std::string heif_bytes(const Image16& samples, const HeifDesc& d) {
  heif_context* const context = heif_context_alloc();
  heif_encoder* encoder = nullptr;
  expect_ok(heif_context_get_encoder_for_format(context, d.format, &encoder));
  if (d.quality == 0)
    heif_encoder_set_lossless(encoder, 1);
  else
    heif_encoder_set_lossy_quality(encoder, d.quality);
  heif_encoder_set_parameter_string(encoder, "chroma", "444");
  heif_image* image = nullptr;
  const bool wide = d.bits > 8;
  const heif_chroma layout = wide      ? d.alpha ? heif_chroma_interleaved_RRGGBBAA_LE : heif_chroma_interleaved_RRGGBB_LE
                             : d.alpha ? heif_chroma_interleaved_RGBA
                                       : heif_chroma_interleaved_RGB;
  expect_ok(heif_image_create(samples.width(), samples.height(), heif_colorspace_RGB, layout, &image));
  expect_ok(heif_image_add_plane(image, heif_channel_interleaved, samples.width(), samples.height(), d.bits));
  int stride = 0;
  uint8_t* const plane = heif_image_get_plane(image, heif_channel_interleaved, &stride);
  const size_t row = size_t(samples.width()) * size_t(samples.channels());
  for (int y = 0; y < samples.height(); ++y)
    for (size_t i = 0; i < row; ++i) {
      const uint16_t v = samples.pixel(0, y)[i];
      if (wide)
        std::memcpy(plane + size_t(y) * size_t(stride) + 2 * i, &v, 2);
      else
        plane[size_t(y) * size_t(stride) + i] = static_cast<uint8_t>(v);
    }
  heif_color_profile_nclx* const nclx = heif_nclx_color_profile_alloc();
  nclx->color_primaries = static_cast<heif_color_primaries>(d.primaries);
  nclx->transfer_characteristics = static_cast<heif_transfer_characteristics>(d.transfer);
  nclx->matrix_coefficients = heif_matrix_coefficients_ITU_R_BT_601_6;
  nclx->full_range_flag = 1;
  if (d.icc.empty())
    heif_image_set_nclx_color_profile(image, nclx);
  else
    heif_image_set_raw_color_profile(image, "prof", d.icc.data(), d.icc.size());
  heif_encoding_options* const options = heif_encoding_options_alloc();
  options->image_orientation = static_cast<heif_orientation>(d.orientation);
  options->macOS_compatibility_workaround_no_nclx_profile = 0;
  heif_image_handle* handle = nullptr;
  expect_ok(heif_context_encode_image(context, image, encoder, options, &handle));
  if (!d.exif.empty()) expect_ok(heif_context_add_exif_metadata(context, handle, d.exif.data(), int(d.exif.size())));
  std::string bytes;
  heif_writer writer{1, [](heif_context*, const void* data, size_t size, void* to) {
                       static_cast<std::string*>(to)->assign(static_cast<const char*>(data), size);
                       return heif_error{heif_error_Ok, heif_suberror_Unspecified, ""};
                     }};
  expect_ok(heif_context_write(context, &writer, &bytes));
  heif_image_handle_release(handle);
  heif_encoding_options_free(options);
  heif_nclx_color_profile_free(nclx);
  heif_image_release(image);
  heif_encoder_release(encoder);
  heif_context_free(context);
  return bytes;
}

inline std::string heif_bytes(const Image8& image, const HeifDesc& d) {
  Image16 wide(image.width(), image.height(), image.channels());
  const unsigned top = (1u << d.bits) - 1;
  for (size_t i = 0; i < wide.data().size(); ++i) wide.data()[i] = uint16_t((image.data()[i] * top + 127) / 255);
  return heif_bytes(wide, d);
}

// A big-endian number of four bytes of `bytes` grows by `by`.
inline void grow_number(std::string& bytes, size_t at, unsigned by) {
  uint32_t v = 0;
  for (size_t i = 0; i < 4; ++i) v = v << 8 | static_cast<unsigned char>(bytes[at + i]);
  v += by;
  for (size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<char>(v >> (24 - 8 * i));
}

// The auxiliary picture (alpha) refers to two pictures, as those of newer phones do. libheif writes 16-bit item numbers and a
// meta box before the data with 32-bit extents: two bytes more move the data. Empty: this libheif writes them otherwise.
inline std::string with_shared_auxiliary(std::string bytes) {
  const size_t meta = bytes.find("meta"), iref = bytes.find("iref"), auxl = bytes.find("auxl"), iloc = bytes.find("iloc");
  if (std::max({meta, iref, auxl, iloc}) == std::string::npos) return {};
  const auto two = [&](size_t at) { return size_t(uint8_t(bytes[at])) << 8 | size_t(uint8_t(bytes[at + 1])); };
  // iloc: version 0 or 1, sizes in bytes 8 and 9 behind the type, then the items.
  const unsigned version = uint8_t(bytes[iloc + 4]);
  const unsigned offsets = uint8_t(bytes[iloc + 8]) >> 4, lengths = uint8_t(bytes[iloc + 8]) & 15,
                 bases = uint8_t(bytes[iloc + 9]) >> 4;
  if (offsets != 4 || version > 1) return {};
  size_t at = iloc + 12;
  for (size_t items = two(iloc + 10); items > 0; --items) {
    at += 2;
    const bool in_file = version == 0 || two(at) == 0;
    at += (version == 1 ? 2 : 0) + 2 + bases;
    const size_t extents = two(at);
    at += 2;
    for (size_t e = 0; e < extents; ++e, at += offsets + lengths)
      if (in_file) grow_number(bytes, at, 2);
  }
  for (const size_t box : {meta, iref, auxl}) grow_number(bytes, box - 4, 2);
  bytes[auxl + 7] = 2;                          // count
  bytes.insert(auxl + 10, bytes, auxl + 4, 2);  // and the second: the picture itself
  return bytes;
}

}  // namespace vitrine::test
