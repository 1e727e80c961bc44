#include "core/intake/photos/panorama.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/sphere_picture.h"

namespace vitrine {
namespace {

using test::sphere_panorama, test::sphere_photo;

std::string packet(const std::string& attributes, const std::string& prefix = "GPano") {
  return "\xff\xd8 anything <x:xmpmeta><rdf:Description xmlns:" + prefix + "=\"http://ns.google.com/photos/1.0/panorama/\" " +
         attributes + "/></x:xmpmeta> picture";
}

PanoramaKind kind_of(const ImageF& picture) {
  return panorama_of({}, picture.width(), picture.height(), [&] { return picture; }).kind;
}
PanoramaKind kind_of(const std::string& bytes, int width, int height) {
  return panorama_of(parse_gpano(bytes), width, height, [] { return ImageF(); }).kind;
}

// Part of a picture.
ImageF cut(const ImageF& image, int left, int top, int width, int height) {
  ImageF out(width, height, image.channels());
  for (int y = 0; y < height; ++y) std::copy_n(image.pixel(left, top + y), size_t(width * image.channels()), out.pixel(0, y));
  return out;
}

// Equidistant, 180 degrees, black outside the circle.
ImageF fisheye_photo(int side, uint64_t seed) {
  const auto radius = [&](double x, double y) { return std::hypot(x - 0.5 * side, y - 0.5 * side) / (0.5 * side); };
  ImageF photo = test::picture_of(
      side, side,
      [&](double x, double y) {
        const double r = std::max(radius(x, y), 1e-9), angle = 0.5 * std::numbers::pi * r;
        return Vec3d{std::sin(angle) / r * (2 * x / side - 1), std::sin(angle) / r * (2 * y / side - 1), std::cos(angle)};
      },
      seed);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      if (radius(x + 0.5, y + 0.5) > 1) std::fill_n(photo.pixel(x, y), 3, 0.01f);
  return photo;
}

TEST(Panorama, FisheyePhotosAreNoStereoPairs) {
  for (const uint64_t seed : {1, 2, 3, 4}) EXPECT_EQ(kind_of(fisheye_photo(224, seed)), PanoramaKind::None) << seed;
}

TEST(Panorama, XmpIsReadAsAttributesAndElementsOfAnyPrefix) {
  const GPano a = parse_gpano(packet("GPano:ProjectionType=\"equirectangular\" GPano:FullPanoWidthPixels='8192'"));
  EXPECT_EQ(a.projection, "equirectangular");
  EXPECT_EQ(a.full_width, 8192);
  const GPano b = parse_gpano(packet("><p:ProjectionType>cylindrical</p:ProjectionType><p:FullPanoHeightPixels>77<", "p"));
  EXPECT_EQ(b.projection, "cylindrical");
  EXPECT_EQ(b.full_height, 77);
  EXPECT_EQ(parse_gpano("GPano:ProjectionType=\"equirectangular\" without a name space").projection, "");
  EXPECT_EQ(parse_gpano(packet("GPano:FullPanoWidthPixels=\"-5\"")).full_width, 0);
  EXPECT_EQ(parse_gpano(packet("GPano:ProjectionType=\"equirect")).projection, "");  // damaged
}

TEST(Panorama, XmpDecidesWithoutThePicture) {
  const std::string full = "GPano:ProjectionType=\"equirectangular\" ";
  EXPECT_EQ(kind_of(packet(full), 4096, 2048), PanoramaKind::Sphere);
  EXPECT_EQ(kind_of(packet(full + "GPano:FullPanoWidthPixels=\"4096\" GPano:CroppedAreaImageWidthPixels=\"4096\""), 4096, 2048),
            PanoramaKind::Sphere);
  EXPECT_EQ(kind_of(packet(full + "GPano:FullPanoWidthPixels=\"9000\" GPano:CroppedAreaImageWidthPixels=\"4096\""), 4096, 2048),
            PanoramaKind::Partial);
  EXPECT_EQ(kind_of(packet(full), 4096, 900), PanoramaKind::Partial);
  EXPECT_EQ(kind_of(packet("GPano:ProjectionType=\"cylindrical\""), 4096, 2048), PanoramaKind::Partial);
  EXPECT_EQ(kind_of(packet(full), 4096, 4096), PanoramaKind::Stereo);
}

TEST(Panorama, ContentDecidesWithoutXmp) {
  for (uint64_t seed : {1, 2, 3}) {
    const ImageF panorama = sphere_panorama(512, seed);
    EXPECT_EQ(kind_of(panorama), PanoramaKind::Sphere) << seed;
    ImageF pair(512, 512, 3);
    std::copy_n(panorama.data().begin(), panorama.data().size(), pair.data().begin());
    std::copy_n(panorama.data().begin(), panorama.data().size(), pair.pixel(0, 256));
    EXPECT_EQ(kind_of(pair), PanoramaKind::Stereo) << seed;
    // A plain ceiling: the other pole is evidence enough.
    ImageF ceiling = panorama;
    std::fill_n(ceiling.data().begin(), 60 * 512 * 3, 0.8f);
    EXPECT_EQ(kind_of(ceiling), PanoramaKind::Sphere) << seed;
  }
}

TEST(Panorama, PhotosOfTwoToOneStayPhotos) {
  for (uint64_t seed : {1, 2, 3}) {
    EXPECT_EQ(kind_of(sphere_photo({512, 256, 300, 300, 256, 128}, Mat3d::identity(), seed)), PanoramaKind::None) << seed;
    const ImageF panorama = sphere_panorama(768, seed);
    EXPECT_EQ(kind_of(cut(panorama, 0, 0, 512, 256)), PanoramaKind::None) << seed;          // a pole, but no seam
    EXPECT_EQ(kind_of(cut(panorama, 0, 100, 768, 384 - 200)), PanoramaKind::None) << seed;  // another size
    // The whole circle without its poles, stretched to 2:1: a seam, but no pole.
    EXPECT_EQ(kind_of(resized(cut(panorama, 0, 120, 768, 144), 512, 256)), PanoramaKind::None) << seed;
  }
  // Plain edges continue each other, and a sky that darkens upwards changes along no row: neither is evidence.
  ImageF studio(512, 256, 3), landscape = sphere_photo({512, 256, 300, 300, 256, 128});
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 512; ++x)
      for (int c = 0; c < 3; ++c) {
        const bool middle = x > 150 && x < 360 && y > 60;
        studio.at(x, y, c) = middle ? landscape.at(x, y, c) : 0.9f;
        landscape.at(x, y, c) = y < 100 ? 0.3f + 0.006f * float(y) : landscape.at(x, y, c);
      }
  EXPECT_EQ(kind_of(studio), PanoramaKind::None);
  EXPECT_EQ(kind_of(landscape), PanoramaKind::None);
  EXPECT_EQ(kind_of(ImageF(512, 256, 3)), PanoramaKind::None);
  EXPECT_EQ(kind_of(ImageF(2, 1, 3)), PanoramaKind::None);
}

}  // namespace
}  // namespace vitrine
