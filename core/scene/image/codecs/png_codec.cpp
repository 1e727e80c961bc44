// PNG codec (libpng). Errors leave it by longjmp, so no object with a destructor lives between setjmp and the calls.
#include <algorithm>
#include <cstring>

#include <png.h>

#include "core/scene/image/codecs/codecs_here.h"

namespace vitrine {

namespace {

constexpr png_uint_32 kLongestPngSide = 1u << 20;

struct PngInput {
  std::string_view bytes;
  size_t at = 0;
  char text[256] = {};
};

[[noreturn]] void leave_png(png_structp png, png_const_charp message) {
  auto* const input = static_cast<PngInput*>(png_get_error_ptr(png));
  std::strncpy(input->text, message, sizeof input->text - 1);
  png_longjmp(png, 1);
}

// libpng warnings (profiles, texts, checksums outside the pixel data) do not affect the pixels.
void ignore_png_warning(png_structp, png_const_charp) {}

void read_png_bytes(png_structp png, png_bytep to, size_t count) {
  auto* const input = static_cast<PngInput*>(png_get_io_ptr(png));
  if (count > input->bytes.size() - input->at) png_error(png, "the file ends in the middle of a chunk");
  std::memcpy(to, input->bytes.data() + input->at, count);
  input->at += count;
}

template <class T>
void read_png_rows(png_structp png, png_infop info, int passes, Image<T>& out) {
  out = Image<T>(static_cast<int>(png_get_image_width(png, info)), static_cast<int>(png_get_image_height(png, info)),
                 png_get_channels(png, info));
  for (int pass = 0; pass < passes; ++pass)
    for (int y = 0; y < out.height(); ++y) png_read_row(png, reinterpret_cast<png_bytep>(out.pixel(0, y)), nullptr);
}

}  // namespace

std::string decode_png(std::string_view bytes, Image8& out8, Image16& out16) {
  PngInput input{bytes};
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &input, leave_png, ignore_png_warning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  if (info == nullptr) {
    png_destroy_read_struct(&png, nullptr, nullptr);
    return "libpng cannot be set up";
  }
  if (setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_read_struct(&png, &info, nullptr);
    return input.text;
  }
  png_set_read_fn(png, &input, read_png_bytes);
  png_set_user_limits(png, kLongestPngSide, kLongestPngSide);
  png_read_info(png, info);
  const int colour = png_get_color_type(png, info);
  const bool wide = png_get_bit_depth(png, info) == 16, transparent = png_get_valid(png, info, PNG_INFO_tRNS) != 0;
  png_set_expand(png);  // palettes, grey below 8 bits, transparent colours
  if (colour == PNG_COLOR_TYPE_GRAY_ALPHA || (colour == PNG_COLOR_TYPE_GRAY && transparent)) png_set_gray_to_rgb(png);
  if (wide) png_set_swap(png);
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);
  if (wide)
    read_png_rows(png, info, passes, out16);
  else
    read_png_rows(png, info, passes, out8);
  png_destroy_read_struct(&png, &info, nullptr);
  return {};
}

}  // namespace vitrine
