// A small output folder as `vitrine run` leaves it: two held-out views of three photos, figures of the test's choice.
#pragma once

#include <fstream>
#include <string>

#include <fmt/format.h>

#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/mesh/mesh_io.h"
#include "pipeline/report_page/page.h"

namespace vitrine::test {

struct OutputDesc {
  std::string photo = "b.jpg";  // name of the second photo: a held-out view
  double psnr = 30, train_psnr = 31, ssim = 0.95;
  int registered = 3;
  int points = 2000;      // of the sparse model, as reported
  int heldout_views = 2;  // as reported
  int exit = 0;
  std::string events = {};  // of the last run; empty: there is no events.jsonl
};

inline Image8 plain_picture(int width, int height, uint8_t level) { return Image8(width, height, 3, level); }

inline std::string stem_of(const std::string& name) { return fs::path(name).replace_extension().generic_string(); }

// A JSON string: enough for the names of the tests.
inline std::string quoted_json(const std::string& text) {
  std::string out = "\"";
  for (char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

inline void write_model(const fs::path& out, const std::vector<std::string>& names) {
  ColmapModel model;
  model.cameras.push_back(colmap_pinhole(1, {64, 48, 60, 60, 32, 24}));
  for (uint32_t i = 0; i < names.size(); ++i) {
    // Around the origin, at height 0.5, looking at it.
    const double a = 2.0 * i;
    const Vec3d centre{std::cos(a), std::sin(a), 0.5}, z = normalized(-centre), x = normalized(cross(z, Vec3d{0, 0, 1})),
                                                       y = cross(z, x);
    const Mat3d cam_from_world = transposed(Mat3d{x, y, z});
    ColmapImage image{.id = i + 1,
                      .rotation = quaternion(cam_from_world),
                      .translation = -(cam_from_world * centre),
                      .camera_id = 1,
                      .name = names[i],
                      .points = {{32, 24, 1}}};
    model.images.push_back(image);
  }
  ColmapPoint3D point{.id = 1, .position = {0, 0, 0}, .srgb = {200, 100, 50}, .error_px = 0.3, .track = {}};
  for (uint32_t i = 0; i < names.size(); ++i) point.track.push_back({i + 1, 0});
  model.points.push_back(point);
  make_folders(out / "sparse/0");
  write_colmap_model(out / "sparse/0", model, ColmapFormat::Binary);
  write_scene_info(out / "scene.json", {});
  Gains gains;
  for (const std::string& name : names) gains[name] = {1, 1, 1};
  make_folders(out / "sfm");
  write_gains(out / "sfm/gains.json", gains);
}

inline void write_output(const fs::path& out, const OutputDesc& d = {}) {
  const std::string second = quoted_json(d.photo);
  write_model(out, {"a.jpg", d.photo, "c.jpg"});
  const auto file = [&](const char* name, const std::string& text) {
    make_folders((out / name).parent_path());
    std::ofstream(out / name) << text;  // write_file would wait for the disk
  };
  file("run.json",
       fmt::format(R"({{"format": 1, "vitrine": "0.1.0", "exit": {}, "finished": "2026-01-02T03:04:05Z", "seconds": 12,
    "machine": {{"threads": 2}}, "stages": [
      {{"name": "sfm", "state": "ran", "summary": "registered", "seconds": 4, "cpu_seconds": 6, "peak_rss_bytes": 1000000, "warnings": []}},
      {{"name": "evaluate", "state": "{}", "summary": "", "seconds": 2, "cpu_seconds": 3, "peak_rss_bytes": 2000000,
        "warnings": ["few <views>"]}}],
    "options": {{"preset": {{"value": "preview"}}, "input.photos": {{"value": "my photos"}}, "input.masks": {{"value": ""}}}}}})",
                   d.exit, d.exit == 0 ? "ran" : "failed"));
  if (!d.events.empty()) file("events.jsonl", d.events);
  file("sfm/report.json", fmt::format(R"({{"photo_count": 3, "registered": {}, "points": {{"kept": {}}},{} "photos": [
      {{"name": "a.jpg", "features": 900, "verified_matches": 500, "observations": 400, "registered": true}},
      {{"name": {}, "features": 800, "verified_matches": 400, "observations": 350, "registered": true}},
      {{"name": "c.jpg", "features": 12, "verified_matches": 3, "observations": 0, "registered": {},
        "reason": "12 features & too few", "cause": "motion_blur"}}]}})",
                                      d.registered, d.points, d.points > 0 ? R"( "mean_reprojection_error_px": 0.4,)" : "",
                                      second, d.registered == 3));
  file("optimize/report.json", R"({"surfels": 60000, "iterations": 3000, "layers": {"diffuse": {"surfels": 60000}}})");
  file("optimize/views.json", fmt::format(R"({{"train": ["c.jpg"], "heldout": ["a.jpg", {}]}})", second));
  file("mesh/report.json",
       R"({"mesh": {"faces": 2, "components": 1, "edges": 500, "boundary_edges": 4, "self_intersections": 0}})");
  file("refine/report.json", R"({"glass": {"regions": [{"verdict": "untested"}, {"verdict": "thick", "psnr":
      {"straight": 13.1, "straight_without_layer": 12, "bent": 20, "bent_without_layer": 36.07}}]}})");
  file("decompose/report.json", R"({"baked_log_rms": 0.5, "misfit_log_rms": [0.4, 0.2]})");
  file("normals/report.json", R"({"source": "geometric", "photos": [{"known": 0.5}, {"known": 0.9}]})");
  file("eval/metrics.json",
       fmt::format(R"({{"heldout": {{"psnr": {}, "ssim": {}, "views": {}}}, "train": {{"psnr": {}, "ssim": 0.9, "views": 1}},
         "regions": {{"rest": {{"psnr": 28, "views": {}}}}}, "truth": {{"normal_mae_deg": 9.5}},
         "objects": [{{"id": 1, "name": "case <1>", "role": "thin_glass", "trust": "marked", "psnr": 24.3, "views": 2, "iou": 0.93}},
                     {{"id": 2, "name": "kettle", "role": "mirror", "trust": "given", "psnr": 21.7, "views": 2}}]}})",
                   d.psnr, d.ssim, d.heldout_views, d.train_psnr, d.heldout_views));
  std::string csv_name = "\"";
  for (char c : d.photo) csv_name += c == '"' ? std::string("\"\"") : std::string(1, c);
  file("eval/per_view.csv", "name,set,psnr,ssim,psnr_rest\na.jpg,heldout,29.5,0.94,28\n" + csv_name +
                                "\",heldout,30.5,0.96,28.5\nc.jpg,train,31,0.97,29\n");
  for (const std::string& name : {std::string("a.jpg"), d.photo})
    for (const auto& [what, level] : {std::pair("gt", 90), std::pair("pred", 100), std::pair("err", 10)}) {
      const fs::path path = out / "eval" / (stem_of(name) + "_" + what + ".png");
      make_folders(path.parent_path());
      write_ldr(path, plain_picture(64, 48, uint8_t(level)));
    }
  make_folders(out / "eval/layers/normal");
  write_exr(out / "eval/layers/normal/a.exr", {ImageF(8, 6, 3, 0.5f), {"X", "Y", "Z"}, {}});
  write_mesh_ply(out / "mesh/mesh.ply", {.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}},
                                         .normals = {},
                                         .colors = {},
                                         .faces = {{0, 1, 2}, {0, 2, 3}}});
  make_folders(out / "relit/studio");
  write_ldr(out / "relit/studio/a.png", plain_picture(64, 48, 120));
}

inline std::string page(const fs::path& out) { return report_page({.project = out, .typed = "out"}); }

}  // namespace vitrine::test
