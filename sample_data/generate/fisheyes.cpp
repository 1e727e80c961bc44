#include "sample_data/generate/fisheyes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/foundation/base/file.h"
#include "core/foundation/config/json_file.h"
#include "core/scene/camera/colmap_lens.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/camera/wide_views.h"
#include "sample_data/generate/capture.h"

namespace vitrine::generate {

ColmapCamera fisheye_camera(int width, int height) {
  const double focal = std::min(width, height) / std::numbers::pi;
  return {.id = 1,
          .model_id = colmap_camera_type("OPENCV_FISHEYE")->id,
          .width = uint64_t(width),
          .height = uint64_t(height),
          .params = {focal, focal, 0.5 * width, 0.5 * height, 0, 0, 0, 0}};
}

double fisheye_circle_px(const ColmapCamera& camera) { return 0.5 * double(std::min(camera.width, camera.height)); }

void replace_by_fisheyes(Scene& scene, int width, int height) {
  const std::vector<View> photos = std::move(scene.views);
  scene.views.clear();
  scene.fisheye = fisheye_camera(width, height);
  const std::vector<Undistortion> cut = lens_views(*scene.fisheye, fisheye_circle_px(*scene.fisheye));
  for (const View& photo : photos) {
    scene.panoramas.push_back({.name = photo.name, .cam_from_world = photo.cam_from_world, .gain = photo.gain});
    for (size_t v = 0; v < cut.size(); ++v)
      scene.views.push_back({.name = view_name(photo.stem(), photo.name, v),
                             .intrinsics = cut[v].target,
                             .cam_from_world = Rigid{*cut[v].rotation, {}} * photo.cam_from_world,
                             .gain = photo.gain});
  }
}

ImageF rendered_fisheye(const Integrator& integrator, const IrradianceCache* cache, const Rigid& cam_from_world,
                        const ColmapCamera& camera, int samples, uint64_t key) {
  const Rigid world_from_cam = inverse(cam_from_world);
  const int width = int(camera.width), height = int(camera.height);
  ImageF picture = rendered(integrator, cache, width, height, samples, key, [&](double x, double y) {
    const Vec3d ray = ray_of_pixel(camera, {x, y}).value_or(Vec3d{0, 0, 1});
    return CameraRay{cast<float>(world_from_cam.translation), cast<float>(world_from_cam.rotation * normalized(ray))};
  });
  const Intrinsics k = pinhole_part(camera);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (std::hypot(x + 0.5 - k.cx, y + 0.5 - k.cy) > fisheye_circle_px(camera)) std::fill_n(picture.pixel(x, y), 3, 0.f);
  return picture;
}

void write_fisheye_poses(const std::filesystem::path& path, const Scene& scene) {
  std::vector<View> photos;
  for (const Panorama& p : scene.panoramas)
    photos.push_back(
        {.name = p.name, .intrinsics = pinhole_part(*scene.fisheye), .cam_from_world = p.cam_from_world, .gain = p.gain});
  make_folders(path.parent_path());
  write_transforms_json(path, photos, "photos");
  nlohmann::json j = nlohmann::json::parse(read_file(path));
  j["camera_model"] = "OPENCV_FISHEYE";
  for (const char* k : {"k1", "k2", "k3", "k4"}) j[k] = 0.0;
  write_json_file(path, j);
}

}  // namespace vitrine::generate
