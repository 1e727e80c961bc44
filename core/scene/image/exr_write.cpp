#include <algorithm>
#include <exception>
#include <vector>

#include <half.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/scene/image/exr.h"

namespace vitrine {

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
