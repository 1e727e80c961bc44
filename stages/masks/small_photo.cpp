#include "stages/masks/mask_source.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

constexpr size_t kMostEdgePhotos = 64;

}

std::vector<View> small_views(const MaskCapture& capture, int max_side) {
  std::vector<View> views = capture.set.views;
  for (View& view : views) view.intrinsics = view.intrinsics.limited_to(max_side);
  return views;
}

std::vector<SmallPhoto> small_photos(const MaskCapture& capture, int max_side) {
  const std::vector<View> views = small_views(capture, max_side);
  std::vector<SmallPhoto> photos(views.size());
  parallel_for(photos.size(), 1, [&](size_t v) {
    if (interrupt_signal() != 0) return;
    photos[v].view = views[v];
    photos[v].view.gain = {1, 1, 1};
    const Intrinsics& k = views[v].intrinsics;
    ImageF linear = resized(read_exr_rgb(linear_image_path(capture.sfm_folder, views[v])), k.width, k.height);
    for (size_t i = 0; i < linear.data().size(); ++i) linear.data()[i] /= float(views[v].gain[i % 3]);
    const ImageF srgb = srgb_from_linear_image(linear);
    const size_t pixels = srgb.pixel_count();
    photos[v].srgb.resize(3 * pixels);
    for (size_t i = 0; i < pixels; ++i)
      for (size_t c = 0; c < 3; ++c) photos[v].srgb[c * pixels + i] = std::min(srgb.data()[3 * i + c], 1.f);
  });
  throw_if_interrupted();
  return photos;
}

EdgePhoto edge_photo(const SmallPhoto& photo) {
  EdgePhoto edges{photo.view, ImageF(photo.view.intrinsics.width, photo.view.intrinsics.height, 3)};
  const size_t pixels = edges.srgb.pixel_count();
  for (size_t i = 0; i < 3 * pixels; ++i) edges.srgb.data()[i] = photo.srgb[i % 3 * pixels + i / 3];
  return edges;
}

std::vector<EdgePhoto> edge_photos(std::span<const SmallPhoto> photos) {
  std::vector<EdgePhoto> out;
  for (const SmallPhoto& small : photos) out.push_back(edge_photo(small));
  return out;
}

std::vector<EdgePhoto> edge_photos(const MaskCapture& capture, int max_side) {
  MaskCapture some;
  some.sfm_folder = capture.sfm_folder;
  const size_t all = capture.set.views.size(), stride = (all + kMostEdgePhotos - 1) / kMostEdgePhotos;
  for (size_t v = 0; v < all; v += stride) some.set.views.push_back(capture.set.views[v]);
  return edge_photos(small_photos(some, max_side));
}

void blur_planes(std::vector<float>& planes, int width, int height, float sigma) {
  const int radius = int(3 * sigma + 0.5f);
  if (radius < 1) return;
  std::vector<float> kernel;
  for (int i = -radius; i <= radius; ++i) kernel.push_back(std::exp(-0.5f * float(i * i) / (sigma * sigma)));
  std::vector<float> across(planes.size());
  const auto pass = [&](const std::vector<float>& from, std::vector<float>& to, int step_x, int step_y) {
    const size_t pixels = size_t(width) * size_t(height);
    for (size_t plane = 0; plane < from.size() / pixels; ++plane)
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          float sum = 0, weights = 0;
          for (int i = -radius; i <= radius; ++i) {
            const int sx = x + i * step_x, sy = y + i * step_y;
            if (sx < 0 || sy < 0 || sx >= width || sy >= height) continue;
            sum += kernel[size_t(i + radius)] * from[plane * pixels + size_t(sy) * size_t(width) + size_t(sx)];
            weights += kernel[size_t(i + radius)];
          }
          to[plane * pixels + size_t(y) * size_t(width) + size_t(x)] = sum / weights;
        }
  };
  pass(planes, across, 1, 0);
  pass(across, planes, 0, 1);
}

}  // namespace vitrine
