// TIFF codec (libtiff), strip by strip or tile by tile. Each open file has its own message handlers, so messages of threads do
// not mix.
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>

#include <tiffio.h>

#include <fmt/format.h>

#include "core/scene/image/codecs/codecs_here.h"

namespace vitrine {

namespace {

constexpr tmsize_t kLargestTiffBlock = tmsize_t(1) << 30;

struct TiffInput {
  std::string_view bytes;
  uint64_t at = 0;
  std::string error;  // first message; later ones are consequences
};

int keep_error(TIFF*, void* user, const char*, const char* format, va_list arguments) {
  auto* const input = static_cast<TiffInput*>(user);
  char text[512];
  std::vsnprintf(text, sizeof text, format, arguments);
  if (input->error.empty()) input->error = text;
  return 1;
}

// Warnings concern irrelevant tags, except those of JPEG strips whose data end early.
int keep_grave_warning(TIFF* tiff, void* user, const char* module, const char* format, va_list arguments) {
  char text[512];
  va_list again;
  va_copy(again, arguments);
  std::vsnprintf(text, sizeof text, format, again);
  va_end(again);
  if (std::strstr(text, "Corrupt JPEG data") || std::strstr(text, "Premature end of JPEG"))
    keep_error(tiff, user, module, format, arguments);
  return 1;
}

tmsize_t read_bytes(thandle_t handle, void* to, tmsize_t count) {
  auto* const in = static_cast<TiffInput*>(handle);
  if (count < 0 || in->at >= in->bytes.size()) return 0;
  const size_t n = std::min(static_cast<size_t>(count), in->bytes.size() - static_cast<size_t>(in->at));
  std::memcpy(to, in->bytes.data() + in->at, n);
  in->at += n;
  return static_cast<tmsize_t>(n);
}
tmsize_t write_nothing(thandle_t, void*, tmsize_t) { return 0; }
toff_t seek_to(thandle_t handle, toff_t offset, int whence) {
  auto* const in = static_cast<TiffInput*>(handle);
  in->at = whence == SEEK_SET ? offset : whence == SEEK_CUR ? in->at + offset : in->bytes.size() + offset;
  return in->at;
}
int close_nothing(thandle_t) { return 0; }
toff_t size_of_input(thandle_t handle) { return static_cast<TiffInput*>(handle)->bytes.size(); }
int map_input(thandle_t handle, void** base, toff_t* size) {
  auto* const in = static_cast<TiffInput*>(handle);
  *base = const_cast<char*>(in->bytes.data());
  *size = in->bytes.size();
  return 1;
}
void unmap_nothing(thandle_t, void*, toff_t) {}

std::string damaged_block(const TiffInput& input, const char* kind, uint32_t index, uint32_t count) {
  return fmt::format("the TIFF is damaged or cut short: {} {} of {} cannot be decoded ({})", kind, index + 1, count,
                     input.error.empty() ? "too few bytes" : input.error);
}

std::string read_tiles(TIFF* tiff, TiffInput& input, int width, int height, unsigned planes,
                       const std::function<void(const TiffBlock&)>& put) {
  uint32_t tile_width = 0, tile_height = 0;
  TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &tile_width);
  TIFFGetField(tiff, TIFFTAG_TILELENGTH, &tile_height);
  const tmsize_t size = TIFFTileSize(tiff), row_bytes = TIFFTileRowSize(tiff);
  constexpr uint32_t kLargestSide = uint32_t{1} << 30;  // sum of it and an image side does not overflow
  if (tile_width == 0 || tile_height == 0 || tile_width > kLargestSide || tile_height > kLargestSide || size <= 0 || row_bytes <= 0 || size > kLargestTiffBlock)
    return fmt::format("the TIFF has tiles of {} x {} pixels: it is damaged", tile_width, tile_height);
  const uint32_t across = (uint32_t(width) + tile_width - 1) / tile_width,
                 down = (uint32_t(height) + tile_height - 1) / tile_height;
  const uint32_t count = TIFFNumberOfTiles(tiff);
  std::vector<uint8_t> buffer(static_cast<size_t>(size));
  for (unsigned plane = 0; plane < planes; ++plane)
    for (uint32_t i = 0; i < across * down; ++i) {
      const uint32_t tile = plane * across * down + i;
      if (tile >= count || TIFFReadEncodedTile(tiff, tile, buffer.data(), size) != size || !input.error.empty())
        return damaged_block(input, "tile", tile, count);
      const int x = int(i % across * tile_width), y = int(i / across * tile_height);
      put({x, y, std::min(int(tile_width), width - x), std::min(int(tile_height), height - y), plane, buffer.data(),
           size_t(row_bytes)});
    }
  return {};
}

std::string read_strips(TIFF* tiff, TiffInput& input, int width, int height, unsigned planes,
                        const std::function<void(const TiffBlock&)>& put) {
  uint32_t rows_per_strip = 0;
  TIFFGetFieldDefaulted(tiff, TIFFTAG_ROWSPERSTRIP, &rows_per_strip);
  rows_per_strip = std::min(std::max(rows_per_strip, 1u), uint32_t(height));
  const tmsize_t size = TIFFStripSize(tiff), row_bytes = TIFFScanlineSize(tiff);
  if (size <= 0 || row_bytes <= 0 || size > kLargestTiffBlock)
    return fmt::format("the TIFF has strips of {} bytes: it is damaged", size);
  const uint32_t count = TIFFNumberOfStrips(tiff), per_plane = (uint32_t(height) + rows_per_strip - 1) / rows_per_strip;
  std::vector<uint8_t> buffer(static_cast<size_t>(size));
  for (unsigned plane = 0; plane < planes; ++plane)
    for (uint32_t i = 0; i < per_plane; ++i) {
      const uint32_t strip = plane * per_plane + i;
      const int y = int(i * rows_per_strip), rows = std::min(int(rows_per_strip), height - y);
      const tmsize_t wanted = std::min(TIFFVStripSize(tiff, uint32_t(rows)), size);
      if (strip >= count || wanted < tmsize_t(rows) * row_bytes ||
          TIFFReadEncodedStrip(tiff, strip, buffer.data(), wanted) != wanted || !input.error.empty())
        return damaged_block(input, "strip", strip, count);
      put({0, y, width, rows, plane, buffer.data(), size_t(row_bytes)});
    }
  return {};
}

std::string read_converted(TIFF* tiff, TiffInput& input, int width, int height,
                           const std::function<void(const TiffBlock&)>& put) {
  std::vector<uint32_t> raster(size_t(width) * size_t(height));
  const int stored = ORIENTATION_TOPLEFT;  // the orientation is applied elsewhere
  TIFFSetField(tiff, TIFFTAG_ORIENTATION, stored);
  if (!TIFFReadRGBAImageOriented(tiff, uint32_t(width), uint32_t(height), raster.data(), stored, 1) || !input.error.empty())
    return fmt::format("the TIFF cannot be decoded ({})", input.error);
  put({0, 0, width, height, 0, reinterpret_cast<const uint8_t*>(raster.data()), 4 * size_t(width)});
  return {};
}

}  // namespace

std::string decode_tiff(std::string_view bytes, const TiffRequest& request, const std::function<void(const TiffBlock&)>& put) {
  TiffInput input{.bytes = bytes, .at = 0, .error = {}};
  const std::unique_ptr<TIFFOpenOptions, void (*)(TIFFOpenOptions*)> options(TIFFOpenOptionsAlloc(), TIFFOpenOptionsFree);
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), keep_error, &input);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), keep_grave_warning, &input);
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), kLargestTiffBlock);
  // Mode h: do not read the first directory on opening, it may be damaged and unused.
  const std::unique_ptr<TIFF, void (*)(TIFF*)> file(
      TIFFClientOpenExt("picture", "rh", &input, read_bytes, write_nothing, seek_to, close_nothing, size_of_input, map_input,
                        unmap_nothing, options.get()),
      [](TIFF* t) {
        if (t) TIFFClose(t);
      });
  TIFF* const tiff = file.get();
  if (!tiff || !TIFFSetSubDirectory(tiff, request.directory)) return fmt::format("the TIFF is damaged ({})", input.error);
  uint32_t width = 0, height = 0;
  uint16_t compression = 1, planar = 1, bits = 1, samples = 1;
  TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &compression);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &planar);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &samples);
  if (width != request.width || height != request.height || bits != request.bits || samples != request.samples ||
      (planar == PLANARCONFIG_SEPARATE) != request.planar)
    return fmt::format("the TIFF is damaged: its directory contradicts itself{}{}", input.error.empty() ? "" : ": ", input.error);
  if (!TIFFIsCODECConfigured(compression))
    return fmt::format("the compression of the TIFF (number {}) is not known to libtiff: export it with LZW, Deflate or none",
                       compression);
  input.error.clear();  // errors of irrelevant tags
  if (request.rgba) return read_converted(tiff, input, int(width), int(height), put);
  if (request.ycbcr && compression == COMPRESSION_JPEG) TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
  if (TIFFIsTiled(tiff)) return read_tiles(tiff, input, int(width), int(height), request.planar ? request.planes : 1, put);
  return read_strips(tiff, input, int(width), int(height), request.planar ? request.planes : 1, put);
}

}  // namespace vitrine
