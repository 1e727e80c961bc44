#include "core/network/network_input.h"

#include <algorithm>
#include <cmath>

#include "core/config/describe.h"

namespace vitrine {

std::pair<int, int> NetworkInput::size_of(int photo_width, int photo_height) const {
  if (width > 0) return {width, height};
  const double scale = double(max_side) / std::max(photo_width, photo_height);
  const auto rounded = [&](int side) { return std::max(1, int(std::lround(scale * side / multiple))) * multiple; };
  return {rounded(photo_width), rounded(photo_height)};
}

std::string NetworkInput::problem(const std::string& prefix) const {
  if (mean.size() != 3 || deviation.size() != 3) return prefix + "mean and " + prefix + "deviation take three numbers each";
  for (double d : deviation)
    if (!(d > 0)) return prefix + "deviation must be positive";
  if ((width == 0) != (height == 0)) return prefix + "width and " + prefix + "height are given together, or neither";
  return {};
}

void describe_input(Describer& d, NetworkInput& c) {
  d.option("width", c.width, "Width of the network's input; 0 = from max_side.").range(0, 8192);
  d.option("height", c.height, "Height of the network's input; 0 = from max_side.").range(0, 8192);
  d.option("max_side", c.max_side, "Longest side of its input, when its size is free.").range(16, 8192);
  d.option("multiple", c.multiple, "Both sides of its input are a multiple of this, when its size is free.").range(1, 1024);
  d.option("layout", c.layout, "Order of its input: planes of channels, or channels of pixels.").choices({"nchw", "nhwc"});
  d.option("channels", c.channels, "Order of the channels.").choices({"rgb", "bgr"});
  d.option("mean", c.mean, "Subtracted from the photo, sRGB in [0,1], per channel.");
  d.option("deviation", c.deviation, "What that is divided by, per channel.");
  d.option("sha256", c.sha256, "SHA-256 that the network's file must have; empty = any.");
}

}  // namespace vitrine
