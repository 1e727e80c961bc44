#include "core/image/exr.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <fstream>
#include <utility>

#include <half.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>

#include "core/base/error.h"
#include "core/base/file.h"

namespace vitrine {

namespace {

constexpr size_t kMaxChannels = 256;
constexpr int kMaxSide = 1 << 20, kMaxTile = 1 << 12;
// A file may be black, but even then so many values need some bytes: a damaged header asks for memory without them.
constexpr size_t kAlwaysFine = size_t(1) << 26, kValuesPerByte = 1024;

[[noreturn]] void bad_exr(const fs::path& path, std::string why) {
  throw Error(ErrorKind::Input, "cannot read an EXR image",
              {.where = path.string(),
               .why = std::move(why),
               .hint = "the file is damaged or not an EXR: restore it, or delete it and run the stage that wrote it again",
               .code = "BAD_EXR"});
}

// R,G,B,A and X,Y,Z have a natural order that the file (which sorts by name) does not keep; layers keep it within a layer.
int natural_rank(const std::string& channel) {
  const std::string base = channel.substr(channel.rfind('.') + 1);
  for (const auto& [word, rank] : {std::pair{"R", 0},
                                   {"G", 1},
                                   {"B", 2},
                                   {"A", 3},
                                   {"X", 0},
                                   {"Y", 1},
                                   {"Z", 2},
                                   {"x", 0},
                                   {"y", 1},
                                   {"z", 2},
                                   {"r", 0},
                                   {"g", 1},
                                   {"b", 2},
                                   {"a", 3}})
    if (base == word) return rank;
  return 0;
}
std::string layer_of(const std::string& channel) {
  const size_t dot = channel.rfind('.');
  return dot == std::string::npos ? std::string() : channel.substr(0, dot);
}

// Bytes that the library reads for an attribute of this type, whatever the size beside it says.
size_t fixed_size(const std::string& type) {
  static const std::map<std::string, size_t> sizes = {{"box2f", 16},
                                                      {"box2i", 16},
                                                      {"chromaticities", 32},
                                                      {"compression", 1},
                                                      {"deepImageState", 1},
                                                      {"double", 8},
                                                      {"envmap", 1},
                                                      {"float", 4},
                                                      {"int", 4},
                                                      {"keycode", 28},
                                                      {"lineOrder", 1},
                                                      {"m33d", 72},
                                                      {"m33f", 36},
                                                      {"m44d", 128},
                                                      {"m44f", 64},
                                                      {"rational", 8},
                                                      {"tiledesc", 9},
                                                      {"timecode", 8},
                                                      {"v2d", 16},
                                                      {"v2f", 8},
                                                      {"v2i", 8},
                                                      {"v3d", 24},
                                                      {"v3f", 12},
                                                      {"v3i", 12}};
  const auto found = sizes.find(type);
  return found == sizes.end() ? 0 : found->second;
}

// Names with 16 bytes behind each, and an empty name at the very end.
bool whole_channel_list(const std::string& list) {
  for (size_t at = 0; at < list.size();) {
    const size_t end = list.find('\0', at);
    if (end == at) return at + 1 == list.size();
    if (end == std::string::npos || list.size() - end < 17) return false;
    at = end + 17;
  }
  return false;
}

bool whole_preview(const std::string& preview) {
  uint32_t size[2];
  if (preview.size() < sizeof size) return false;
  std::memcpy(size, preview.data(), sizeof size);
  return size[0] < 1 << 16 && size[1] < 1 << 16 && preview.size() == sizeof size + 4 * size_t(size[0]) * size[1];
}

// Attributes of the headers: name, type, size, bytes; an empty name ends them. The library allocates what the size says before it
// looks whether the file has it; and some types it reads by their contents, after which it is elsewhere than the size says.
void check_attributes(const fs::path& path) {
  constexpr size_t kLongestName = 256;
  std::ifstream in(path, std::ios::binary);
  const uint64_t size = fs::file_size(path);
  uint64_t at = 8;  // magic number and version
  in.seekg(5);
  const bool several_parts = in.get() & 0x10;  // an empty header ends them
  in.seekg(static_cast<std::streamoff>(at));
  const auto word = [&] {
    std::string text;
    for (int c = in.get(); c > 0 && text.size() < kLongestName; c = in.get()) text += static_cast<char>(c);
    at += text.size() + 1;
    return text;
  };
  while (in) {
    if (word().empty() && (!several_parts || word().empty())) return;
    const std::string type = word();
    unsigned char raw[4] = {};
    in.read(reinterpret_cast<char*>(raw), 4);
    const uint64_t bytes = raw[0] | raw[1] << 8 | raw[2] << 16 | uint64_t(raw[3]) << 24;
    at += 4;
    bool whole = in && bytes <= size && at + bytes <= size;
    if (const size_t fixed = fixed_size(type); whole && fixed != 0) whole = bytes == fixed;
    if (whole && (type == "chlist" || type == "preview")) {
      std::string content(bytes, '\0');
      in.read(content.data(), static_cast<std::streamsize>(bytes));
      whole = in && (type == "chlist" ? whole_channel_list(content) : whole_preview(content));
    }
    if (!whole) bad_exr(path, "its header is damaged, or the file is cut short");
    in.seekg(static_cast<std::streamoff>(at += bytes));
  }
}

}  // namespace

ExrImage read_exr(const fs::path& path, size_t max_pixels) {
  if (!fs::is_regular_file(path)) bad_exr(path, "there is no such file");
  try {
    check_attributes(path);
    // Checked by the library before it allocates its own tables.
    Imf::Header::setMaxImageSize(kMaxSide, kMaxSide);
    Imf::Header::setMaxTileSize(kMaxTile, kMaxTile);
    Imf::InputFile file(path.c_str(), 1);
    const Imath::Box2i window = file.header().dataWindow();
    const int64_t width = int64_t(window.max.x) - window.min.x + 1, height = int64_t(window.max.y) - window.min.y + 1;
    if (width <= 0 || height <= 0 || size_t(width) * size_t(height) > max_pixels)
      bad_exr(path, fmt::format("its size of {} x {} pixels is not plausible", width, height));

    ExrImage image;
    for (auto it = file.header().channels().begin(); it != file.header().channels().end(); ++it) {
      if (it.channel().xSampling != 1 || it.channel().ySampling != 1) bad_exr(path, "it has subsampled channels");
      image.channels.emplace_back(it.name());
    }
    if (image.channels.empty() || image.channels.size() > kMaxChannels)
      bad_exr(path, fmt::format("it has {} channels", image.channels.size()));
    const size_t values = size_t(width) * size_t(height) * image.channels.size(), bytes = fs::file_size(path);
    if (values > kAlwaysFine && values / kValuesPerByte > bytes)
      bad_exr(path,
              fmt::format("{} bytes cannot hold {} x {} pixels of {} channels", bytes, width, height, image.channels.size()));
    std::stable_sort(image.channels.begin(), image.channels.end(), [](const std::string& a, const std::string& b) {
      return std::pair(layer_of(a), natural_rank(a)) < std::pair(layer_of(b), natural_rank(b));
    });

    const int channels = static_cast<int>(image.channels.size());
    image.pixels = ImageF(int(width), int(height), channels);
    Imf::FrameBuffer buffer;
    const size_t x_stride = sizeof(float) * size_t(channels), y_stride = x_stride * size_t(width);
    char* origin = reinterpret_cast<char*>(image.pixels.data().data()) - ptrdiff_t(window.min.x) * ptrdiff_t(x_stride) -
                   ptrdiff_t(window.min.y) * ptrdiff_t(y_stride);
    for (int c = 0; c < channels; ++c)
      buffer.insert(image.channels[size_t(c)], Imf::Slice(Imf::FLOAT, origin + sizeof(float) * size_t(c), x_stride, y_stride));
    file.setFrameBuffer(buffer);
    file.readPixels(window.min.y, window.max.y);
    for (auto it = file.header().begin(); it != file.header().end(); ++it)
      if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&it.attribute()))
        image.attributes[it.name()] = text->value();
    return image;
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    bad_exr(path, e.what());
  }
}

ImageF read_exr_rgb(const fs::path& path) {
  const ExrImage exr = read_exr(path);
  const auto channel = [&](const char* name) {
    const auto it = std::find(exr.channels.begin(), exr.channels.end(), name);
    return it == exr.channels.end() ? -1 : int(it - exr.channels.begin());
  };
  int source[3] = {channel("R"), channel("G"), channel("B")};
  if (source[0] < 0 || source[1] < 0 || source[2] < 0) {
    const int grey = channel("Y") >= 0 ? channel("Y") : channel("R");
    if (grey < 0) bad_exr(path, "it has no channels R, G, B (or Y)");
    source[0] = source[1] = source[2] = grey;
  }
  ImageF rgb(exr.pixels.width(), exr.pixels.height(), 3);
  for (int y = 0; y < rgb.height(); ++y)
    for (int x = 0; x < rgb.width(); ++x)
      for (int c = 0; c < 3; ++c) rgb.at(x, y, c) = exr.pixels.at(x, y, source[c]);
  return rgb;
}

void write_exr(const fs::path& path, const ExrImage& image, ExrPrecision precision) {
  VITRINE_CHECK(image.channels.size() == size_t(image.pixels.channels()), "{} names for {} channels", image.channels.size(),
                image.pixels.channels());
  const int width = image.pixels.width(), height = image.pixels.height();
  const size_t channels = image.channels.size();
  std::vector<half> halves;
  if (precision == ExrPrecision::Half) {
    constexpr float kHalfMax = 65504.f;
    halves.resize(image.pixels.data().size());
    for (size_t i = 0; i < halves.size(); ++i) halves[i] = half(std::clamp(image.pixels.data()[i], -kHalfMax, kHalfMax));
  }
  write_file_through(path, [&](const fs::path& temporary) {
    try {
      Imf::Header header(width, height);
      header.compression() = Imf::ZIP_COMPRESSION;
      const Imf::PixelType type = precision == ExrPrecision::Half ? Imf::HALF : Imf::FLOAT;
      for (const std::string& name : image.channels) header.channels().insert(name, Imf::Channel(type));
      for (const auto& [name, text] : image.attributes) header.insert(name, Imf::StringAttribute(text));
      Imf::OutputFile file(temporary.c_str(), header, 1);
      Imf::FrameBuffer buffer;
      const size_t item = precision == ExrPrecision::Half ? sizeof(half) : sizeof(float);
      char* base = precision == ExrPrecision::Half ? reinterpret_cast<char*>(halves.data())
                                                   : reinterpret_cast<char*>(const_cast<float*>(image.pixels.data().data()));
      for (size_t c = 0; c < channels; ++c)
        buffer.insert(image.channels[c], Imf::Slice(type, base + item * c, item * channels, item * channels * size_t(width)));
      file.setFrameBuffer(buffer);
      file.writePixels(height);
    } catch (const std::exception& e) {
      throw Error(
          ErrorKind::Resource, "cannot write an EXR image",
          {.where = path.string(), .why = e.what(), .hint = "check free disk space and permissions", .code = "WRITE_FAILED"});
    }
  });
}

void write_exr_rgb(const fs::path& path, const ImageF& rgb, ExrPrecision precision,
                   const std::map<std::string, std::string>& attributes) {
  write_exr(path, {.pixels = rgb, .channels = {"R", "G", "B"}, .attributes = attributes}, precision);
}

}  // namespace vitrine
