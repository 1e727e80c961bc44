#include "stages/evaluate/truth.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/scene/camera/projection.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"
#include "core/scene/mesh/mesh_io.h"
#include "stages/evaluate/alignment.h"

namespace vitrine {
namespace fs = std::filesystem;
namespace {

constexpr double kMaxAspectError_px = 2;  // rounding of a reduced map; a larger error means another picture
constexpr double kMaxTurn_deg = 3;
constexpr int kMaskSubsamples = 3;  // odd: a majority always exists
constexpr float kMaskLevel = 0.5f;

// "../photos/img_0001" matches the view "img_0001", "x/cam0/a" matches "cam0/a"; "img_10" does not match "0".
bool names_view(const std::string& truth_stem, const std::string& stem) {
  if (truth_stem == stem) return true;
  return truth_stem.size() > stem.size() && truth_stem.ends_with(stem) && truth_stem[truth_stem.size() - stem.size() - 1] == '/';
}

ImageF channels_of(const ExrImage& exr, std::initializer_list<std::string_view> names, const fs::path& path) {
  std::vector<int> indices;
  for (std::string_view n : names) {
    const auto it = std::find(exr.channels.begin(), exr.channels.end(), n);
    if (it != exr.channels.end()) indices.push_back(int(it - exr.channels.begin()));
  }
  if (indices.size() != names.size() && exr.channels.size() == names.size()) {  // a plain channel set with other names
    indices.clear();
    for (size_t i = 0; i < names.size(); ++i) indices.push_back(int(i));
  }
  if (indices.size() != names.size()) {
    std::string wanted, found;
    for (std::string_view n : names) wanted.append(" ").append(n);
    for (const std::string& n : exr.channels) found.append(" ").append(n);
    throw Error(ErrorKind::Input, "a truth map lacks channels",
                {.where = path.string(),
                 .why = fmt::format("wanted{}, found{}", wanted, found),
                 .hint = "write depth as channel Z and normals as X Y Z",
                 .code = "TRUTH_BAD_MAP"});
  }
  ImageF out(exr.pixels.width(), exr.pixels.height(), int(indices.size()));
  for (int y = 0; y < out.height(); ++y)
    for (int x = 0; x < out.width(); ++x)
      for (size_t c = 0; c < indices.size(); ++c) {
        const float v = exr.pixels.at(x, y, indices[c]);
        out.at(x, y, int(c)) = std::isfinite(v) ? v : 0.f;  // renderers write infinity for the sky
      }
  return out;
}

}  // namespace

ImageF at_size(const ImageF& image, const Intrinsics& k) {
  return image.width() == k.width && image.height() == k.height ? image : resized(image, k.width, k.height);
}

Truth::Truth(fs::path folder, const std::vector<View>& views) : folder_(std::move(folder)) {
  if (!fs::is_directory(folder_))
    throw Error(ErrorKind::Input, "the truth is not a folder",
                {.where = folder_.string(), .hint = "give a folder, or --truth none", .code = "TRUTH_NOT_A_FOLDER"});
  cameras_.resize(views.size());
  turns_.resize(views.size(), Mat3d::identity());
  for (const View& v : views) stems_.push_back(v.stem());
  has_transforms_ = fs::exists(transforms_path());
  if (!has_transforms_) return;
  // Without w and h, a truth camera has the size of its photo.
  const auto size_of = [&](const std::string& name) -> std::optional<PictureSize> {
    const std::string stem = fs::path(name).replace_extension().generic_string();
    for (size_t i = 0; i < views.size(); ++i)
      if (names_view(stem, stems_[i])) return PictureSize{views[i].intrinsics.width, views[i].intrinsics.height};
    return std::nullopt;
  };
  for (const View& t : read_transforms_json(transforms_path(), size_of)) {
    const std::string stem = t.stem();
    for (size_t i = 0; i < views.size(); ++i)
      if (!cameras_[i] && names_view(stem, stems_[i])) cameras_[i] = t;
  }
  for (size_t i = 0; i < cameras_.size(); ++i)
    if (cameras_[i] && (cameras_[i]->intrinsics.width <= 0 || cameras_[i]->intrinsics.height <= 0))
      throw Error(ErrorKind::Input, "a truth camera has no picture size",
                  {.where = transforms_path().string(),
                   .why = "frame " + cameras_[i]->name,
                   .hint = "give w and h",
                   .code = "TRUTH_BAD_CAMERA"});
}

void Truth::align(const Similarity& truth_from_ours, const std::vector<View>& views) {
  for (size_t i = 0; i < cameras_.size(); ++i) {
    if (!cameras_[i]) continue;
    const Mat3d turn =
        cameras_[i]->cam_from_world.rotation * truth_from_ours.rotation * transposed(views[i].cam_from_world.rotation);
    if (rotation_angle_deg(turn, Mat3d::identity()) < kMaxTurn_deg) turns_[i] = turn;
  }
}

size_t Truth::matched_cameras() const {
  return size_t(std::count_if(cameras_.begin(), cameras_.end(), [](const auto& c) { return c.has_value(); }));
}

bool Truth::has_maps(std::string_view kind) const {
  std::error_code ignored;
  return !fs::is_empty(folder_ / kind, ignored) && !ignored;
}

std::optional<fs::path> Truth::mesh_path() const {
  for (const char* file : {"mesh_opaque.ply", "mesh.ply"})
    if (fs::exists(folder_ / file)) return folder_ / file;
  return std::nullopt;
}

Intrinsics Truth::map_intrinsics(size_t view, const Intrinsics& ours, const ImageF& map, const fs::path& path) const {
  const Intrinsics& camera = cameras_[view] ? cameras_[view]->intrinsics : ours;
  const double expected_height = double(map.width()) * camera.height / camera.width;
  if (std::abs(expected_height - map.height()) > kMaxAspectError_px)
    throw Error(ErrorKind::Input, "a truth map does not have the shape of its photo",
                {.where = path.string(),
                 .why = fmt::format("{}x{}, but the camera is {}x{}", map.width(), map.height(), camera.width, camera.height),
                 .hint = "truth maps may be smaller than the photo, in the same proportions",
                 .code = "TRUTH_BAD_MAP"});
  return camera.scaled_to(map.width(), map.height());
}

ImageF sampled_by_direction(const ImageF& map, const Intrinsics& map_intrinsics, const Intrinsics& ours,
                            const Mat3d& map_from_ours) {
  ImageF out(ours.width, ours.height, map.channels());
  for (int y = 0; y < ours.height; ++y)
    for (int x = 0; x < ours.width; ++x) {
      const auto at = image_point(map_from_ours * ours.ray(x + 0.5, y + 0.5), map_intrinsics);
      if (!at) continue;
      for (int c = 0; c < map.channels(); ++c) out.at(x, y, c) = map.at(int(at->x), int(at->y), c);
    }
  return out;
}

std::optional<ImageF> Truth::zdepth(size_t view, const Intrinsics& intrinsics, LookupFrame frame) const {
  const fs::path path = folder_ / "depth" / (stems_[view] + ".exr");
  if (!fs::exists(path)) return std::nullopt;
  const ImageF map = channels_of(read_exr(path), {"Z"}, path);
  const Mat3d truth_from_ours = turn(view, frame);
  ImageF out = sampled_by_direction(map, map_intrinsics(view, intrinsics, map, path), intrinsics, truth_from_ours);
  // The map's z is along the truth camera's axis. A point at depth z on our axis is z r with our ray r = (x, y, 1), and has the
  // depth z (R r).z on the truth's axis.
  for (int y = 0; y < out.height(); ++y)
    for (int x = 0; x < out.width(); ++x)
      out.at(x, y) = float(out.at(x, y) / (truth_from_ours * intrinsics.ray(x + 0.5, y + 0.5)).z);
  return out;
}

std::optional<TruthPicture> Truth::clear(size_t view, const Intrinsics& intrinsics) const {
  return picture("clear", view, intrinsics);
}

std::optional<TruthPicture> Truth::transmitted(size_t view, const Intrinsics& intrinsics) const {
  return picture("transmitted", view, intrinsics);
}

std::optional<TruthPicture> Truth::albedo(size_t view, const Intrinsics& intrinsics) const {
  return picture("albedo", view, intrinsics);
}

std::optional<TruthPicture> Truth::relit(std::string_view name, size_t view, const Intrinsics& intrinsics) const {
  return picture(fs::path("relit") / name, view, intrinsics);
}

bool Truth::has_relit(std::string_view name, size_t view) const {
  return cameras_[view] && fs::exists(folder_ / "relit" / name / (stems_[view] + ".exr"));
}

std::optional<TruthPicture> Truth::picture(const fs::path& kind, size_t view, const Intrinsics& intrinsics) const {
  const fs::path path = folder_ / kind / (stems_[view] + ".exr");
  if (!fs::exists(path)) return std::nullopt;
  ImageF map = read_exr_rgb(path);
  const Intrinsics k = map_intrinsics(view, intrinsics, map, path);
  return TruthPicture{std::move(map), k, turns_[view]};
}

std::optional<ImageF> Truth::normal(size_t view, const Intrinsics& intrinsics) const {
  const fs::path path = folder_ / "normal" / (stems_[view] + ".exr");
  if (!fs::exists(path)) return std::nullopt;
  const ImageF map = channels_of(read_exr(path), {"X", "Y", "Z"}, path);
  ImageF out = sampled_by_direction(map, map_intrinsics(view, intrinsics, map, path), intrinsics, turns_[view]);
  for (int y = 0; y < out.height(); ++y)
    for (int x = 0; x < out.width(); ++x) {
      float* n = out.pixel(x, y);
      const double len = std::sqrt(double(n[0]) * n[0] + double(n[1]) * n[1] + double(n[2]) * n[2]);
      const double scale = len > 0.5 ? 1 / len : 0;  // a resampled edge can be short; much shorter is no normal
      for (int c = 0; c < 3; ++c) n[c] = float(n[c] * scale);
    }
  return out;
}

std::optional<ImageF> Truth::mask(size_t view, MaskClass c, const Intrinsics& intrinsics, LookupFrame frame) const {
  return mask_file(name(c), view, intrinsics, frame);
}

std::optional<ImageF> Truth::coated(size_t view, const Intrinsics& intrinsics) const {
  return mask_file("coated", view, intrinsics, LookupFrame::Ours);
}

std::optional<ImageF> Truth::mask_file(std::string_view kind, size_t view, const Intrinsics& intrinsics,
                                       LookupFrame frame) const {
  const fs::path path = folder_ / "mask" / kind / (stems_[view] + ".png");
  if (!fs::exists(path)) return std::nullopt;
  const ImageF map = floats_of(read_grey8(path));
  // Majority of nearest samples on a 3x3 grid inside each of our pixels, which keeps thin parts in a coarser render.
  const Intrinsics fine = intrinsics.scaled_to(intrinsics.width * kMaskSubsamples, intrinsics.height * kMaskSubsamples);
  const ImageF votes = sampled_by_direction(map, map_intrinsics(view, intrinsics, map, path), fine, turn(view, frame));
  ImageF out(intrinsics.width, intrinsics.height, 1);
  for (int y = 0; y < out.height(); ++y)
    for (int x = 0; x < out.width(); ++x) {
      float sum = 0;
      for (int j = 0; j < kMaskSubsamples; ++j)
        for (int i = 0; i < kMaskSubsamples; ++i) sum += votes.at(x * kMaskSubsamples + i, y * kMaskSubsamples + j);
      out.at(x, y) = sum > kMaskLevel * kMaskSubsamples * kMaskSubsamples ? 1.f : 0.f;
    }
  return out;
}

TriMesh read_truth_mesh(const fs::path& path) {
  TriMesh mesh = read_mesh_ply(path);
  if (mesh.faces.empty())
    throw Error(ErrorKind::Input, "the truth mesh has no triangles",
                {.where = path.string(), .hint = "mend the file, or --truth none", .code = "TRUTH_BAD_MESH"});
  return mesh;
}

}  // namespace vitrine
