#include "stages/ingest/panorama_photos.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "core/foundation/base/file.h"
#include "core/scene/camera/panorama_views.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"

namespace vitrine::ingest {

std::vector<Photo> write_panorama_views(ImageF linear, const Photo& panorama, const std::string& folder, int max_side,
                                        const fs::path& output) {
  const Intrinsics view = panorama_view_intrinsics(linear.width(), max_side);
  const EquirectSampler sampler(panorama_for_views(linear, view));
  const int channels = linear.channels();
  linear = {};
  std::vector<Photo> photos;
  for (int i = 0; i < kPanoramaViews; ++i) {
    const Mat3d rotation = panorama_view_rotation(i);
    Photo& photo = photos.emplace_back(panorama);
    photo.stem = fmt::format("{}/view_{:02}", folder, i);
    photo.name = photo.stem + fs::path(panorama.name).extension().string();
    photo.width = view.width, photo.height = view.height;
    photo.focal_px = view.fx;
    photo.focal_source = "panorama";
    photo.zoom.reset();  // of the lenses whose pictures were joined
    photo.rig = PhotoRig{panorama.source, quaternion(rotation)};
    const ImageF picture = panorama_view(sampler, channels, view, rotation);
    make_folders(ingested_linear_path(output, photo).parent_path());
    make_folders(ingested_ldr_path(output, photo).parent_path());
    write_exr_rgb(ingested_linear_path(output, photo), picture);
    write_ldr(ingested_ldr_path(output, photo), srgb8_from_linear(picture));
  }
  return photos;
}

std::vector<std::string> view_folders(std::span<const PhotoFile> photos) {
  std::set<std::string> taken;
  for (const PhotoFile& photo : photos)
    for (fs::path folder = fs::path(photo.stem).parent_path(); !folder.empty(); folder = folder.parent_path())
      taken.insert(folder.generic_string());
  std::vector<std::string> folders;
  for (const PhotoFile& photo : photos) {
    std::string& folder = folders.emplace_back(photo.stem);
    while (!taken.insert(folder).second) folder += '_';
  }
  return folders;
}

}  // namespace vitrine::ingest
