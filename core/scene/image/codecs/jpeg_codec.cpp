// JPEG codec (libjpeg). Errors leave it by longjmp, so no object with a destructor lives between setjmp and the calls.
#include <csetjmp>
#include <cstdio>

#include <jpeglib.h>

#include <jerror.h>

#include "core/scene/image/codecs/codecs_here.h"

namespace vitrine {

namespace {

struct JpegErrors {
  jpeg_error_mgr manager;  // must be first: libjpeg sees only this part
  std::jmp_buf escape;
  char text[JMSG_LENGTH_MAX];
};

[[noreturn]] void leave(j_common_ptr info) {
  auto* const errors = reinterpret_cast<JpegErrors*>(info->err);
  errors->manager.format_message(info, errors->text);
  std::longjmp(errors->escape, 1);
}

// Warnings after which a part of the image would be grey or garbage abort the decoding. Others are harmless (bytes between
// segments, an unknown colour transform). A premature end of file (JWRN_HIT_MARKER) is harmless unless a row needs the missing
// data.
void judge_message(j_common_ptr info, int level) {
  if (level >= 0) return;  // trace message
  switch (info->err->msg_code) {
    case JWRN_HIT_MARKER:
    case JWRN_HUFF_BAD_CODE:
    case JWRN_MUST_RESYNC:
    case JWRN_ARITH_BAD_CODE:
      leave(info);
    default:
      break;
  }
}

void say_nothing(j_common_ptr) {}

void decode_rows(jpeg_decompress_struct& info, std::string_view bytes, int channels, int reduction, Image8& out) {
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&info, TRUE);
  if (channels == 0) channels = info.num_components == 1 ? 1 : 3;
  info.out_color_space = channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
  info.scale_num = 1;
  info.scale_denom = static_cast<unsigned>(reduction);
  jpeg_start_decompress(&info);
  out = Image8(static_cast<int>(info.output_width), static_cast<int>(info.output_height), channels);
  while (info.output_scanline < info.output_height) {
    JSAMPROW row = out.pixel(0, static_cast<int>(info.output_scanline));
    jpeg_read_scanlines(&info, &row, 1);
  }
}

}  // namespace

std::string decode_jpeg(std::string_view bytes, int channels, int reduction, Image8& out) {
  jpeg_decompress_struct info;
  JpegErrors errors;
  info.err = jpeg_std_error(&errors.manager);
  errors.manager.error_exit = leave;
  errors.manager.emit_message = judge_message;
  errors.manager.output_message = say_nothing;
  if (setjmp(errors.escape) != 0) {
    jpeg_destroy_decompress(&info);
    return errors.text;
  }
  jpeg_create_decompress(&info);
  decode_rows(info, bytes, channels, reduction, out);
  jpeg_destroy_decompress(&info);
  return {};
}

}  // namespace vitrine
