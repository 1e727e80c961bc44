#include "core/intake/film/film_frames.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <zlib.h>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/parallel.h"
#include "core/intake/photos/measures.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

constexpr int kMeasuredSide = 800, kThumbnailSide = 240;

ImageF shrunk(const ImageF& image, int side) {
  const int longest = std::max(image.width(), image.height());
  if (longest <= side) return image;
  const double s = double(side) / longest;
  return resized(image, std::max(int(std::lround(image.width() * s)), 1), std::max(int(std::lround(image.height() * s)), 1));
}

// Whether frames are decoded as YCbCr of 16 bits and converted here: of more than 8 bits ffmpeg 5.1 makes RGB that is 0.2 % too
// dark, which is 2 % of the light of PQ.
bool converted_here(const FilmInfo& film) { return film.bits > 8 && !film.is_rgb; }

// ITU-R BT.601, BT.709, BT.2020, SMPTE 240M, FCC: weights of red and blue in luma.
struct Luma {
  double red, blue;
};
Luma luma_of(const std::string& matrix) {
  if (matrix == "bt2020") return {0.2627, 0.0593};
  if (matrix == "bt601" || matrix == "smpte170m") return {0.299, 0.114};
  if (matrix == "smpte240m") return {0.212, 0.087};
  if (matrix == "fcc") return {0.30, 0.11};
  return {0.2126, 0.0722};
}

// `planes`: luma, Cb, Cr, [3 * h * w], the bits of the film followed by zeros.
Image16 rgb_of(const FilmInfo& film, int width, int height, const std::vector<uint8_t>& planes) {
  Image16 image(width, height, 3);
  const size_t n = image.pixel_count();
  const auto at = [&](size_t i) { return double(planes[2 * i] | planes[2 * i + 1] << 8); };
  const double top = 65536 - double(1 << (16 - film.bits));  // the largest sample
  const double black = film.full_range ? 0 : 16 * 256, white = film.full_range ? top : 235 * 256;
  const double chroma = film.full_range ? top : 224 * 256, zero = 128 * 256;
  const Luma k = luma_of(film.matrix);
  for (size_t i = 0; i < n; ++i) {
    const double y = (at(i) - black) / (white - black), b = (at(n + i) - zero) / chroma, r = (at(2 * n + i) - zero) / chroma;
    const double red = y + 2 * (1 - k.red) * r, blue = y + 2 * (1 - k.blue) * b;
    const double green = (y - k.red * red - k.blue * blue) / (1 - k.red - k.blue);
    const double rgb[] = {red, green, blue};
    for (size_t c = 0; c < 3; ++c) image.data()[3 * i + c] = uint16_t(std::lround(65535 * std::clamp(rgb[c], 0.0, 1.0)));
  }
  return image;
}

struct RawFrame {
  size_t index = 0;
  std::vector<uint8_t> bytes;
};

// Writes the file and measures the frame.
WrittenFrame written(const FilmInfo& film, const ColorProfilePtr& profile, int width, int height, const RawFrame& raw,
                     const fs::path& path) {
  ImageF values(width, height, 3);
  if (film.bits > 8) {
    Image16 image(width, height, 3);
    if (converted_here(film))
      image = rgb_of(film, width, height, raw.bytes);
    else
      std::memcpy(image.data().data(), raw.bytes.data(), raw.bytes.size());
    for (size_t i = 0; i < values.data().size(); ++i) values.data()[i] = float(image.data()[i]) / 65535.0f;
    write_png16(path, image);
    write_file(path, with_cicp(read_file(path), film.color));
  } else {
    Image8 image(width, height, 3);
    std::memcpy(image.data().data(), raw.bytes.data(), raw.bytes.size());
    values = floats_of(image);
    write_file(path, with_cicp(png_bytes(image), film.color));
  }
  values = shrunk(values, kMeasuredSide);
  profile->to_linear(values);
  const PhotoMeasures m = measured(srgb8_from_linear(values));
  return {m.blur_px, m.texture > 0, srgb8_from_linear(shrunk(values, kThumbnailSide))};
}

}  // namespace

std::string with_cicp(const std::string& png, const Cicp& color) {
  constexpr size_t kAfterHeader = 8 + 4 + 4 + 13 + 4;  // signature; length, type, data and checksum of IHDR
  VITRINE_CHECK(png.size() > kAfterHeader && png.compare(12, 4, "IHDR") == 0, "no PNG");
  std::string chunk = "cICP";
  for (unsigned v : {color.primaries, color.transfer, 0u, 1u}) chunk.push_back(char(v));
  const uLong sum = crc32(0, reinterpret_cast<const Bytef*>(chunk.data()), uInt(chunk.size()));
  chunk.insert(0, std::string("\0\0\0\4", 4));
  for (int shift : {24, 16, 8, 0}) chunk.push_back(char((sum >> shift) & 255));
  std::string out = png;
  return out.insert(kAfterHeader, chunk);
}

std::vector<WrittenFrame> write_film_frames(const FilmInfo& film, const std::vector<FrameFile>& files,
                                            const std::function<void(size_t)>& progress) {
  const ColorProfilePtr profile = cicp_profile(film.color);
  VITRINE_CHECK(profile != nullptr, "no profile for the colours {} {}", film.color.primaries, film.color.transfer);
  int width = film.width, height = film.height;
  if (film.orientation >= 5) std::swap(width, height);
  const char* range = film.full_range ? "full" : "limited";
  DecodeRequest request{
      .film = film,
      .filters = fmt::format("scale={}:{}:in_color_matrix={}:in_range={}:out_range={}:"
                             "flags=bicubic+accurate_rnd+full_chroma_int+full_chroma_inp+bitexact",
                             film.width, film.height, film.matrix, range, converted_here(film) ? range : "full"),
      .pixel_format = converted_here(film) ? "yuv444p16le"
                      : film.bits > 8      ? "rgb48le"
                                           : "rgb24",
      .frame_bytes = size_t(width) * size_t(height) * (film.bits > 8 ? 6 : 3),
      .only = {}};
  for (const FrameFile& f : files) request.only.push_back(f.pts);
  std::vector<WrittenFrame> out(files.size());
  std::vector<RawFrame> batch;
  const auto flush = [&] {
    parallel_for(batch.size(), 1, [&](size_t i) {
      out[batch[i].index] = written(film, profile, width, height, batch[i], files[batch[i].index].path);
    });
    if (!batch.empty()) progress(batch.back().index + 1);
    batch.clear();
  };
  std::string damage;
  const std::vector<FrameTime> times = decode_frames(
      request,
      [&](size_t n, std::span<const uint8_t> bytes) {
        if (n >= files.size()) return;
        batch.push_back({n, {bytes.begin(), bytes.end()}});
        if (batch.size() >= size_t(std::max(thread_limit(), 1))) flush();
      },
      damage);
  flush();
  bool same = times.size() == files.size();
  for (size_t i = 0; same && i < times.size(); ++i) same = times[i].pts == files[i].pts;
  if (!same)
    throw_bad_film(film.path,
                   fmt::format("two passes over it give different frames ({} of {}){}{}", times.size(), files.size(),
                               damage.empty() ? "" : ": ", damage),
                   "is the file being written? Else export it as H.264 in MP4");
  return out;
}

}  // namespace vitrine
