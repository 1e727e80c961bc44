#include "stages/mark/mark.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"
#include "core/intake/photos/linear_photo.h"

namespace vitrine {

namespace {

constexpr int kQuality = 82, kSmallQuality = 70;
constexpr int kSmallSide = 176;  // thumbnails in the list, pixels

std::string reason(const Error& e) { return e.detail().why.empty() ? e.message() : e.detail().why; }

// Reads header and size, or the reason of failure.
PagePhoto head_of(const PhotoFile& file, std::optional<PhotoHead>& head) {
  PagePhoto photo{.name = file.name};
  try {
    head = read_photo_head(file.path, file.balance);
    PhotoSize size = upright_size(*head);
    if (size.width == 0 || size.height == 0) {
      const ImageF whole = read_linear_photo(file.path, *head).linear;
      size = {whole.width(), whole.height()};
      if (head->exif.orientation >= 5) std::swap(size.width, size.height);
    }
    photo.width = size.width, photo.height = size.height;
    photo.digest = head->digest.hex();
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Input) throw;
    photo.failure = reason(e);
  }
  return photo;
}

void add_pictures(const PhotoFile& file, const PhotoHead& head, int side, PagePhoto& photo) {
  try {
    const Image8 picture = upright_photo(file.path, head, side);
    photo.jpeg = jpeg_bytes(picture, kQuality);
    const double s = std::min(1.0, double(kSmallSide) / std::max(picture.width(), picture.height()));
    const auto small = [&](int length) { return std::max(int(std::lround(length * s)), 1); };
    const ImageF linear = resized(linear_from_srgb_image(floats_of(picture)), small(picture.width()), small(picture.height()));
    photo.small = jpeg_bytes(srgb8_from_linear(linear), kSmallQuality);
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Input) throw;
    photo.failure = reason(e);
  }
}

}  // namespace

int side_of_page(const std::vector<std::pair<int, int>>& sizes, int side, double megapixels) {
  const auto pixels = [&](int longest) {
    double sum = 0;
    for (const auto& [width, height] : sizes) {
      const double s = std::min(1.0, double(longest) / std::max({width, height, 1}));
      sum += s * s * width * height;
    }
    return sum;
  };
  while (side > kLeastSide && pixels(side) > megapixels * 1e6) side -= std::min(16, side - kLeastSide);
  return side;
}

std::vector<PagePhoto> page_photos(const PhotoFolder& folder, int side, double megapixels,
                                   const std::function<void(size_t)>& progress) {
  const size_t n = folder.photos.size();
  std::vector<PagePhoto> photos(n);
  std::vector<std::optional<PhotoHead>> heads(n);
  parallel_for(n, 1, [&](size_t i) { photos[i] = head_of(folder.photos[i], heads[i]); });
  std::vector<std::pair<int, int>> sizes;
  for (const PagePhoto& p : photos)
    if (p.failure.empty()) sizes.emplace_back(p.width, p.height);
  const int longest = side_of_page(sizes, side, megapixels);
  size_t done = 0;
  std::mutex reporting;
  parallel_for(n, 1, [&](size_t i) {
    throw_if_interrupted();
    if (photos[i].failure.empty()) add_pictures(folder.photos[i], *heads[i], longest, photos[i]);
    const std::lock_guard lock(reporting);
    progress(++done);
  });
  return photos;
}

}  // namespace vitrine
