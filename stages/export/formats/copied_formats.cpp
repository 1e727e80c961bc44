// Export formats that copy files of earlier stages.
#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/render/picture/decomposed_materials.h"
#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/corrected_poses.h"
#include "stages/export/formats/source.h"

namespace vitrine {

namespace {

// The sparse model of the sfm stage with the poses that training corrected.
ColmapModel corrected_model(const fs::path& sparse, const fs::path& optimize) {
  ColmapModel model = read_colmap_model(sparse, ColmapFormat::Binary);
  std::vector<View> views;
  for (const ColmapImage& image : model.images) views.push_back({.name = image.name, .cam_from_world = image.cam_from_world()});
  correct_poses(optimize, views);
  for (size_t i = 0; i < views.size(); ++i) {
    model.images[i].rotation = quaternion(views[i].cam_from_world.rotation);
    model.images[i].translation = views[i].cam_from_world.translation;
  }
  return model;
}

// colmap: undistorted photos and the sparse model in COLMAP layout: images/ and sparse/0/ (binary and text). The frame is the
// scene's (up = +z, ring radius 1); scene.json contains the inverse transform.
std::vector<std::string> write_colmap(ExportSource& source, const fs::path& folder) {
  const fs::path sparse = source.sfm() / "sparse" / "0";
  std::vector<std::string> files;
  const auto copy = [&](const fs::path& from, const std::string& name) {
    if (!fs::is_regular_file(from))
      throw Error(ErrorKind::Input, "a file of the reconstruction is missing",
                  {.where = from.string(), .hint = "run the sfm stage again", .code = "EXPORT_MISSING_FILE"});
    files.push_back("colmap/" + name);
    link_or_copy(from, folder / files.back());
  };
  for (const ColmapImage& image : read_colmap_model(sparse, ColmapFormat::Binary).images)
    copy(source.sfm() / "images" / image.name, "images/" + image.name);
  const bool corrected = has_corrected_poses(source.optimize());
  for (const char* part : {"cameras", "images", "points3D"})
    for (const char* extension : {".bin", ".txt"}) {
      const std::string name = std::string("sparse/0/") + part + extension;
      if (corrected)
        files.push_back("colmap/" + name);
      else
        copy(sparse / (std::string(part) + extension), name);
    }
  if (corrected)
    for (const ColmapFormat format : {ColmapFormat::Binary, ColmapFormat::Text})
      write_colmap_model(folder / "colmap" / "sparse" / "0", corrected_model(sparse, source.optimize()), format);
  copy(source.sfm() / "scene.json", "scene.json");
  return files;
}

// environment: the light from the decompose stage, as lat-long EXR of linear radiance. Orientation of the scene: first row = +z,
// centre = +x, counter-clockwise seen from above towards the left (core/scene/light/environment.h). Without the decompose stage
// there is no file.
std::vector<std::string> write_environment(ExportSource& source, const std::filesystem::path& folder) {
  if (!source.decompose()) return {};
  const std::string file = "environment.exr";
  link_or_copy(decomposed_environment_path(*source.decompose()), folder / file);
  return {file};
}

}  // namespace

ExportFormat colmap_format() {
  return {
      .name = "colmap",
      .summary = "undistorted photos and sparse model, ready for other trainers",
      .holds =
          "8-bit undistorted photos, pinhole cameras, poses, sparse points with tracks, binary and text; scene.json leads back "
          "to COLMAP's own frame",
      .loses = "linear photos, gains per view, everything that was trained",
      .write = write_colmap};
}

ExportFormat environment_format() {
  return {.name = "environment",
          .summary = "the light of the photos as lat-long EXR (when the decompose stage ran)",
          .holds = "linear radiance in the units of the albedo, up = first row, +x of the scene in the centre",
          .loses = "light that is near: everything is infinitely far away; the axes option does not turn it",
          .write = write_environment};
}

}  // namespace vitrine
