// Pictures of the output folder, reduced and embedded as data URIs, and ray-cast pictures of the mesh.
#pragma once

#include <optional>
#include <string>

#include "core/foundation/base/file.h"
#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "core/scene/mesh/mesh_hits.h"

namespace vitrine {

struct Picture {
  std::string uri;  // data:image/jpeg;base64,...
  int width = 0, height = 0;
};

inline constexpr int kOpeningPicture = 1200, kLargePicture = 800, kMiddlePicture = 480,
                     kSmallPicture = 300;  // longest side, pixels

// nullopt if the file is missing or damaged. 8-bit JPEG or PNG.
std::optional<Picture> picture_of_file(const fs::path& path, int max_side);
// Linear light, 1 or 3 channels.
Picture picture_of_linear(const ImageF& linear, int max_side);
Picture picture_of(const Image8& image);

enum class AovKind { Radiance, Weight, Normal, Depth };
// Displayable version of an OpenEXR layer (stages/render/README.md): radiance in sRGB, weights as grey, normals as colours, depth
// from near (bright) to far (dark).
std::optional<Picture> picture_of_layer(const fs::path& exr, AovKind kind, int max_side);

// The mesh from the camera of a photo, ray cast.
struct SurfaceView {
  Image8 clay;     // lit from the camera, slightly from above
  Image8 normals;  // in the camera's frame: red right, green up, blue towards the camera
};

SurfaceView surface_view(const MeshHits& mesh, const View& view, int max_side);

}  // namespace vitrine
