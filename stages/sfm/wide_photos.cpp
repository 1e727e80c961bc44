#include "stages/sfm/wide_photos.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/file.h"
#include "core/foundation/base/log.h"
#include "core/scene/camera/colmap_lens.h"
#include "core/scene/camera/lens_circle.h"
#include "core/scene/image/ldr.h"
#include "stages/stage.h"

namespace vitrine {

namespace {

constexpr size_t kCirclePhotos = 16;  // of a camera, evenly spread: enough that each sector is bright in one

double circle_of(const ColmapCamera& camera, const ColmapModel& model, const std::map<std::string, const Photo*>& photo_of,
                 const fs::path& folder) {
  if (!is_fisheye(camera.model_id)) return 0;
  std::vector<fs::path> pictures;
  for (const ColmapImage& image : model.images)
    if (image.camera_id == camera.id) pictures.push_back(ingested_ldr_path(folder, *photo_of.at(image.name)));
  const Intrinsics k = pinhole_part(camera);
  return lens_circle_px(pictures, k.width, k.height, {k.cx, k.cy});
}

// The view in which an observation lies, nearest to its axis.
std::optional<size_t> view_of(const Vec2d& pixel, std::span<const Undistortion> views) {
  std::optional<size_t> best;
  double least = 0;
  for (size_t v = 0; v < views.size(); ++v) {
    const std::optional<Vec2d> at = undistorted(pixel, views[v]);
    const Intrinsics& k = views[v].target;
    if (!at || !(at->x >= 0 && at->y >= 0 && at->x < k.width && at->y < k.height)) continue;
    const Vec3d ray = k.ray(at->x, at->y);
    const double off = std::hypot(ray.x, ray.y);
    if (!best || off < least) best = v, least = off;
  }
  return best;
}

struct Lens {
  std::vector<Undistortion> views;
  std::vector<uint32_t> cameras;  // [view] id in the new model
};

std::vector<ColmapImage> pictures_of(const ColmapImage& image, const Lens& lens, const std::vector<std::string>& names) {
  std::vector<ColmapImage> pictures;
  for (size_t v = 0; v < lens.views.size(); ++v) {
    ColmapImage& picture = pictures.emplace_back(image);
    picture.camera_id = lens.cameras[v];
    picture.name = names[v];
    if (lens.views.size() > 1) picture.points.clear();
  }
  if (lens.views.size() == 1) return pictures;
  for (const ColmapPoint2D& p : image.points)
    if (const std::optional<size_t> v = p.point3d_id == kNoPoint3D ? std::nullopt : view_of({p.x, p.y}, lens.views))
      pictures[*v].points.push_back(p);
  return pictures;
}

// Image ids in the order of names, and tracks that follow the observations of the images.
void renumber(ColmapModel& model) {
  std::ranges::sort(model.images, {}, &ColmapImage::name);
  std::map<uint64_t, std::vector<ColmapTrackElement>> tracks;
  for (size_t i = 0; i < model.images.size(); ++i) {
    ColmapImage& image = model.images[i];
    image.id = uint32_t(i) + 1;
    for (size_t p = 0; p < image.points.size(); ++p)
      if (image.points[p].point3d_id != kNoPoint3D) tracks[image.points[p].point3d_id].push_back({image.id, uint32_t(p)});
  }
  for (ColmapPoint3D& point : model.points) point.track = tracks[point.id];
}

std::vector<std::string> folders_of(const std::vector<Photo>& photos) {
  std::vector<std::string> stems;
  for (const Photo& p : photos) stems.push_back(p.stem);
  return view_folders(stems);
}

}  // namespace

double lens_circle_px(std::span<const fs::path> pictures, int width, int height, const Vec2d& centre) {
  LensCircle circle(width, height, centre);
  const size_t count = std::min(pictures.size(), kCirclePhotos);
  for (size_t i = 0; i < count; ++i) circle.add(read_srgb8(pictures[i * pictures.size() / count]));
  return circle.radius();
}

const Photo& CutPhotos::photo_of(const Photo& picture) const {
  const auto found = ingested.find(picture.name);
  return found == ingested.end() ? picture : found->second;
}

CutPhotos cut_photos(const ColmapModel& model, const std::vector<Photo>& photos, const fs::path& folder) {
  std::map<std::string, const Photo*> photo_of;
  for (const Photo& p : photos) photo_of[p.name] = &p;
  CutPhotos out;
  std::map<uint32_t, Lens> lenses;
  for (const ColmapCamera& camera : model.cameras) {
    const double circle_px = circle_of(camera, model, photo_of, folder);
    Lens& lens = lenses[camera.id];
    lens.views = lens_views(camera, circle_px);
    if (lens.views.size() > 1) out.fields_deg.push_back(widest_field_deg(camera, circle_px));
  }
  if (out.fields_deg.empty()) {
    out.model = model, out.photos = photos;
    for (const ColmapCamera& camera : model.cameras) out.undistortions.push_back(std::move(lenses.at(camera.id).views[0]));
    return out;
  }
  for (const ColmapCamera& camera : model.cameras)
    for (Undistortion& u : lenses.at(camera.id).views) {
      const auto id = uint32_t(out.model.cameras.size()) + 1;
      u.source.id = id;
      out.model.cameras.push_back(u.source);
      out.undistortions.push_back(u);
      lenses.at(camera.id).cameras.push_back(id);
    }
  std::map<std::string, const ColmapImage*> image_of;
  for (const ColmapImage& image : model.images) image_of[image.name] = &image;
  const std::vector<std::string> folders = folders_of(photos);
  for (size_t i = 0; i < photos.size(); ++i) {
    const Photo& photo = photos[i];
    const auto found = image_of.find(photo.name);
    const Lens* lens = found == image_of.end() ? nullptr : &lenses.at(found->second->camera_id);
    std::vector<std::string> names{photo.name};
    if (lens == nullptr || lens->views.size() == 1) {
      out.photos.push_back(photo);
    } else {
      ++out.cut;
      names.clear();
      for (size_t v = 0; v < lens->views.size(); ++v) {
        const Undistortion& u = lens->views[v];
        Photo& view = out.photos.emplace_back(photo);
        view.name = names.emplace_back(view_name(folders[i], photo.name, v));
        view.stem = fs::path(view.name).replace_extension().generic_string();
        view.width = u.target.width, view.height = u.target.height;
        view.focal_px = u.target.fx;
        view.rig = PhotoRig{photo.name, quaternion(*u.rotation)};
        out.ingested.emplace(view.name, photo);
      }
    }
    if (lens == nullptr) continue;
    for (ColmapImage& picture : pictures_of(*found->second, *lens, names)) out.model.images.push_back(std::move(picture));
  }
  out.model.points = model.points;
  std::ranges::sort(out.photos, {}, &Photo::name);
  renumber(out.model);
  check_colmap_model(out.model, "views of wide photos");
  return out;
}

void report_cut_photos(const CutPhotos& cut, StageContext& context) {
  if (cut.cut == 0) return;
  context.metric("wide_photos", double(cut.cut));
  log_info("sfm: {} photos of fisheye lenses of {:.0f} degrees are cut into {} pinhole views that share the pose of their photo",
           cut.cut, std::ranges::max(cut.fields_deg), cut.ingested.size());
}

}  // namespace vitrine
