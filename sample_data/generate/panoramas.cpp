#include "sample_data/generate/panoramas.h"

#include <cmath>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/scene/camera/panorama_views.h"
#include "core/scene/image/ldr.h"
#include "sample_data/generate/capture.h"

namespace vitrine::generate {

CameraKind camera_kind(const std::string& word) {
  if (word.empty() || word == "pinhole") return CameraKind::Pinhole;
  if (word == "equirect") return CameraKind::Equirect;
  if (word == "fisheye") return CameraKind::Fisheye;
  throw Error(ErrorKind::Usage, "--camera takes pinhole, equirect or fisheye", {.where = word, .code = "USAGE"});
}

void replace_by_panoramas(Scene& scene, int width) {
  const std::vector<View> photos = std::move(scene.views);
  scene.views.clear();
  scene.sensor.extension = ".jpg";  // carries the XMP
  if (width <= 0 && !photos.empty())
    width = 2 * static_cast<int>(std::lround(std::sqrt(0.5 * static_cast<double>(photos[0].intrinsics.pixel_count()))));
  scene.panorama_width = width;
  const Intrinsics intrinsics = panorama_view_intrinsics(width, 0);
  for (const View& photo : photos) {
    const Vec3d eye = photo.centre_in_world();
    const Vec3d forward = transposed_times(photo.cam_from_world.rotation, Vec3d{0, 0, 1});
    const Rigid level = looking_at(eye, eye + Vec3d{forward.x, forward.y, 0}, {0, 0, 1});
    scene.panoramas.push_back({.name = photo.stem() + scene.sensor.extension, .cam_from_world = level, .gain = photo.gain});
    for (int v = 0; v < kPanoramaViews; ++v)
      scene.views.push_back({.name = fmt::format("{}/view_{:02}{}", photo.stem(), v, scene.sensor.extension),
                             .intrinsics = intrinsics,
                             .cam_from_world = Rigid{panorama_view_rotation(v), {}} * level,
                             .gain = photo.gain});
  }
}

ImageF rendered_panorama(const Integrator& integrator, const IrradianceCache* cache, const Rigid& cam_from_world, int width,
                         int samples, uint64_t key) {
  const int height = width / 2;
  const Rigid world_from_cam = inverse(cam_from_world);
  return rendered(integrator, cache, width, height, samples, key, [&](double x, double y) {
    return CameraRay{cast<float>(world_from_cam.translation),
                     cast<float>(world_from_cam.rotation * equirect_direction(x, y, width, height))};
  });
}

void write_panorama(const std::filesystem::path& path, const Image8& picture, int jpeg_quality) {
  write_ldr(path, picture, jpeg_quality);
  std::string xmp = "http://ns.adobe.com/xap/1.0/";
  xmp.push_back('\0');
  xmp +=
      "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">"
      "<rdf:Description xmlns:GPano=\"http://ns.google.com/photos/1.0/panorama/\" "
      "GPano:ProjectionType=\"equirectangular\"/></rdf:RDF></x:xmpmeta>";
  const std::string jpeg = read_file(path);
  const size_t length = xmp.size() + 2;  // of the segment APP1
  constexpr size_t kStartOfImage = 2;
  std::string out = jpeg.substr(0, kStartOfImage);
  out += "\xff\xe1";
  out.push_back(static_cast<char>(length >> 8));
  out.push_back(static_cast<char>(length & 0xff));
  out += xmp;
  out.append(jpeg, kStartOfImage);
  write_file(path, out);
}

}  // namespace vitrine::generate
