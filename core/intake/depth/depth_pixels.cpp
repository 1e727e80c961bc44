#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/intake/depth/depth_files.h"
#include "core/scene/image/codecs.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/picture_file.h"
#include "core/scene/image/tiff_pages.h"

namespace vitrine {

namespace {

constexpr float kBeyond = 65504.f;     // metres: the largest half; renderers write it, or 1e10, where there is no surface
constexpr double kMostNegative = 0.5;  // share of the known pixels

[[noreturn]] void refuse(const fs::path& file, std::string why) {
  throw Error(ErrorKind::Input, "this is not a depth map",
              {.where = file.string(),
               .why = std::move(why),
               .hint = "PNG or TIFF of 16 bit in millimetres, or EXR or TIFF of floats in metres: one channel, 0 = unknown",
               .code = "NOT_A_DEPTH_MAP"});
}

// The one channel of a picture, or its first if all are equal.
template <class T>
ImageF one_channel(const fs::path& file, const Image<T>& image, size_t colours) {
  ImageF out(image.width(), image.height(), 1);
  const size_t channels = size_t(image.channels());
  for (size_t i = 0; i < image.pixel_count(); ++i) {
    const T* p = image.data().data() + channels * i;
    for (size_t c = 1; c < colours; ++c)
      if (p[c] != p[0]) refuse(file, "its channels differ: it is a picture with colours");
    out.data()[i] = static_cast<float>(p[0]);
  }
  return out;
}

// The channel that holds a depth: Z, "ViewLayer.Depth.Z", a single one, or equal colours.
ImageF exr_depth(const fs::path& file) {
  const ExrImage exr = read_exr(file);
  size_t found = exr.channels.size();
  for (size_t c = 0; c < exr.channels.size() && found == exr.channels.size(); ++c) {
    const std::string base = lowered(exr_base_name(exr.channels[c])), layer = lowered(exr_layer_name(exr.channels[c]));
    const bool vector = exr.channels.size() >= 3 && base == "z" && std::ranges::count(exr.channels, "X") > 0;
    if ((base == "z" && !vector) || base == "depth" || (layer.ends_with("depth") && base == "v")) found = c;
  }
  if (found == exr.channels.size() && exr.channels.size() == 1) found = 0;
  if (found == exr.channels.size()) {
    const std::vector<std::string> colours{"R", "G", "B"};
    if (exr.channels.size() < 3 || !std::equal(colours.begin(), colours.end(), exr.channels.begin()))
      refuse(file, fmt::format("no channel is called Z: {}", exr_channel_list(exr.channels)));
    return one_channel(file, exr.pixels, 3);
  }
  ImageF out(exr.pixels.width(), exr.pixels.height(), 1);
  for (size_t i = 0; i < out.pixel_count(); ++i) out.data()[i] = exr.pixels.data()[i * exr.channels.size() + found];
  return out;
}

AnyImage decoded(const fs::path& file, const std::string& bytes) {
  const PictureFile picture = examine_picture(bytes, file.extension().string());
  if (!picture.refusal.empty()) refuse(file, picture.refusal);
  AnyImage any;
  std::string why = "it is neither PNG, TIFF nor EXR";
  if (picture.probe.format == PhotoFormat::Png) {
    Image8 narrow;
    Image16 wide;
    why = codecs().png(bytes, narrow, wide);
    if (wide.empty())
      any = std::move(narrow);
    else
      any = std::move(wide);
  } else if (picture.probe.format == PhotoFormat::Tiff) {
    why = read_tiff(bytes, tiff_pages(bytes), any);
  }
  if (!why.empty()) refuse(file, why);
  return any;
}

ImageF sampled_depth(const fs::path& file, const std::string& bytes, double unit) {
  const AnyImage any = decoded(file, bytes);
  if (std::holds_alternative<Image8>(any)) refuse(file, "it has 8 bits: 256 levels are a picture of a depth, no measurement");
  if (const auto* floats = std::get_if<ImageF>(&any)) return one_channel(file, *floats, floats->channels() >= 3 ? 3 : 1);
  const Image16& steps = std::get<Image16>(any);
  ImageF depth = one_channel(file, steps, steps.channels() >= 3 ? 3 : 1);
  for (float& z : depth.data()) z = z >= 65535.f ? 0.f : static_cast<float>(z * unit);
  return depth;
}

}  // namespace

ImageF read_depth(const fs::path& file, double unit) {
  const std::string bytes = read_file(file);
  const bool exr = examine_picture(bytes, file.extension().string()).probe.format == PhotoFormat::Exr;
  ImageF depth = exr ? exr_depth(file) : sampled_depth(file, bytes, unit);
  size_t known = 0, negative = 0;
  float nearest = kBeyond, farthest = 0;
  for (float& z : depth.data()) {
    negative += z < 0 && std::isfinite(z);
    if (!(z > 0 && z < kBeyond)) {
      z = 0;
      continue;
    }
    ++known;
    nearest = std::min(nearest, z), farthest = std::max(farthest, z);
  }
  if (double(negative) > kMostNegative * double(known + negative))
    refuse(file, "its depths are negative: along the axis of the camera they grow away from it");
  if (known > 1 && nearest == farthest) refuse(file, fmt::format("all of its {} known pixels have one depth", known));
  return depth;
}

bool same_depth_shape(int width, int height, double photo_width, double photo_height) {
  constexpr double kSlack = 0.01;
  return std::abs(double(width) * photo_height / (double(height) * photo_width) - 1) < kSlack;
}

void throw_wrong_depth_size(const fs::path& file, const ImageF& depth, int photo_width, int photo_height) {
  const bool turned = same_depth_shape(depth.width(), depth.height(), photo_height, photo_width);
  throw Error(ErrorKind::Input, "a depth map does not have its photo's shape",
              {.where = file.string(),
               .why = fmt::format("{} x {} pixels; the photo{} has {} x {}", depth.width(), depth.height(),
                                  turned ? ", turned upright by EXIF," : "", photo_width, photo_height),
               .hint = turned ? "turn the depth maps as any viewer shows the photos" : "give the maps of these photos, uncropped",
               .code = "DEPTH_SIZE"});
}

}  // namespace vitrine
