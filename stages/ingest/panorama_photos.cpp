#include "stages/ingest/panorama_photos.h"

#include "core/foundation/base/file.h"
#include "core/scene/camera/panorama_views.h"
#include "core/scene/camera/wide_views.h"
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
    photo.name = view_name(folder, panorama.name, size_t(i));
    photo.stem = fs::path(photo.name).replace_extension().generic_string();
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
  std::vector<std::string> stems;
  for (const PhotoFile& photo : photos) stems.push_back(photo.stem);
  return vitrine::view_folders(stems);
}

}  // namespace vitrine::ingest
