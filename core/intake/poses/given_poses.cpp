#include "core/intake/poses/given_poses.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <tuple>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/log.h"
#include "core/intake/poses/colmap_repair.h"
#include "core/intake/poses/named_poses.h"
#include "core/intake/poses/pose_files.h"
#include "core/scene/camera/colmap_lens.h"

namespace vitrine {

namespace {

constexpr double kTinySkew = 1e-3;  // of the focal length: a third of a pixel over 640

// "00006_P.txt" -> "00006": the part shared with the photo's file name.
std::string matrix_key(const fs::path& file) {
  std::string stem = file.stem().string();
  for (const char* suffix : {"_P", "_p", ".P", "_proj"})
    if (stem.size() > std::string_view(suffix).size() && stem.ends_with(suffix))
      return stem.substr(0, stem.size() - std::string_view(suffix).size());
  return stem;
}

// Picture size of the matrices, in ingested pixels: stored or upright.
PixelSize matrix_size(const Photo& photo, bool stored) { return stored ? stored_size(photo) : upright_size(photo); }

// A file with the twelve numbers in the order of columns decomposes, too, but into a sheared camera.
Decomposed decomposed_file(const double (&p)[12], const fs::path& file) {
  try {
    return decomposed_projection(p, file);
  } catch (const Error&) {
    double q[12];
    for (size_t k = 0; k < 12; ++k) q[k] = p[3 * (k % 4) + k / 4];
    double focal = 0;
    try {
      focal = decomposed_projection(q, file).fx;
    } catch (const Error&) {
    }
    if (!(focal > 1)) throw;
    throw Error(
        ErrorKind::Input, "a projection matrix is stored by columns",
        {.where = file.string(),
         .why = fmt::format("read by rows its pixels are sheared, read by columns it has a focal length of {:.4g}", focal),
         .hint = "write 3 rows of 4 numbers: transpose the matrices",
         .code = "POSES_BAD_MATRIX"});
  }
}

ColmapModel read_matrices(const std::vector<fs::path>& files, std::span<const Photo> photos, double given_scale,
                          PosePixels& pixels) {
  ColmapModel model;
  struct Row {
    size_t photo;
    Decomposed d;
  };
  std::vector<Row> rows;
  const PhotoFinder finder(photos);
  std::map<size_t, fs::path> file_of;  // photo -> its matrix
  for (const fs::path& file : files) {
    std::istringstream text(read_text_file(file));
    double p[12];
    int n = 0;
    while (n < 12 && text >> p[n]) ++n;
    if (n < 12)
      throw Error(ErrorKind::Input, "a projection matrix has too few numbers",
                  {.where = file.string(),
                   .why = fmt::format("{} of 12 numbers", n),
                   .hint = "write 3 rows of 4 numbers",
                   .code = "POSES_BAD_MATRIX"});
    const std::string key = matrix_key(file);
    std::optional<size_t> photo = finder.match(key).photo;
    const bool called_so = photo.has_value();
    bool unique = true;
    for (size_t i = 0; i < photos.size() && !called_so; ++i) {
      const std::string name = fs::path(photos[i].name).filename().string();
      // No digit may follow the key: "0001" must not match "00012".
      if (!name.starts_with(key) || (name.size() > key.size() && std::isdigit(static_cast<unsigned char>(name[key.size()]))))
        continue;
      unique &= !photo.has_value();
      photo = i;
    }
    if (!photo || !unique) {
      log_warning("sfm: {} names {} photo; it is left out", file.string(), photo ? "more than one" : "no");
      continue;
    }
    if (const auto [first, fresh] = file_of.emplace(*photo, file); !fresh)
      throw Error(ErrorKind::Input, "two projection matrices are of one photo",
                  {.where = file.string(),
                   .why = fmt::format("{} names the photo {}, too", first->second.string(), photos[*photo].name),
                   .hint = "remove one of them",
                   .code = "POSES_TWICE"});
    rows.push_back({*photo, decomposed_file(p, file)});
  }
  // Matrices often belong to larger originals and ignore EXIF. Try the scales 1, 1/2, .. 1/8 times the ingest reduction, for
  // stored and upright photos; use the one that centres the principal point.
  double scale = given_scale, best = 1e300;
  bool stored = false;
  for (const bool turned : {false, true})
    for (int n = 1; n <= 8; ++n) {
      const double tried = given_scale > 0 ? given_scale : 1.0 / n;
      double miss = 0;
      for (const Row& r : rows) {
        const Photo& photo = photos[r.photo];
        const PixelSize size = matrix_size(photo, turned);
        const double s = tried * photo.width / std::max(1, photo.original_width);
        miss += std::hypot(s * r.d.cx / size.width - 0.5, s * r.d.cy / size.height - 0.5) / double(rows.size());
      }
      if (miss < best - 1e-9) best = miss, scale = tried, stored = turned;
    }
  if (given_scale <= 0 && !rows.empty())
    log_info(
        "sfm: projection matrices scaled by {:.4g} (principal points {:.1f} % of the size off the centre); --set sfm.pose_scale "
        "overrides",
        scale, 100 * best);
  for (const Row& r : rows) {
    const Photo& photo = photos[r.photo];
    const PixelSize size = matrix_size(photo, stored);
    PosedPhoto p = posed_photo(photo, size.width, size.height);
    // A matrix has no picture size. For swapped sides the principal point decides; half turns stay unsettled.
    if (swaps_sides(photo.orientation) && photo.width != photo.height) p.fits_stored = stored, p.fits_upright = !stored;
    pixels.photos.push_back(std::move(p));
  }
  settle_pixels(pixels);
  for (size_t i = 0; i < rows.size(); ++i) {
    const Row& r = rows[i];
    const Photo& photo = photos[r.photo];
    const PosedPhoto& p = pixels.photos[i];
    if (p.left_out) continue;
    const PixelSize size = matrix_size(photo, p.for_stored);
    const double sx = scale * photo.width / std::max(1, photo.original_width),
                 sy = scale * photo.height / std::max(1, photo.original_height);
    const uint32_t id = static_cast<uint32_t>(r.photo) + 1;
    const ColmapCamera camera =
        colmap_pinhole(id, {int(size.width), int(size.height), sx * r.d.fx, sy * r.d.fy, sx * r.d.cx, sy * r.d.cy});
    model.cameras.push_back(p.for_stored ? upright_camera(camera, photo.orientation) : camera);
    const Rigid pose = p.for_stored ? upright_pose(r.d.cam_from_world, photo.orientation) : r.d.cam_from_world;
    model.images.push_back({.id = id,
                            .rotation = quaternion(pose.rotation),
                            .translation = pose.translation,
                            .camera_id = id,
                            .name = photo.name,
                            .points = {}});
  }
  return model;
}

PoseSource source_of(PoseFile::Kind kind) {
  switch (kind) {
    case PoseFile::Kind::Colmap:
      return PoseSource::Colmap;
    case PoseFile::Kind::Transforms:
      return PoseSource::Transforms;
    case PoseFile::Kind::Matrices:
      return PoseSource::Matrices;
    case PoseFile::Kind::Metashape:
      return PoseSource::Metashape;
    case PoseFile::Kind::OpenSfm:
      return PoseSource::OpenSfm;
    case PoseFile::Kind::OpenMvg:
      return PoseSource::OpenMvg;
  }
  return PoseSource::Colmap;
}

[[noreturn]] void throw_other_shape(const PosedPhoto& photo, const std::string& image, const PosePixels& pixels,
                                    const fs::path& path) {
  std::vector<std::string> names{image, photo.name};
  for (const PosedPhoto& p : pixels.photos) names.push_back(p.name);
  const fs::path pictures = pictures_beside(path, names, photo.given);
  throw Error(
      ErrorKind::Input, "given poses and photos differ in shape",
      {.where = image,
       .why = fmt::format("the pose is for {:.0f} x {:.0f} pixels, the photo is {:.0f} x {:.0f}", photo.given.width,
                          photo.given.height, photo.upright.width, photo.upright.height),
       .hint = pictures.empty() ? std::string("give the photos that the poses were made with (not cropped, not turned)")
                                : fmt::format("give the pictures of {} as photos: they have that size", pictures.string()),
       .code = "POSES_SIZE"});
}

// Renames images to photo names (named_poses.h), scales cameras and observations to the ingested size and turns them upright.
ColmapModel on_photos(ColmapModel model, std::span<const Photo> photos, const fs::path& path, PosePixels& pixels) {
  std::map<std::string, size_t> index_of;
  for (size_t i = 0; i < photos.size(); ++i) index_of.emplace(photos[i].name, i);
  const auto find = [&](const std::string& name) {
    const auto at = index_of.find(name);
    return at != index_of.end() ? std::optional(at->second) : std::nullopt;
  };
  std::set<size_t> taken;
  std::vector<size_t> matched;  // indices of model images
  std::vector<const Photo*> photo_of;
  std::vector<ColmapCamera> camera_of;
  for (size_t i = 0; i < model.images.size(); ++i) {
    const std::optional<size_t> photo = find(model.images[i].name);
    if (!photo || !taken.insert(*photo).second) continue;
    ColmapCamera camera = *model.find_camera(model.images[i].camera_id);
    // Models up to OPENCV stay as they are written: sfm/lenses.json names them.
    if (camera.model_id > colmap_camera_type("OPENCV")->id) camera = simplest_camera(std::move(camera));
    is_distorted(camera);  // throws for unknown lens models
    if (sides_look_swapped(photos[*photo], camera)) std::swap(camera.width, camera.height);
    PosedPhoto p = posed_photo(photos[*photo], double(camera.width), double(camera.height));
    if (!p.fits_upright && !p.fits_stored) throw_other_shape(p, model.images[i].name, pixels, path);
    pixels.photos.push_back(std::move(p));
    matched.push_back(i);
    photo_of.push_back(&photos[*photo]);
    camera_of.push_back(std::move(camera));
  }
  settle_pixels(pixels);
  check_pixel_sizes(pixels, photo_of, camera_of, path);
  std::vector<ColmapImage> images;
  // (source camera, ingested size, orientation) -> new id. Photos with an unsettled orientation share no camera with settled
  // ones.
  std::map<std::tuple<uint32_t, int, int, int, bool>, uint32_t> camera_ids;
  std::vector<ColmapCamera> cameras;
  std::set<uint32_t> kept_ids;
  bool mirrored = false;
  for (size_t k = 0; k < matched.size(); ++k) {
    const PosedPhoto& p = pixels.photos[k];
    if (p.left_out) continue;
    ColmapImage image = std::move(model.images[matched[k]]);
    const int turned = p.for_stored || !p.settled ? p.orientation : 1;
    const auto [at, fresh] =
        camera_ids.emplace(std::tuple(image.camera_id, photo_of[k]->width, photo_of[k]->height, turned, p.settled),
                           static_cast<uint32_t>(cameras.size()) + 1);
    if (fresh) {
      cameras.push_back(camera_on_photo(camera_of[k], p));
      cameras.back().id = at->second;
    }
    for (ColmapPoint2D& q : image.points) {
      const Vec2d to = point_on_photo({q.x, q.y}, p);
      q.x = to.x, q.y = to.y;
    }
    if (p.for_stored) {
      const Rigid pose = upright_pose(image.cam_from_world(), p.orientation);
      image.rotation = quaternion(pose.rotation);
      image.translation = pose.translation;
      mirrored |= is_mirrored(p.orientation);
    }
    image.name = p.name;
    image.camera_id = at->second;
    kept_ids.insert(image.id);
    images.push_back(std::move(image));
  }
  model.images = std::move(images);
  model.cameras = std::move(cameras);
  for (ColmapPoint3D& p : model.points) {
    if (mirrored) p.position = mirrored_world(p.position);
    std::erase_if(p.track, [&](const ColmapTrackElement& t) { return !kept_ids.contains(t.image_id); });
  }
  return compacted(std::move(model), [](const ColmapPoint3D& p) { return p.track.size() >= 2; });
}

}  // namespace

Decomposed decomposed_projection(const double (&p)[12], const fs::path& where) {
  // Rows of M = K R up to a factor: m3 = r3, m2 = fy r2 + cy r3, m1 = fx r1 + skew r2 + cx r3.
  Vec3d m1{p[0], p[1], p[2]}, m2{p[4], p[5], p[6]}, m3{p[8], p[9], p[10]};
  Vec3d t{p[3], p[7], p[11]};
  double factor = length(m3);
  const auto fail = [&](const std::string& why) -> void {
    throw Error(
        ErrorKind::Input, "a projection matrix is no pinhole camera",
        {.where = where.string(), .why = why, .hint = "give matrices P = K [R | t] in pixels", .code = "POSES_BAD_MATRIX"});
  };
  if (!(factor > 0) || !std::isfinite(factor)) fail("its third row has no direction");
  if (dot(cross(m1, m2), m3) < 0) factor = -factor;  // P and -P are the same camera; choose the sign of a proper rotation
  m1 = m1 / factor, m2 = m2 / factor, m3 = m3 / factor, t = t / factor;
  Decomposed d;
  const Vec3d r3 = m3;
  d.cy = dot(m2, r3);
  d.fy = length(m2 - d.cy * r3);
  if (!(d.fy > 1e-9)) fail("its rows are linearly dependent");
  const Vec3d r2 = (m2 - d.cy * r3) / d.fy;
  d.cx = dot(m1, r3);
  const double skew = dot(m1, r2);
  d.fx = length(m1 - d.cx * r3 - skew * r2);
  if (!(d.fx > 1e-9)) fail("its rows are linearly dependent");
  const Vec3d r1 = (m1 - d.cx * r3 - skew * r2) / d.fx;
  if (std::abs(skew) > kTinySkew * d.fx)
    fail(fmt::format("its pixels are sheared: skew {:.4g} for a focal length of {:.4g}", skew, d.fx));
  d.cam_from_world.rotation = transposed(Mat3d{r1, r2, r3});
  const double z = t.z, y = (t.y - d.cy * z) / d.fy, x = (t.x - d.cx * z - skew * y) / d.fx;
  d.cam_from_world.translation = {x, y, z};
  return d;
}

GivenPoses given_poses(const fs::path& path, std::span<const Photo> photos, double matrix_scale) {
  const std::vector<PoseFile> files = find_pose_files(path);
  GivenPoses given;
  given.source = files[0].path;
  ColmapModel& model = given.model;
  if (files[0].kind == PoseFile::Kind::Matrices) {
    given.pixels.source = PoseSource::Matrices;
    model = read_matrices(matrix_files(files[0].path), photos, matrix_scale, given.pixels);
    if (model.images.size() < 2)
      throw Error(
          ErrorKind::Input, "the given poses do not belong to these photos",
          {.where = path.string(),
           .why = fmt::format("{} of {} photos have a matrix of their name: the matrices are called like '{}', the photos "
                              "like '{}'",
                              model.images.size(), photos.size(), matrix_files(files[0].path)[0].filename().string(),
                              photos.empty() ? "" : photos[0].source),
           .hint = "0001.txt or 0001_P.txt is the matrix of 0001.jpg",
           .code = "POSES_DO_NOT_MATCH"});
  } else {
    NamedPoses named = named_poses(files, photos);
    given.source = named.file.path;
    given.other_versions = std::move(named.versions);
    given.notes = std::move(named.notes);
    given.pixels.source = source_of(named.file.kind);
    model = on_photos(std::move(named.model), photos, given.source, given.pixels);
  }
  // Ids follow the name order, as elsewhere in this stage.
  std::map<uint32_t, uint32_t> new_id;
  std::sort(model.images.begin(), model.images.end(), [](const ColmapImage& a, const ColmapImage& b) { return a.name < b.name; });
  for (ColmapImage& image : model.images) {
    const uint32_t id = static_cast<uint32_t>(new_id.size()) + 1;
    new_id[image.id] = id;
    image.id = id;
  }
  for (ColmapPoint3D& p : model.points)
    for (ColmapTrackElement& t : p.track) t.image_id = new_id.at(t.image_id);
  check_colmap_model(model, given.source);
  return given;
}

ColmapModel read_given_poses(const fs::path& path, std::span<const Photo> photos, double matrix_scale, PosePixels* pixels) {
  GivenPoses given = given_poses(path, photos, matrix_scale);
  if (pixels != nullptr) *pixels = std::move(given.pixels);
  return std::move(given.model);
}

}  // namespace vitrine
