// A capture whose albedo and light are known: a table in patches of four paints and a box on it, under a sky that is bright on
// one side. Radiances come from an integration of its own (many cosine-weighted rays, one bounce), not from the stage's code.
#pragma once

#include <cmath>
#include <functional>
#include <numbers>

#include "core/base/file.h"
#include "core/base/json.h"
#include "core/base/parallel.h"
#include "core/base/rng.h"
#include "core/camera/scene_info.h"
#include "core/camera/view_set.h"
#include "core/image/exr.h"
#include "core/mesh/mesh_io.h"
#include "core/scene/activation.h"
#include "core/scene/scene_io.h"
#include "core/trace/mesh_hits.h"

namespace vitrine::test {

class LitRoom {
 public:
  LitRoom() {
    for (const char* f : {"sparse/0", "linear", "sfm", "gaussians", "optimize", "mesh"}) make_folders(folder() / f);
    constexpr float kCell = 0.04f;
    add_sheet({-0.5f, -0.5f, 0}, {1, 0, 0}, {0, 1, 0}, 25, 25, kCell);
    const float low = -0.12f, high = 0.12f, top = 0.24f;
    add_sheet({low, low, top}, {1, 0, 0}, {0, 1, 0}, 6, 6, kCell);
    add_sheet({low, low, 0}, {1, 0, 0}, {0, 0, 1}, 6, 6, kCell);     // normal -y
    add_sheet({high, low, 0}, {0, 1, 0}, {0, 0, 1}, 6, 6, kCell);    // +x
    add_sheet({high, high, 0}, {-1, 0, 0}, {0, 0, 1}, 6, 6, kCell);  // +y
    add_sheet({low, high, 0}, {0, -1, 0}, {0, 0, 1}, 6, 6, kCell);   // -x
    light_up();
    write();
  }

  static Vec3f sky(const Vec3f& d) {
    if (d.z < 0) return {};
    const float lamp = std::max(0.f, dot(d, normalized(Vec3f{0.7f, 0.3f, 0.65f})));
    const float bright = 0.15f + 2.5f * lamp * lamp * lamp * lamp * lamp * lamp;
    return {bright, bright, bright};
  }

  fs::path folder() const { return root_.path(); }
  std::map<std::string, fs::path> inputs() const { return {{"sfm", folder()}, {"optimize", folder()}, {"mesh", folder()}}; }

  TriMesh mesh;
  std::vector<Vec3f> positions, normals, albedo, radiance;  // per surfel
  std::vector<View> views;

 private:
  static Vec3f paint(const Vec3f& p) {
    constexpr Vec3f kPaints[4] = {{0.7f, 0.68f, 0.62f}, {0.55f, 0.2f, 0.15f}, {0.15f, 0.3f, 0.5f}, {0.25f, 0.4f, 0.2f}};
    const auto at = [](float x) { return static_cast<int>(std::floor(x / 0.12f + 100)); };
    return kPaints[size_t(at(p.x) + 2 * at(p.y) + at(p.z)) % 4];
  }

  void add_sheet(const Vec3f& corner, const Vec3f& u, const Vec3f& v, int nu, int nv, float cell) {
    const auto first = uint32_t(mesh.positions.size());
    for (int j = 0; j <= nv; ++j)
      for (int i = 0; i <= nu; ++i) mesh.positions.push_back(corner + cell * (float(i) * u + float(j) * v));
    const auto row = uint32_t(nu + 1);
    for (uint32_t j = 0; j < uint32_t(nv); ++j)
      for (uint32_t i = 0; i < uint32_t(nu); ++i) {
        const uint32_t a = first + j * row + i;
        mesh.faces.push_back({a, a + 1, a + row + 1});
        mesh.faces.push_back({a, a + row + 1, a + row});
      }
    for (int j = 0; j < 2 * nv; ++j)
      for (int i = 0; i < 2 * nu; ++i) {
        const Vec3f p = corner + cell * ((float(i) + 0.5f) / 2 * u + (float(j) + 0.5f) / 2 * v), n = cross(u, v);
        if (p.z == 0 && std::abs(p.x) < 0.12f && std::abs(p.y) < 0.12f) continue;  // the box stands there
        positions.push_back(p);
        normals.push_back(n);
        albedo.push_back(paint(p - 1e-3f * n));
      }
  }

  // Mean of `of` over cosine-weighted directions, times pi.
  template <class F>
  static Vec3f gathered(const Vec3f& p, const Vec3f& n, int rays, uint64_t stream, const F& of) {
    const Vec3f t = normalized(cross(n, std::abs(n.x) < 0.9f ? Vec3f{1, 0, 0} : Vec3f{0, 1, 0})), b = cross(n, t);
    Rng rng(77, stream);
    Vec3f sum{};
    for (int r = 0; r < rays; ++r) {
      const float z2 = rng.uniform(), phi = 2 * std::numbers::pi_v<float> * rng.uniform(), s = std::sqrt(1 - z2);
      sum += of(p + 1e-3f * n, s * std::cos(phi) * t + s * std::sin(phi) * b + std::sqrt(z2) * n);
    }
    return (std::numbers::pi_v<float> / float(rays)) * sum;
  }

  void light_up() {
    const MeshHits hits(mesh);
    const auto direct = [&](const Vec3f& o, const Vec3f& d) { return hits.occluded(o, d, 0, MeshHits::kFar) ? Vec3f{} : sky(d); };
    std::vector<Vec3f> first(mesh.positions.size());  // radiance of the mesh without bounces
    std::vector<Vec3f> vertex_normals(mesh.positions.size());
    for (const auto& f : mesh.faces) {
      const Vec3f n = normalized(cross(mesh.positions[f[1]] - mesh.positions[f[0]], mesh.positions[f[2]] - mesh.positions[f[0]]));
      for (const uint32_t v : f) vertex_normals[v] = n;
    }
    constexpr float kPi = std::numbers::pi_v<float>;
    parallel_for(first.size(), 16, [&](size_t v) {
      const Vec3f n = vertex_normals[v], p = mesh.positions[v];
      first[v] = 1 / kPi * hadamard(paint(p - 1e-3f * n), gathered(p, n, 96, v, direct));
    });
    radiance.resize(positions.size());
    parallel_for(positions.size(), 16, [&](size_t i) {
      const auto with_bounce = [&](const Vec3f& o, const Vec3f& d) -> Vec3f {
        const auto hit = hits.first_hit(o, d);
        return hit ? first[mesh.faces[hit->face][0]] : sky(d);
      };
      radiance[i] = 1 / kPi * hadamard(albedo[i], gathered(positions[i], normals[i], 192, 100000 + i, with_bounce));
    });
    mesh.colors = first;
    mesh.normals = vertex_normals;
  }

  void write() {
    SplatLayer layer(LayerKind::Diffuse, 0, positions.size());
    for (size_t i = 0; i < positions.size(); ++i) {
      const Vec3d n = cast<double>(normals[i]), u = normalized(cross(n, std::abs(n.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
      const Quatd q = quaternion(Mat3d{u, cross(n, u), n});
      const double rotation[4] = {q.w, q.x, q.y, q.z};
      for (size_t c = 0; c < 3; ++c) {
        layer.at(Attribute::Mean, i)[c] = positions[i][c];
        layer.at(Attribute::ShDc, i)[c] = (radiance[i][c] - 0.5f) / kShDc;
        layer.at(Attribute::F0, i)[c] = logit(0.04f);
      }
      for (size_t c = 0; c < 4; ++c) layer.at(Attribute::Rotation, i)[c] = float(rotation[c]);
      for (size_t c = 0; c < 2; ++c) layer.at(Attribute::LogScale, i)[c] = std::log(0.011f);
      *layer.at(Attribute::Opacity, i) = logit(0.97f);
      *layer.at(Attribute::SpecularWeight, i) = logit(0.02f);
      *layer.at(Attribute::Transmission, i) = logit(0.02f);
    }
    write_layer(folder() / "gaussians/diffuse.ply", layer);
    write_mesh_ply(folder() / "mesh/mesh.ply", mesh);
    const Intrinsics k{112, 84, 110, 110, 56, 42};
    ColmapModel model;
    model.cameras.push_back(colmap_pinhole(1, k));
    Gains gains;
    nlohmann::json names = nlohmann::json::array();
    for (int i = 0; i < 8; ++i) {
      const double a = 2 * std::numbers::pi * i / 8;
      View v;
      v.name = "view_" + std::to_string(i) + ".png";
      v.intrinsics = k;
      const Vec3d eye{1.1 * std::cos(a), 1.1 * std::sin(a), i % 2 ? 0.5 : 0.9}, forward = normalized(Vec3d{0, 0, 0.05} - eye);
      const Vec3d right = normalized(cross(forward, Vec3d{0, 0, 1}));
      v.cam_from_world = inverse(Rigid{Mat3d{right, cross(forward, right), forward}, eye});
      model.images.push_back(
          {uint32_t(i + 1), quaternion(v.cam_from_world.rotation), v.cam_from_world.translation, 1, v.name, {}});
      gains[v.name] = {1, 1, 1};
      names.push_back(v.name);
      write_exr_rgb(linear_image_path(folder(), v), ImageF(k.width, k.height, 3, 0.3f));
      views.push_back(v);
    }
    write_colmap_model(folder() / "sparse/0", model, ColmapFormat::Binary);
    write_gains(folder() / "sfm/gains.json", gains);
    write_scene_info(folder() / "scene.json", SceneInfo{});
    write_file(
        folder() / "optimize/views.json",
        nlohmann::json{{"train", names}, {"heldout", nlohmann::json::array()}, {"holdout_every", 0}, {"max_side", 0}}.dump());
  }

  TemporaryFolder root_;
};

}  // namespace vitrine::test
