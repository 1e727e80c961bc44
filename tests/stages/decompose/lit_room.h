// A capture whose albedo and light are known: a table in patches of four paints and a box on it, under a sky that is bright on
// one side; or the same under a known case of clear glass, which the box is seen through. Radiances come from an integration of
// its own (many cosine-weighted rays, one bounce), not from the stage's code.
#pragma once

#include <cmath>
#include <functional>
#include <numbers>

#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/render/model/kernels/fresnel.h"
#include "core/render/picture/trained_scene.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/exr.h"
#include "core/scene/mesh/mesh_hits.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/surfels/activation.h"
#include "core/scene/surfels/splat_scene.h"

namespace vitrine::test {

class LitRoom {
 public:
  // `cased`: the box stands in a case of glass.
  explicit LitRoom(bool cased = false) : cased_(cased) {
    for (const char* f : {"sparse/0", "linear", "sfm", "gaussians", "optimize", "mesh"}) make_folders(folder() / f);
    constexpr float kCell = 0.04f;
    add_sheet({-0.5f, -0.5f, 0}, {1, 0, 0}, {0, 1, 0}, 25, 25, kCell);
    const auto add_block = [&](float x, float y, float half, float top) {
      const int across = int(std::lround(2 * half / kCell)), up = int(std::lround(top / kCell));
      const float left = x - half, right = x + half, front = y - half, back = y + half;
      add_sheet({left, front, top}, {1, 0, 0}, {0, 1, 0}, across, across, kCell);
      add_sheet({left, front, 0}, {1, 0, 0}, {0, 0, 1}, across, up, kCell);   // normal -y
      add_sheet({right, front, 0}, {0, 1, 0}, {0, 0, 1}, across, up, kCell);  // +x
      add_sheet({right, back, 0}, {-1, 0, 0}, {0, 0, 1}, across, up, kCell);  // +y
      add_sheet({left, back, 0}, {0, -1, 0}, {0, 0, 1}, across, up, kCell);   // -x
    };
    if (cased_) add_block(kPost, kPost, kPostHalf, 0.24f);  // seen directly, sides that tell the light from low
    const size_t first_vertices = mesh.positions.size(), first_faces = mesh.faces.size();
    add_block(0, 0, 0.12f, 0.24f);
    light_up();
    if (cased_) put_case(first_vertices, first_faces);
    write();
    if (cased_) write_case();
  }

  static Vec3f sky(const Vec3f& d) {
    if (d.z < 0) return {};
    const float lamp = std::max(0.f, dot(d, normalized(Vec3f{0.7f, 0.3f, 0.65f})));
    const float bright = 0.15f + 2.5f * lamp * lamp * lamp * lamp * lamp * lamp;
    return {bright, bright, bright};
  }

  fs::path folder() const { return root_.path(); }
  std::map<std::string, fs::path> inputs() const { return {{"sfm", folder()}, {"optimize", folder()}, {"mesh", folder()}}; }

  TriMesh mesh;                                             // opaque
  std::vector<Vec3f> positions, normals, albedo, radiance;  // per opaque surfel
  std::vector<View> views;
  // Whether a surfel is seen through the glass alone.
  bool behind_glass(size_t i) const {
    return cased_ && std::max(std::abs(positions[i].x), std::abs(positions[i].y)) < kCase && positions[i].z < kCaseTop;
  }

 private:
  static constexpr float kCase = 0.2f, kCaseTop = 0.32f;  // half its width, and its height above the table
  static constexpr float kPost = -0.36f, kPostHalf = 0.08f;

  static Vec3f paint(const Vec3f& p) {
    constexpr Vec3f kPaints[4] = {{0.7f, 0.68f, 0.62f}, {0.55f, 0.2f, 0.15f}, {0.15f, 0.3f, 0.5f}, {0.25f, 0.4f, 0.2f}};
    const auto at = [](float x) { return static_cast<int>(std::floor(x / 0.12f + 100)); };
    return kPaints[size_t(at(p.x) + 2 * at(p.y) + at(p.z)) % 4];
  }

  static void add_grid(TriMesh& to, const Vec3f& corner, const Vec3f& u, const Vec3f& v, int nu, int nv, float cell) {
    const auto first = uint32_t(to.positions.size());
    for (int j = 0; j <= nv; ++j)
      for (int i = 0; i <= nu; ++i) to.positions.push_back(corner + cell * (float(i) * u + float(j) * v));
    const auto row = uint32_t(nu + 1);
    for (uint32_t j = 0; j < uint32_t(nv); ++j)
      for (uint32_t i = 0; i < uint32_t(nu); ++i) {
        const uint32_t a = first + j * row + i;
        to.faces.push_back({a, a + 1, a + row + 1});
        to.faces.push_back({a, a + row + 1, a + row});
      }
  }

  void add_sheet(const Vec3f& corner, const Vec3f& u, const Vec3f& v, int nu, int nv, float cell) {
    add_grid(mesh, corner, u, v, nu, nv, cell);
    for (int j = 0; j < 2 * nv; ++j)
      for (int i = 0; i < 2 * nu; ++i) {
        const Vec3f p = corner + cell * ((float(i) + 0.5f) / 2 * u + (float(j) + 0.5f) / 2 * v), n = cross(u, v);
        if (p.z == 0 && std::abs(p.x) < 0.12f && std::abs(p.y) < 0.12f) continue;  // the box stands there
        if (cased_ && p.z == 0 && std::abs(p.x - kPost) < kPostHalf && std::abs(p.y - kPost) < kPostHalf) continue;
        positions.push_back(p);
        normals.push_back(n);
        albedo.push_back(paint(p - 1e-3f * n));
      }
  }

  // What the panes of the case let through of a ray, up to `far`.
  float through_case(const Vec3f& o, const Vec3f& d, float far) const {
    if (!cased_) return 1;
    const Vec3f low{-kCase, -kCase, -1}, high{kCase, kCase, kCaseTop};
    float in = -MeshHits::kFar, out = MeshHits::kFar, rise_in = 0, rise_out = 0;
    for (size_t c = 0; c < 3; ++c) {
      const float a = (low[c] - o[c]) / d[c], b = (high[c] - o[c]) / d[c];
      if (std::min(a, b) > in) in = std::min(a, b), rise_in = std::abs(d[c]);
      if (std::max(a, b) < out) out = std::max(a, b), rise_out = std::abs(d[c]);
    }
    if (in >= out) return 1;
    const auto pane = [&](float t, float rise) {
      return t > 0 && t < far ? (1 - float(kPaneReflectance)) * (1 - sheet_grazing(rise).value) : 1.f;
    };
    return pane(in, rise_in) * pane(out, rise_out);
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
    const auto direct = [&](const Vec3f& o, const Vec3f& d) {
      return hits.occluded(o, d, 0, MeshHits::kFar) ? Vec3f{} : through_case(o, d, MeshHits::kFar) * sky(d);
    };
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
        return hit ? through_case(o, d, hit->t) * first[mesh.faces[hit->face][0]] : through_case(o, d, MeshHits::kFar) * sky(d);
      };
      radiance[i] = 1 / kPi * hadamard(albedo[i], gathered(positions[i], normals[i], 192, 100000 + i, with_bounce));
    });
    mesh.colors = first;
    mesh.normals = vertex_normals;
  }

  // Surfels by index: opaque ones, then those of glass.
  SplatLayer surfels(LayerKind kind, const std::vector<size_t>& which, const std::vector<Vec3f>& positions,
                     const std::vector<Vec3f>& normals, const std::vector<Vec3f>& radiance, float clear) const {
    SplatLayer layer(kind, 0, which.size());
    for (size_t k = 0; k < which.size(); ++k) {
      const size_t i = which[k];
      const Vec3d n = cast<double>(normals[i]), u = normalized(cross(n, std::abs(n.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
      const Quatd q = quaternion(Mat3d{u, cross(n, u), n});
      const double rotation[4] = {q.w, q.x, q.y, q.z};
      for (size_t c = 0; c < 3; ++c) {
        layer.at(Attribute::Mean, k)[c] = positions[i][c];
        layer.at(Attribute::ShDc, k)[c] = (radiance[i][c] - 0.5f) / kShDc;
      }
      for (size_t c = 0; c < 4; ++c) layer.at(Attribute::Rotation, k)[c] = float(rotation[c]);
      for (size_t c = 0; c < 2; ++c) layer.at(Attribute::LogScale, k)[c] = std::log(0.011f);
      *layer.at(Attribute::Opacity, k) = logit(0.97f);
      if (kind != LayerKind::Diffuse) continue;
      for (size_t c = 0; c < 3; ++c) layer.at(Attribute::F0, k)[c] = logit(0.04f);
      *layer.at(Attribute::SpecularWeight, k) = logit(0.02f);
      *layer.at(Attribute::Transmission, k) = logit(clear);
    }
    return layer;
  }

  // The mesh is that of first surfaces: the box, which was added last, is in another.
  void put_case(size_t first_vertices, size_t first_faces) {
    content_ = mesh;
    content_.faces.erase(content_.faces.begin(), content_.faces.begin() + static_cast<ptrdiff_t>(first_faces));
    for (auto* values : {&content_.positions, &content_.normals, &content_.colors})
      values->erase(values->begin(), values->begin() + static_cast<ptrdiff_t>(first_vertices));
    for (auto& face : content_.faces)
      for (uint32_t& v : face) v -= uint32_t(first_vertices);
    mesh.faces.resize(first_faces);
    for (auto* values : {&mesh.positions, &mesh.normals, &mesh.colors}) values->resize(first_vertices);
    constexpr int kCells = 10;
    constexpr float kCell = 2 * kCase / float(kCells);
    const auto pane = [&](const Vec3f& corner, const Vec3f& u, const Vec3f& v, int nv) {
      add_grid(mesh, corner, u, v, kCells, nv, kCell);
      mesh.normals.resize(mesh.positions.size(), cross(u, v));
      for (int j = 0; j < 2 * nv; ++j)
        for (int i = 0; i < 2 * kCells; ++i) {
          pane_positions_.push_back(corner + kCell * ((float(i) + 0.5f) / 2 * u + (float(j) + 0.5f) / 2 * v));
          pane_normals_.push_back(cross(u, v));
        }
    };
    constexpr int kUp = 8;
    pane({-kCase, -kCase, kCaseTop}, {1, 0, 0}, {0, 1, 0}, kCells);
    pane({-kCase, -kCase, 0}, {1, 0, 0}, {0, 0, 1}, kUp);
    pane({kCase, -kCase, 0}, {0, 1, 0}, {0, 0, 1}, kUp);
    pane({kCase, kCase, 0}, {-1, 0, 0}, {0, 0, 1}, kUp);
    pane({-kCase, kCase, 0}, {0, -1, 0}, {0, 0, 1}, kUp);
    mesh.colors.resize(mesh.positions.size(), Vec3f{0.2f, 0.2f, 0.2f});
  }

  // What is seen through the case alone is in the transmittance layer; its panes are surfels for other programs, and known.
  void write_case() const {
    std::vector<size_t> inside, panes(pane_positions_.size());
    for (size_t i = 0; i < positions.size(); ++i)
      if (behind_glass(i)) inside.push_back(i);
    write_layer(folder() / "gaussians/transmittance.ply",
                surfels(LayerKind::Transmittance, inside, positions, normals, radiance, 0));
    for (size_t i = 0; i < panes.size(); ++i) panes[i] = i;
    const SplatLayer glass = surfels(LayerKind::Diffuse, panes, pane_positions_, pane_normals_,
                                     std::vector<Vec3f>(panes.size(), Vec3f{0.1f, 0.1f, 0.1f}), 0.97f);
    SplatLayer diffuse = read_layer(folder() / "gaussians/diffuse.ply");
    const size_t first = diffuse.size();
    diffuse.resize(first + glass.size());
    for (const AttributeRow& r : kAttributes)
      std::ranges::copy(glass.values(r.id), diffuse.values(r.id).begin() + static_cast<ptrdiff_t>(first * diffuse.width(r.id)));
    write_layer(folder() / "gaussians/diffuse.ply", diffuse);
    write_mesh_ply(folder() / "mesh/behind_glass.ply", content_);
    ImageOptions image;
    image.transmission.glass = Glass::Thin;
    const Box box{Mat3d::identity(), {-kCase, -kCase, -0.01}, {kCase, kCase, kCaseTop}};
    image.shape.set = std::make_shared<ShapeSet>(ShapeSet{{{box, ShapeRole::Sheet, 0.01, -1, {}}}});
    write_image_options(folder() / "optimize/model.json", image);
  }

  void write() {
    std::vector<size_t> shown;
    for (size_t i = 0; i < positions.size(); ++i)
      if (!behind_glass(i)) shown.push_back(i);
    write_layer(folder() / "gaussians/diffuse.ply", surfels(LayerKind::Diffuse, shown, positions, normals, radiance, 0.02f));
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

  const bool cased_;
  TriMesh content_;
  std::vector<Vec3f> pane_positions_, pane_normals_;
  TemporaryFolder root_;
};

}  // namespace vitrine::test
