// HEIC and AVIF codec (libheif), and the table of the library of camera codecs.
#include "core/scene/image/codecs/camera_codecs_here.h"

#ifdef VITRINE_WITH_LIBHEIF

#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <libheif/heif.h>

namespace vitrine {

namespace {

template <auto release>
struct Releaser {
  template <class T>
  void operator()(T* p) const {
    release(p);
  }
};
using Context = std::unique_ptr<heif_context, Releaser<heif_context_free>>;
using Handle = std::unique_ptr<heif_image_handle, Releaser<heif_image_handle_release>>;
using Picture = std::unique_ptr<heif_image, Releaser<heif_image_release>>;

std::string failure(const heif_error& error) {
  std::string why = error.message ? error.message : "unknown error";
  if (!heif_have_decoder_for_format(heif_compression_HEVC))
    why += "; its decoder of HEVC is missing: apt install libheif-plugin-libde265";
  if (!heif_have_decoder_for_format(heif_compression_AV1))
    why += "; its decoder of AV1 is missing: apt install libheif-plugin-dav1d";
  return fmt::format("libheif {} refuses it: {}", heif_get_version(), why);
}

template <class T>
Image<T> rows_of(const uint8_t* plane, int stride, int width, int height, int channels) {
  Image<T> out(width, height, channels);
  for (int y = 0; y < height; ++y)
    std::copy_n(reinterpret_cast<const T*>(plane + size_t(y) * size_t(stride)), size_t(width) * size_t(channels),
                out.pixel(0, y));
  return out;
}

// Samples of `bits` bits to the full range of 16.
void widen(Image16& image, int bits) {
  const uint32_t top = (1u << bits) - 1;
  for (uint16_t& v : image.data()) v = uint16_t((std::min<uint32_t>(v, top) * 65535u + top / 2) / top);
}

std::string decoders() {
  std::string list;
  for (const auto& [format, name] : {std::pair{heif_compression_HEVC, "HEVC"}, {heif_compression_AV1, "AV1"}})
    list += fmt::format("{}{}{}", list.empty() ? "" : ", ", heif_have_decoder_for_format(format) ? "" : "no ", name);
  return list;
}

}  // namespace

std::string decode_heif(std::string_view bytes, bool alpha, Image8& out8, Image16& out16) {
  const Context context(heif_context_alloc());
  if (!context) return "libheif cannot be set up";
  heif_context_set_max_decoding_threads(context.get(), 0);  // photos are decoded in parallel
  heif_error error = heif_context_read_from_memory_without_copy(context.get(), bytes.data(), bytes.size(), nullptr);
  if (error.code != heif_error_Ok) return failure(error);
  heif_image_handle* primary = nullptr;
  error = heif_context_get_primary_image_handle(context.get(), &primary);
  const Handle handle(primary);
  if (error.code != heif_error_Ok) return failure(error);
  constexpr int64_t kMostPixels = int64_t{1} << 28;  // the size in the coded data may differ from that in the boxes
  if (int64_t(heif_image_handle_get_width(primary)) * heif_image_handle_get_height(primary) > kMostPixels)
    return "its picture has more pixels than vitrine takes";
  const bool wide = heif_image_handle_get_luma_bits_per_pixel(primary) > 8;
  const heif_chroma layout = wide    ? alpha ? heif_chroma_interleaved_RRGGBBAA_LE : heif_chroma_interleaved_RRGGBB_LE
                             : alpha ? heif_chroma_interleaved_RGBA
                                     : heif_chroma_interleaved_RGB;
  heif_image* decoded = nullptr;
  error = heif_decode_image(primary, &decoded, heif_colorspace_RGB, layout, nullptr);
  const Picture picture(decoded);
  if (error.code != heif_error_Ok) return failure(error);
  int stride = 0;
  const uint8_t* const plane = heif_image_get_plane_readonly(decoded, heif_channel_interleaved, &stride);
  const int width = heif_image_get_primary_width(decoded), height = heif_image_get_primary_height(decoded);
  const int channels = alpha ? 4 : 3, bits = heif_image_get_bits_per_pixel_range(decoded, heif_channel_interleaved);
  if (!plane || width <= 0 || height <= 0 || stride < width * channels * (wide ? 2 : 1) || (wide && (bits <= 8 || bits > 16)))
    return "its picture cannot be decoded";
  if (wide) {
    out16 = rows_of<uint16_t>(plane, stride, width, height, channels);
    widen(out16, bits);
  } else {
    out8 = rows_of<uint8_t>(plane, stride, width, height, channels);
  }
  return {};
}

std::string heif_version() { return fmt::format("libheif {} ({})", heif_get_version(), decoders()); }

}  // namespace vitrine

#else

namespace vitrine {

namespace {
constexpr const char* kNoLibheif = "vitrine was built without libheif: install libheif-dev and build again";
}

std::string decode_heif(std::string_view, bool, Image8&, Image16&) { return kNoLibheif; }
std::string heif_version() { return kNoLibheif; }

}  // namespace vitrine

#endif

extern "C" __attribute__((visibility("default"))) const vitrine::CameraCodecs vitrine_camera_codecs{
    vitrine::decode_heif, vitrine::read_raw_facts, vitrine::decode_raw, vitrine::heif_version, vitrine::raw_version};
