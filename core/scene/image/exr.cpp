#include "core/scene/image/exr.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <exception>
#include <fstream>
#include <map>
#include <string>
#include <utility>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPartType.h>
#include <ImfRgbaFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"

namespace vitrine {

namespace {

// Header checks before the OpenEXR library sees the file: it allocates sizes from the header without checking the file size,
// and reads some attribute types by content, so it loses its position if the stated size is wrong.

// Bytes that the library reads for this attribute type, regardless of the stated size.
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

// Channel names with 16 bytes each, terminated by an empty name.
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

// True if every attribute (name, type, size, bytes; terminated by an empty name) is inside the file and its size fits its type.
bool whole_exr_header(const fs::path& path) {
  constexpr size_t kLongestName = 256;
  std::ifstream in(path, std::ios::binary);
  const uint64_t size = fs::file_size(path);
  uint64_t at = 8;  // after magic number and version
  in.seekg(5);
  const bool several_parts = in.get() & 0x10;  // headers are terminated by an empty one
  in.seekg(static_cast<std::streamoff>(at));
  const auto word = [&] {
    std::string text;
    for (int c = in.get(); c > 0 && text.size() < kLongestName; c = in.get()) text += static_cast<char>(c);
    at += text.size() + 1;
    return text;
  };
  while (in) {
    if (word().empty() && (!several_parts || word().empty())) return true;
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
    if (!whole) return false;
    in.seekg(static_cast<std::streamoff>(at += bytes));
  }
  return true;
}

constexpr size_t kMaxChannels = 1024;
constexpr int kMaxSide = 1 << 20, kMaxTile = 1 << 12;
// Even an all-black file needs some bytes for this many values; a damaged header requests memory without them.
constexpr size_t kAlwaysFine = size_t(1) << 26, kValuesPerByte = 1024;

constexpr const char* kDamagedHint =
    "the file is damaged or not an EXR: restore it, or delete it and run the stage that wrote it again";
constexpr const char* kExportHint = "export it again from the program that wrote it";

[[noreturn]] void bad_exr(const fs::path& path, std::string why, const char* hint = kDamagedHint) {
  throw Error(ErrorKind::Input, "cannot read an EXR image",
              {.where = path.string(), .why = std::move(why), .hint = hint, .code = "BAD_EXR"});
}

// Channel order R,G,B,A and X,Y,Z (files sort by name); applied within each layer.
int natural_rank(const std::string& channel) {
  const std::string base = exr_base_name(channel);
  for (const auto& [word, rank] : {std::pair{"G", 1}, {"B", 2}, {"A", 3}, {"Y", 1}, {"Z", 2}})
    if (base == word) return rank;
  return 0;
}

// Display window (the image) and data window (the stored pixels), which may be smaller or larger.
struct ExrWindow {
  Imath::Box2i data;
  int width = 0, height = 0;  // of the display window
  int left = 0, top = 0;      // origin of the display window, in file coordinates
  int data_width = 0, data_height = 0;
  bool whole = true;  // both windows are equal
};

class ExrFile {
 public:
  // Throws library exceptions; `max_pixels` limits both windows.
  ExrFile(const fs::path& path, size_t max_pixels) : path_(path), file_(checked(path), 1), max_pixels_(max_pixels) {}

  std::vector<ExrPart> parts() const {
    std::vector<ExrPart> parts(size_t(file_.parts()));
    size_t channels = 0;
    for (int p = 0; p < file_.parts(); ++p) {
      const Imf::Header& header = file_.header(p);
      ExrPart& part = parts[size_t(p)];
      if (header.hasName()) part.name = header.name();
      if (header.hasView()) part.view = header.view();
      part.deep = header.hasType() && Imf::isDeepData(header.type());
      for (auto it = header.channels().begin(); it != header.channels().end(); ++it) part.channels.emplace_back(it.name());
      channels += part.channels.size();
    }
    if (channels == 0 || channels > kMaxChannels) bad_exr(path_, fmt::format("it has {} channels", channels));
    return parts;
  }
  std::vector<std::string> views() const {
    return Imf::hasMultiView(file_.header(0)) ? Imf::multiView(file_.header(0)) : std::vector<std::string>();
  }
  const Imf::Header& header(size_t part) const { return file_.header(int(part)); }

  // Throws for sizes that a file of this length cannot hold.
  ExrWindow window(size_t part, size_t channels) const {
    const Imath::Box2i data = header(part).dataWindow(), display = header(part).displayWindow();
    const auto side = [](int low, int high) { return int64_t(high) - low + 1; };
    const int64_t w = side(display.min.x, display.max.x), h = side(display.min.y, display.max.y);
    const int64_t data_w = side(data.min.x, data.max.x), data_h = side(data.min.y, data.max.y);
    for (const auto& [width, height] : {std::pair{w, h}, {data_w, data_h}})
      if (width <= 0 || height <= 0 || width > kMaxSide || height > kMaxSide || size_t(width) * size_t(height) > max_pixels_)
        bad_exr(path_, fmt::format("its size of {} x {} pixels is not plausible", width, height));
    const size_t values = std::max(size_t(w) * size_t(h), size_t(data_w) * size_t(data_h)) * channels,
                 bytes = fs::file_size(path_);
    if (values > kAlwaysFine && values / kValuesPerByte > bytes)
      bad_exr(path_, fmt::format("{} bytes cannot hold {} x {} pixels of {} channels", bytes, w, h, channels));
    if (!data.intersects(display))
      bad_exr(path_, "its data window lies outside of its display window: nothing of the picture is stored", kExportHint);
    return {data, int(w), int(h), display.min.x, display.min.y, int(data_w), int(data_h), data == display};
  }

  ImageF read(size_t part, const std::vector<std::string>& channels) {
    const ExrWindow window = this->window(part, channels.size());
    for (const std::string& name : channels) {
      const Imf::Channel* const channel = header(part).channels().findChannel(name);
      if (channel->xSampling != 1 || channel->ySampling != 1)
        bad_exr(path_, fmt::format("its channel {} has fewer pixels than the picture", name), kExportHint);
    }
    const int count = static_cast<int>(channels.size());
    ImageF stored(window.data_width, window.data_height, count);
    Imf::FrameBuffer buffer;
    const size_t x_stride = sizeof(float) * channels.size(), y_stride = x_stride * size_t(window.data_width);
    char* const origin = reinterpret_cast<char*>(stored.data().data()) - ptrdiff_t(window.data.min.x) * ptrdiff_t(x_stride) -
                         ptrdiff_t(window.data.min.y) * ptrdiff_t(y_stride);
    for (size_t c = 0; c < channels.size(); ++c)
      buffer.insert(channels[c], Imf::Slice(Imf::FLOAT, origin + sizeof(float) * c, x_stride, y_stride));
    Imf::InputPart input(file_, int(part));
    input.setFrameBuffer(buffer);
    input.readPixels(window.data.min.y, window.data.max.y);
    return window.whole ? std::move(stored) : displayed(stored, window);
  }

  // Y, RY, BY, possibly with subsampled chroma: the library converts them, in half precision.
  ImageF read_luminance_chroma() {
    const ExrWindow window = this->window(0, 4);
    std::vector<Imf::Rgba> row(size_t(window.data_width));
    Imf::RgbaInputFile input(path_.c_str(), 1);
    ImageF stored(window.data_width, window.data_height, 3);
    for (int y = 0; y < window.data_height; ++y) {
      const int line = window.data.min.y + y;
      input.setFrameBuffer(row.data() - ptrdiff_t(window.data.min.x) - ptrdiff_t(line) * window.data_width, 1,
                           size_t(window.data_width));
      input.readPixels(line);
      for (int x = 0; x < window.data_width; ++x) {
        const Imf::Rgba& p = row[size_t(x)];
        stored.at(x, y, 0) = p.r, stored.at(x, y, 1) = p.g, stored.at(x, y, 2) = p.b;
      }
    }
    return window.whole ? std::move(stored) : displayed(stored, window);
  }

  static ImageF displayed(const ImageF& stored, const ExrWindow& w) {
    ImageF out(w.width, w.height, stored.channels());
    const int first = std::max(w.data.min.x, w.left), last = std::min(w.data.max.x, w.left + w.width - 1);
    for (int y = std::max(w.data.min.y, w.top); y <= std::min(w.data.max.y, w.top + w.height - 1); ++y)
      std::copy_n(stored.pixel(first - w.data.min.x, y - w.data.min.y), size_t(last - first + 1) * size_t(stored.channels()),
                  out.pixel(first - w.left, y - w.top));
    return out;
  }

 private:
  static const char* checked(const fs::path& path) {
    if (!whole_exr_header(path)) bad_exr(path, "its header is damaged, or the file is cut short");
    // The library checks this before it allocates its own tables.
    Imf::Header::setMaxImageSize(kMaxSide, kMaxSide);
    Imf::Header::setMaxTileSize(kMaxTile, kMaxTile);
    return path.c_str();
  }

  fs::path path_;
  Imf::MultiPartInputFile file_;
  size_t max_pixels_;
};

template <class Read>
auto reading(const fs::path& path, Read&& read) {
  if (!fs::is_regular_file(path)) bad_exr(path, "there is no such file");
  try {
    return read();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    bad_exr(path, e.what());
  }
}

void note_windows(const ExrWindow& w, const Imf::Header& header, std::vector<std::string>& notes) {
  const Imath::Box2i d = w.data;
  const bool cropped = d.min.x < w.left || d.min.y < w.top || d.max.x >= w.left + w.width || d.max.y >= w.top + w.height;
  const int64_t across = std::min<int64_t>(d.max.x, int64_t(w.left) + w.width - 1) - std::max(d.min.x, w.left) + 1;
  const int64_t down = std::min<int64_t>(d.max.y, int64_t(w.top) + w.height - 1) - std::max(d.min.y, w.top) + 1;
  const double stored = double(across) * double(down) / (double(w.width) * double(w.height));
  if (cropped) notes.push_back("an EXR that stores more than its display window: the display window is read");
  if (stored < 1) notes.push_back(fmt::format("an EXR that stores {:.1f} % of its display window: the rest is 0", 100 * stored));
  if (const float aspect = header.pixelAspectRatio(); aspect != 1)
    notes.push_back(fmt::format("an EXR whose pixels are not square (aspect ratio {:g}): they are taken as square", aspect));
}

// Channels of the main layer. Throws if there are none, or none that can be read.
ExrColors picture_of(const ExrFile& file, const fs::path& path, std::vector<std::string>& notes) {
  const std::vector<ExrPart> parts = file.parts();
  ExrColors colors = exr_colors(parts, file.views());
  if (!colors.refusal.empty()) bad_exr(path, colors.refusal, kExportHint);
  notes = colors.notes;
  for (const std::string& name : colors.channels)
    if (file.header(colors.part).channels().findChannel(name)->type == Imf::UINT)
      bad_exr(path, fmt::format("its channel {} holds whole numbers, with unknown black and white levels", name),
              "export it in half or float precision");
  if (colors.luminance_chroma && (parts.size() > 1 || !exr_layer_name(colors.channels[0]).empty()))
    bad_exr(path, "its colours are luminance and chroma (Y, RY, BY) in a layer or part of several", "export it as R, G, B");
  note_windows(file.window(colors.part, 4), file.header(colors.part), notes);
  return colors;
}

}  // namespace

ExrImage read_exr(const fs::path& path, size_t max_pixels) {
  return reading(path, [&] {
    ExrFile file(path, max_pixels);
    const std::vector<ExrPart> parts = file.parts();
    const ExrColors colors = exr_colors(parts, file.views());
    const size_t part = colors.refusal.empty() ? colors.part : 0;
    if (parts[part].deep) bad_exr(path, "it is a deep EXR (several samples per pixel)", "export it flattened");
    ExrImage image;
    image.channels = parts[part].channels;
    std::stable_sort(image.channels.begin(), image.channels.end(), [](const std::string& a, const std::string& b) {
      return std::pair(exr_layer_name(a), natural_rank(a)) < std::pair(exr_layer_name(b), natural_rank(b));
    });
    image.pixels = file.read(part, image.channels);
    const Imf::Header& header = file.header(part);
    for (auto it = header.begin(); it != header.end(); ++it)
      if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&it.attribute()))
        image.attributes[it.name()] = text->value();
    return image;
  });
}

ExrPicture read_exr_picture(const fs::path& path, bool with_alpha) {
  return reading(path, [&] {
    ExrFile file(path, kMaxExrPixels);
    ExrPicture picture;
    const ExrColors colors = picture_of(file, path, picture.notes);
    if (colors.luminance_chroma)
      picture.rgb = file.read_luminance_chroma();
    else
      picture.rgb = file.read(colors.part, colors.channels);
    if (picture.rgb.channels() == 1) {
      ImageF rgb(picture.rgb.width(), picture.rgb.height(), 3);
      for (size_t i = 0; i < rgb.pixel_count(); ++i)
        for (size_t c = 0; c < 3; ++c) rgb.data()[3 * i + c] = picture.rgb.data()[i];
      picture.rgb = std::move(rgb);
    }
    if (with_alpha && !colors.alpha.empty()) picture.alpha = file.read(colors.part, {colors.alpha});
    return picture;
  });
}

std::vector<std::string> exr_notes(const fs::path& path) {
  return reading(path, [&] {
    ExrFile file(path, kMaxExrPixels);
    std::vector<std::string> notes;
    picture_of(file, path, notes);
    return notes;
  });
}

ImageF read_exr_rgb(const fs::path& path) { return read_exr_picture(path, false).rgb; }

}  // namespace vitrine
