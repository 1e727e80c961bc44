#include "core/intake/poses/pose_pixels.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/intake/masks/photo_masks.h"
#include "core/scene/camera/colmap_lens.h"
#include "core/scene/image/probe.h"

namespace vitrine {

namespace {

constexpr size_t kProbed = 3;     // pictures next to the model that are inspected
constexpr int kLevels = 3;        // the model's folder and its parents: dense/sparse, OUT/sparse/0
constexpr int kMostReduced = 16;  // images_2, images_4, images_8 and the like

std::string size_text(const PixelSize& s) { return fmt::format("{:.0f} x {:.0f}", s.width, s.height); }

bool same(const PixelSize& a, const PixelSize& b) { return a.width == b.width && a.height == b.height; }

// Integer division by n, rounded up or down.
bool divided(const PixelSize& large, const PixelSize& small) {
  for (int n = 2; n <= kMostReduced; ++n)
    if (std::abs(large.width / n - small.width) < 1 && std::abs(large.height / n - small.height) < 1) return true;
  return false;
}

// Common sizes of the longest side: 1600, 1920, 1024, 1000.
bool round_side(const PixelSize& s) {
  const int longest = int(std::lround(std::max(s.width, s.height)));
  constexpr int kUsual[] = {720, 1080, 1152, 1296, 1440, 1920, 2160, 3840};
  return longest % 100 == 0 || longest % 128 == 0 || std::find(std::begin(kUsual), std::end(kUsual), longest) != std::end(kUsual);
}

// Resized by a common ratio or to a common size. A crop or an undistorted picture is about as large as the photo and has one of
// these sizes only by chance.
bool usual_resize(const PixelSize& a, const PixelSize& b) {
  constexpr double kClearlySmaller = 0.85;
  const PixelSize &small = a.width < b.width ? a : b, &large = a.width < b.width ? b : a;
  return divided(large, small) || (small.width < kClearlySmaller * large.width && round_side(small));
}

// Sizes that a program rounded to multiples of a number, one side more than the other: 518 x 392 (of 14) for 4:3.
bool rounded_size(const PixelSize& given, const PixelSize& photo) {
  constexpr double kMost = 0.01;  // of the aspect ratio
  constexpr long kLeastMultiple = 8;
  const long w = std::lround(given.width), h = std::lround(given.height);
  if (w <= 0 || h <= 0 || photo.width <= 0 || photo.height <= 0) return false;
  const long step = std::gcd(w, h);
  const double ratio = given.width * photo.height / (given.height * photo.width);
  return step >= kLeastMultiple && std::abs(ratio - 1) <= kMost &&
         std::abs(given.height - given.width * photo.height / photo.width) <= double(step);
}

bool fits(const PixelSize& photo, double width, double height) {
  return same_shape(int(photo.width), int(photo.height), width, height) || rounded_size({width, height}, photo);
}

// A camera of one focal length as one of two.
ColmapCamera with_two_focals(ColmapCamera camera) {
  const bool lens = camera.params.size() > 3;
  const double f = camera.params[0], k1 = lens ? camera.params[3] : 0, k2 = camera.params.size() > 4 ? camera.params[4] : 0;
  camera.params = {f, f, camera.params[1], camera.params[2]};
  if (lens) camera.params.insert(camera.params.end(), {k1, k2, 0, 0});
  camera.model_id = colmap_camera_type(lens ? "OPENCV" : "PINHOLE")->id;
  return camera;
}

PixelSize picture_size(const fs::path& file) {
  constexpr size_t kHead = 1 << 18;  // EXIF blocks with thumbnails precede the size
  std::error_code failed;
  if (!fs::is_regular_file(file, failed)) return {};
  std::string head(kHead, '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(head.data(), std::streamsize(head.size()));
  head.resize(static_cast<size_t>(std::max<std::streamsize>(0, in.gcount())));
  const Probe probe = probe_photo(head);
  return {double(probe.width), double(probe.height)};
}

// The folder of a model and its parents in the same capture.
std::vector<fs::path> folders_around(const fs::path& model) {
  std::error_code failed;
  fs::path folder = fs::is_directory(model, failed) ? model : model.parent_path();
  if (folder.empty()) folder = ".";
  folder = fs::absolute(folder, failed).lexically_normal();
  if (folder.filename().empty()) folder = folder.parent_path();
  std::vector<fs::path> out;
  for (int i = 0; i < kLevels && !folder.empty(); ++i) {
    out.push_back(folder);
    if (folder == folder.parent_path()) break;
    folder = folder.parent_path();
  }
  return out;
}

// Picture sizes that an earlier run undistorted, from its report.
struct Resampled {
  PixelSize photographed, undistorted;
};
std::vector<Resampled> our_undistortions(const std::vector<fs::path>& folders) {
  // Another program's file may have this name: check every field.
  const auto size_at = [](const nlohmann::json& camera, const char* key) {
    const auto side = [](const nlohmann::json& in, const char* name) {
      return in.is_object() && in.contains(name) && in[name].is_number() ? in[name].get<double>() : 0.0;
    };
    return camera.contains(key) ? PixelSize{side(camera[key], "width"), side(camera[key], "height")} : PixelSize{};
  };
  std::vector<Resampled> out;
  for (const fs::path& folder : folders) {
    std::error_code failed;
    const fs::path lenses = folder / "sfm" / "lenses.json";
    if (!fs::is_regular_file(lenses, failed)) continue;
    const nlohmann::json j = nlohmann::json::parse(read_file(lenses), nullptr, false);
    if (!j.is_object() || !j.contains("cameras") || !j["cameras"].is_array()) continue;
    for (const nlohmann::json& c : j["cameras"])
      if (c.is_object() && c.contains("resampled") && c["resampled"] == true)
        out.push_back({size_at(c, "photographed"), size_at(c, "undistorted")});
  }
  return out;
}

// Detects the output of `colmap image_undistorter`.
bool colmap_undistortion(const std::vector<fs::path>& folders) {
  std::error_code failed;
  return std::any_of(folders.begin(), folders.end(), [&](const fs::path& folder) {
    return fs::is_directory(folder / "stereo", failed) || fs::is_regular_file(folder / "run-colmap-photometric.sh", failed);
  });
}

}  // namespace

std::string_view name(PoseSource source) {
  switch (source) {
    case PoseSource::Colmap:
      return "COLMAP model";
    case PoseSource::Transforms:
      return "transforms.json";
    case PoseSource::Matrices:
      return "projection matrices";
    case PoseSource::Metashape:
      return "cameras file of Metashape";
    case PoseSource::OpenSfm:
      return "reconstruction of OpenSfM";
    case PoseSource::OpenMvg:
      return "sfm_data file of OpenMVG";
  }
  return "";
}

bool PosePixels::open() const {
  return std::any_of(photos.begin(), photos.end(), [](const PosedPhoto& p) { return !p.settled; });
}

PosedPhoto posed_photo(const Photo& photo, double width, double height) {
  PosedPhoto p{.name = photo.name, .orientation = photo.orientation, .given = {width, height}};
  p.stored = stored_size(photo), p.upright = upright_size(photo);
  p.fits_upright = fits(p.upright, width, height);
  p.fits_stored = fits(p.stored, width, height);
  return p;
}

bool sides_look_swapped(const Photo& photo, const ColmapCamera& camera) {
  constexpr double kMiddle = 0.06, kOff = 0.1;  // of a side; real lenses reach 0.02
  if (!swaps_sides(photo.orientation)) return false;
  const Intrinsics k = pinhole_part(camera);
  const auto off = [&](double width, double height) {
    return std::max(std::abs(k.cx / width - 0.5), std::abs(k.cy / height - 0.5));
  };
  return same_shape(photo.width, photo.height, k.width, k.height) && off(k.width, k.height) > kOff &&
         off(k.height, k.width) < kMiddle;
}

void settle_pixels(PosePixels& pixels) {
  size_t stored = 0, upright = 0, turned = 0, mirrored = 0;
  for (const PosedPhoto& p : pixels.photos) {
    if (p.orientation == 1) continue;
    ++turned;
    mirrored += is_mirrored(p.orientation);
    stored += p.fits_stored && !p.fits_upright;
    upright += p.fits_upright && !p.fits_stored;
  }
  if (turned == 0) return;
  const bool decided = (stored > 0) != (upright > 0), all_mirrored = mirrored == pixels.photos.size();
  // COLMAP, Metashape, OpenSfM and OpenMVG use stored pixels. Most other programs apply the orientation first.
  const bool assumed_stored =
      decided ? stored > 0 : pixels.source != PoseSource::Transforms && pixels.source != PoseSource::Matrices;
  size_t open = 0, mirrored_out = 0;
  for (PosedPhoto& p : pixels.photos) {
    if (p.orientation == 1) continue;
    const bool both = p.fits_stored && p.fits_upright;
    p.for_stored = both ? assumed_stored : p.fits_stored;
    p.settled = !both || decided;
    if (is_mirrored(p.orientation) && !all_mirrored) {
      // No program computes a valid pose of a mirrored picture among unmirrored ones: if both fit, the pose is for the upright
      // one.
      p.settled = true;
      if (both) p.for_stored = false;
      p.left_out = p.for_stored;
    }
    mirrored_out += p.left_out;
    open += !p.settled;
  }
  size_t as_stored = 0;
  for (const PosedPhoto& p : pixels.photos) as_stored += p.for_stored && !p.left_out;
  if (open > 0)
    pixels.notes.push_back(
        {"POSES_ORIENTATION",
         fmt::format("EXIF turns {} of the photos, and the {} does not say whether its poses are for the photos as stored or "
                     "upright: {} is assumed",
                     open, name(pixels.source), assumed_stored ? "as stored" : "upright")});
  else if (as_stored > 0)
    pixels.notes.push_back(
        {"", fmt::format("the poses of {} photos are for the pixels as stored: they are turned with the photos, "
                         "as EXIF says",
                         as_stored)});
  if (all_mirrored && as_stored > 0)
    pixels.notes.push_back(
        {"POSES_MIRRORED",
         "EXIF mirrors all photos, and the poses are of the mirrored pictures: the world is mirrored with them"});
  if (mirrored_out > 0)
    pixels.notes.push_back({"POSES_MIRRORED", fmt::format("{} photos are left out: EXIF mirrors them, and their poses are of the "
                                                          "mirrored pictures, which have no place among the others",
                                                          mirrored_out)});
}

fs::path pictures_beside(const fs::path& model, const std::vector<std::string>& names, const PixelSize& size) {
  for (const fs::path& folder : folders_around(model))
    for (const fs::path& pictures : {folder / "images", folder}) {
      size_t looked = 0, fitting = 0;
      for (const std::string& name : names) {
        if (looked == kProbed) break;
        const PixelSize found = picture_size(pictures / name);
        if (found.width <= 0) continue;
        ++looked;
        fitting += same(found, size);
      }
      if (looked > 0 && fitting == looked) return pictures;
    }
  return {};
}

void check_pixel_sizes(PosePixels& pixels, std::span<const Photo* const> photos, std::span<const ColmapCamera> cameras,
                       const fs::path& model) {
  const std::vector<fs::path> around = folders_around(model);
  std::vector<std::string> names;
  for (const PosedPhoto& p : pixels.photos) names.push_back(p.name);
  const std::vector<Resampled> resampled = our_undistortions(around);
  const bool by_colmap = colmap_undistortion(around);
  size_t odd = 0, usual = 0;
  std::string odd_sizes, usual_sizes;
  for (size_t i = 0; i < pixels.photos.size(); ++i) {
    const PosedPhoto& p = pixels.photos[i];
    PixelSize original{double(photos[i]->original_width), double(photos[i]->original_height)};
    if (p.for_stored && swaps_sides(p.orientation)) std::swap(original.width, original.height);
    const PixelSize ingested = p.for_stored ? p.stored : p.upright;
    if (same(p.given, original) || same(p.given, ingested)) continue;
    std::string sizes = fmt::format("the cameras are for {} pixels, the photos have {}", size_text(p.given), size_text(original));
    if (!same_shape(int(original.width), int(original.height), p.given.width, p.given.height))
      sizes += fmt::format(" (the aspect ratio differs by {:.1f} %: each side has its own scale)",
                           100 * std::abs(p.given.width * original.height / (p.given.height * original.width) - 1));
    const bool usual_ratio = usual_resize(p.given, original), straight = !is_distorted(cameras[i]);
    const bool ours = straight && std::ranges::any_of(resampled, [&](const Resampled& r) {
                        return same(r.undistorted, p.given) && (same(r.photographed, original) || same(r.photographed, ingested));
                      });
    const bool colmaps = straight && by_colmap;
    if (ours || (straight && !usual_ratio)) {
      const fs::path pictures = pictures_beside(model, names, p.given);
      if (ours || colmaps || !pictures.empty()) {
        const std::string where = pictures.empty() ? std::string("the undistorted pictures") : pictures.string();
        throw Error(ErrorKind::Input, "the poses are of undistorted pictures, not of these photos",
                    {.where = model.string(),
                     .why = fmt::format("{}: a lens-free camera for a part of the picture{}", sizes,
                                        pictures.empty() ? "" : "; pictures of that size are in " + pictures.string()),
                     .hint = fmt::format("give {} as photos, or poses with the lens model for the photos as taken", where),
                     .code = "POSES_UNDISTORTED"});
      }
    }
    if (usual_ratio && !colmaps) {
      if (usual++ == 0) usual_sizes = sizes;
    } else if (odd++ == 0) {
      odd_sizes = sizes;
    }
  }
  const auto of_all = [&](size_t n) { return n == pixels.photos.size() ? std::string() : fmt::format(" ({} photos)", n); };
  if (usual > 0) pixels.notes.push_back({"", fmt::format("{}{}: scaled", usual_sizes, of_all(usual))});
  pixels.oddly_resized = odd > 0;
  if (odd > 0)
    pixels.notes.push_back(
        {"POSES_RESIZED", fmt::format("{}{}: they are taken for the same pictures resized. If the poses are of "
                                      "cropped or undistorted pictures, give these pictures as photos",
                                      odd_sizes, of_all(odd))});
}

ColmapCamera camera_on_photo(const ColmapCamera& given, const PosedPhoto& photo) {
  const PixelSize& to = photo.for_stored ? photo.stored : photo.upright;
  const double sx = to.width / double(given.width), sy = to.height / double(given.height);
  ColmapCamera camera = given;
  if (!has_two_focals(camera.model_id) && !same_shape(int(to.width), int(to.height), double(given.width), double(given.height)))
    camera = with_two_focals(std::move(camera));
  if (has_two_focals(camera.model_id)) {
    camera.params[0] *= sx, camera.params[1] *= sy, camera.params[2] *= sx, camera.params[3] *= sy;
  } else {
    // A single focal length cannot be scaled anisotropically: the mean of both factors is exact up to the rounding of the size.
    camera.params[0] *= 0.5 * (sx + sy), camera.params[1] *= sx, camera.params[2] *= sy;
  }
  camera.width = static_cast<uint64_t>(to.width);
  camera.height = static_cast<uint64_t>(to.height);
  return photo.for_stored ? upright_camera(camera, photo.orientation) : camera;
}

Vec2d point_on_photo(const Vec2d& given, const PosedPhoto& photo) {
  const PixelSize& to = photo.for_stored ? photo.stored : photo.upright;
  const double sx = to.width / photo.given.width, sy = to.height / photo.given.height;
  const Vec2d scaled{given.x * sx, given.y * sy};
  return photo.for_stored ? upright_pixel(scaled, photo.orientation, photo.stored) : scaled;
}

}  // namespace vitrine
