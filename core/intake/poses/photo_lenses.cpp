#include "core/intake/poses/photo_orientation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/holdout.h"
#include "core/foundation/config/json_file.h"

namespace vitrine {

namespace {

// Of a view cut from a wide photo.
struct Cut {
  Mat3d view_from_photo;
  double circle_px = 0;
};

struct LensFile {
  std::map<uint32_t, ColmapCamera> photographed;  // original lenses, by camera id
  std::map<uint32_t, Cut> cut;
  std::vector<std::string> without_camera;
  bool camera_flash = false, cut_out = false;
};

LensFile read_lenses(const fs::path& file) {
  LensFile out;
  std::error_code ec;
  if (!fs::exists(file, ec)) return out;
  read_json_file(file, "list of lenses", [&](const nlohmann::json& j) {
    for (const nlohmann::json& row : j.at("cameras")) {
      const nlohmann::json& p = row.at("photographed");
      const ColmapCameraType* type = colmap_camera_type(p.at("model").get<std::string>());
      if (type == nullptr) throw std::invalid_argument("unknown camera model " + p.at("model").dump());
      ColmapCamera camera{
          .id = p.at("id"), .model_id = type->id, .width = p.at("width"), .height = p.at("height"), .params = p.at("params")};
      if (camera.params.size() != type->parameter_count)
        throw std::invalid_argument("a camera has the wrong number of parameters");
      out.photographed[camera.id] = camera;
      if (!row.contains("view_from_photo")) continue;
      const auto q = row.at("view_from_photo").get<std::array<double, 4>>();
      if (!(std::abs(std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3])) - 1) < 1e-6))
        throw std::invalid_argument("view_from_photo is not a rotation");
      out.cut[camera.id] = {rotation_matrix(normalized(Quatd{q[0], q[1], q[2], q[3]})), row.at("circle_px").get<double>()};
    }
    out.without_camera = j.value("without_camera", std::vector<std::string>());
    out.camera_flash = j.value("camera_flash", false);
    out.cut_out = j.value("cut_out", false);
  });
  return out;
}

}  // namespace

PhotoLenses read_photo_lenses(const fs::path& sfm_folder, const ViewSet& set) {
  PhotoLenses lenses;
  const auto folder = find_colmap_model(sfm_folder);
  VITRINE_CHECK(folder, "a view set was read from {}", sfm_folder.string());
  const ColmapModel model = read_colmap_model(*folder);
  LensFile file = read_lenses(sfm_folder / "sfm/lenses.json");
  lenses.without_camera = std::move(file.without_camera);
  lenses.camera_flash = file.camera_flash;
  lenses.cut_out = file.cut_out;
  const Rigs rigs = read_rigs(sfm_folder);
  for (const View& view : set.views) {
    const auto image =
        std::find_if(model.images.begin(), model.images.end(), [&](const ColmapImage& i) { return i.name == view.name; });
    VITRINE_CHECK(image != model.images.end(), "view {} is not in the model", view.name);
    Undistortion u{.source = colmap_pinhole(image->camera_id, view.intrinsics), .target = view.intrinsics, .identity = true};
    const auto cut = file.cut.find(image->camera_id);
    if (cut != file.cut.end()) {
      const Cut& c = cut->second;
      u = {.source = file.photographed.at(image->camera_id),
           .target = view.intrinsics,
           .identity = false,
           .rotation = c.view_from_photo,
           .circle_px = c.circle_px};
    } else if (const auto found = file.photographed.find(image->camera_id); found != file.photographed.end()) {
      u = undistortion(found->second);
      if (u.target.width != view.intrinsics.width || u.target.height != view.intrinsics.height)
        throw Error(ErrorKind::Input, "cameras and lenses of the sfm stage disagree",
                    {.where = view.name,
                     .why = fmt::format("undistorted photos have {} x {} pixels, the lens leaves {} x {}", view.intrinsics.width,
                                        view.intrinsics.height, u.target.width, u.target.height),
                     .hint = "run the sfm stage again",
                     .code = "MASKS_SFM_MISMATCH"});
    }
    lenses.undistortions.push_back(std::move(u));
    const auto rig = rigs.find(view.name);
    lenses.photos.push_back(cut != file.cut.end() && rig != rigs.end() ? rig->second : view.name);
  }
  return lenses;
}

}  // namespace vitrine
