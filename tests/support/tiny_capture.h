// A capture small enough for tests with everything an evaluation reads, made by rendering surfels on a sphere, and its truth
// in another frame. What evaluate says about it can be computed by hand.
#pragma once

#include <cmath>
#include <numbers>

#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/render/raster/renderer.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/surfels/splat_scene.h"
#include "tests/support/spheres.h"

namespace vitrine::test {

class TinyCapture {
 public:
  static constexpr int kWidth = 64, kHeight = 48;
  static constexpr double kRadius = 0.4;

  TinyCapture() {
    make_folders(sfm() / "sparse/0");
    make_folders(sfm() / "linear");
    make_folders(sfm() / "sfm");
    make_folders(optimize() / "gaussians");
    make_folders(optimize() / "optimize");
    make_folders(mesh() / "mesh");
    const Intrinsics k{kWidth, kHeight, 70, 70, kWidth / 2.0, kHeight / 2.0};
    ColmapModel model;
    model.cameras.push_back(colmap_pinhole(1, k));
    Gains gains;
    for (int i = 0; i < 8; ++i) {
      const double a = 2 * std::numbers::pi * i / 8;
      View v;
      v.name = "view_" + std::to_string(i) + ".png";
      v.intrinsics = k;
      v.cam_from_world = looking_at({std::cos(a), std::sin(a), 0.2 + 0.05 * i}, {0, 0, 0});
      v.gain = {1.1 - 0.02 * i, 1, 0.9};
      gains[v.name] = v.gain;
      ColmapImage image;
      image.id = uint32_t(i + 1);
      image.rotation = quaternion(v.cam_from_world.rotation);
      image.translation = v.cam_from_world.translation;
      image.camera_id = 1;
      image.name = v.name;
      model.images.push_back(image);
      views.push_back(v);
    }
    write_colmap_model(sfm() / "sparse/0", model, ColmapFormat::Binary);
    write_gains(sfm() / "sfm/gains.json", gains);
    write_scene_info(sfm() / "scene.json", SceneInfo{});
    layer = sphere_layer(kRadius);
    write_layer(optimize() / "gaussians/diffuse.ply", layer);
    write_split({0}, {1, 2, 3, 4, 5, 6, 7});
    write_mesh_ply(mesh() / "mesh/mesh.ply", sphere_mesh(kRadius));
    // The reference renderer is slow and every capture is the same: one set of photos serves the whole run.
    static const std::vector<ImageF> photos = [&] {
      std::vector<ImageF> made;
      for (const View& v : views) made.push_back(photo(v));
      return made;
    }();
    for (size_t i = 0; i < views.size(); ++i) write_exr_rgb(linear_image_path(sfm(), views[i]), photos[i], ExrPrecision::Float);
  }

  // The scene through the reference renderer, times the gain.
  ImageF photo(const View& v) const {
    RasterDesc desc;
    desc.intrinsics = v.intrinsics;
    desc.cam_from_world = v.cam_from_world;
    desc.sh_degree = 0;
    RasterImages images;
    make_renderer(Backend::Reference)->forward(layer, desc, images);
    ImageF out(kWidth, kHeight, 3);
    for (size_t i = 0; i < out.pixel_count(); ++i)
      for (size_t c = 0; c < 3; ++c)
        out.data()[3 * i + c] = float(v.gain[c]) * images.plane(Aov::Color)[c * out.pixel_count() + i];
    return out;
  }

  void write_split(const std::vector<int>& heldout, const std::vector<int>& train, bool object_alone = false) const {
    nlohmann::json j{{"holdout_every", 8},
                     {"max_side", 0},
                     {"object_alone", object_alone},
                     {"train", nlohmann::json::array()},
                     {"heldout", nlohmann::json::array()}};
    for (int i : heldout) j["heldout"].push_back(views[size_t(i)].name);
    for (int i : train) j["train"].push_back(views[size_t(i)].name);
    write_file(optimize() / "optimize/views.json", j.dump());
  }

  // The analytic sphere in the truth's frame: cameras, depth, normals, mesh. Maps are `finer` times the photo's size.
  void write_truth(int finer = 2) const {
    std::vector<View> cameras = views;
    for (View& v : cameras) v.cam_from_world = transformed_world(v.cam_from_world, truth_from_ours);
    make_folders(truth() / "depth");
    make_folders(truth() / "normal");
    write_transforms_json(truth() / "transforms.json", cameras, "../photos");
    const Vec3d centre = truth_from_ours * Vec3d{};
    const double radius = truth_from_ours.scale * kRadius;
    for (const View& v : cameras) {
      const Intrinsics k = v.intrinsics.scaled_to(kWidth * finer, kHeight * finer);
      ExrImage depth{ImageF(k.width, k.height, 1), {"Z"}, {}}, normal{ImageF(k.width, k.height, 3), {"X", "Y", "Z"}, {}};
      const Rigid world_from_cam = inverse(v.cam_from_world);
      for (int y = 0; y < k.height; ++y)
        for (int x = 0; x < k.width; ++x) {
          const Vec3d d = world_from_cam.rotation * k.ray(x + 0.5, y + 0.5), o = world_from_cam.translation - centre;
          const double a = dot(d, d), b = dot(o, d), c = dot(o, o) - radius * radius, disc = b * b - a * c;
          if (disc < 0) continue;
          const double z = (-b - std::sqrt(disc)) / a;  // d has camera z = 1
          depth.pixels.at(x, y) = float(z);
          const Vec3d n = (o + z * d) / radius;
          for (size_t i = 0; i < 3; ++i) normal.pixels.at(x, y, int(i)) = float(n[i]);
        }
      write_exr(truth() / "depth" / (v.stem() + ".exr"), depth, ExrPrecision::Float);
      write_exr(truth() / "normal" / (v.stem() + ".exr"), normal, ExrPrecision::Float);
    }
    write_mesh_ply(truth() / "mesh.ply", sphere_mesh(radius, centre, 48, 96));
  }

  // A mask at photo size: columns [x0, x1) belong to the class.
  void write_mask(const std::string& kind, const View& v, int x0, int x1) const {
    make_folders(truth() / "mask" / kind);
    Image8 mask(kWidth, kHeight, 1);
    for (int y = 0; y < kHeight; ++y)
      for (int x = x0; x < x1; ++x) mask.at(x, y) = 255;
    write_ldr(truth() / "mask" / kind / (v.stem() + ".png"), mask);
  }

  fs::path sfm() const { return root_.path() / "sfm"; }
  fs::path optimize() const { return root_.path() / "optimize"; }
  fs::path mesh() const { return root_.path() / "mesh"; }
  fs::path truth() const { return root_.path() / "truth"; }
  std::map<std::string, fs::path> inputs(bool with_truth) const {
    std::map<std::string, fs::path> in{{"sfm", sfm()}, {"optimize", optimize()}, {"mesh", mesh()}};
    if (with_truth) in["truth"] = truth();
    return in;
  }

  std::vector<View> views;
  SplatLayer layer;
  Similarity truth_from_ours{1.7, rotation_matrix(normalized(Quatd{1, 0.3, -0.2, 0.5})), {0.4, -2, 1}};

 private:
  TemporaryFolder root_;
};

}  // namespace vitrine::test
