// A floor of coloured tiles and an upright glass pane on it, as surfels and as a mesh: small enough to bake in milliseconds, and
// every number of the exported files is known beforehand.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/foundation/base/file.h"
#include "core/foundation/math/rigid.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/surfels/activation.h"
#include "core/scene/surfels/splat_scene.h"

namespace vitrine::test {

inline constexpr float kPaneTransmission = 0.9f, kPaneSpecular = 0.05f, kPaneF0 = 0.05f, kPaneRoughness = 0.1f;

inline Vec3f tile_color(float x, float y) {
  return (int(std::floor(2 * x)) + int(std::floor(2 * y))) % 2 == 0 ? Vec3f{0.8f, 0.2f, 0.1f} : Vec3f{0.1f, 0.3f, 0.7f};
}

// A square of n x n points spanned by two axes; visit(point, u, v) with u, v in [-1, 1].
template <class Visit>
void for_grid(int n, const Vec3f& centre, const Vec3f& a, const Vec3f& b, Visit&& visit) {
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const float u = 2 * (float(i) + 0.5f) / float(n) - 1, v = 2 * (float(j) + 0.5f) / float(n) - 1;
      visit(centre + u * a + v * b, u, v);
    }
}

struct PaneScene {
  SplatLayer diffuse{LayerKind::Diffuse, 1, 0}, reflection{LayerKind::Reflection, 0, 1},
      transmittance{LayerKind::Transmittance, 0, 1};
  TriMesh mesh;
  size_t floor_faces = 0;

  PaneScene() {
    add_square(40, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, false);
    floor_faces = mesh.faces.size();
    add_square(20, {0, 0, 0.5f}, {0, 0.4f, 0}, {0, 0, 0.4f}, true);
    for (Attribute a : {Attribute::LogScale, Attribute::Opacity})
      for (SplatLayer* layer : {&reflection, &transmittance})
        for (float& v : layer->values(a)) v = -4;
    for (SplatLayer* layer : {&reflection, &transmittance}) *layer->at(Attribute::Rotation, 0) = 1;
  }

  // The folders of sfm, optimize and mesh artifacts below `root`.
  void write(const fs::path& root) const {
    make_folders(root / "optimize/gaussians");
    make_folders(root / "mesh/mesh");
    make_folders(root / "sfm");
    write_layer(root / "optimize/gaussians/diffuse.ply", diffuse);
    write_layer(root / "optimize/gaussians/reflection.ply", reflection);
    write_layer(root / "optimize/gaussians/transmittance.ply", transmittance);
    write_mesh_ply(root / "mesh/mesh/mesh.ply", mesh);
    write_scene_info(root / "sfm/scene.json", {});
  }

 private:
  void add_square(int n, const Vec3f& centre, const Vec3f& a, const Vec3f& b, bool glass) {
    const Vec3f normal = normalized(cross(a, b));
    const Quatf turn = quaternion(Mat3f{normalized(a), normalized(b), normal});
    for_grid(n, centre, a, b, [&](const Vec3f& p, float, float) {
      const size_t i = diffuse.size();
      diffuse.resize(i + 1);
      for (size_t c = 0; c < 3; ++c) diffuse.at(Attribute::Mean, i)[c] = p[c];
      float* q = diffuse.at(Attribute::Rotation, i);
      q[0] = turn.w, q[1] = turn.x, q[2] = turn.y, q[3] = turn.z;
      for (size_t c = 0; c < 2; ++c) diffuse.at(Attribute::LogScale, i)[c] = std::log(length(a) / float(n));
      *diffuse.at(Attribute::Opacity, i) = logit(0.95f);
      const Vec3f color = glass ? Vec3f{0.02f, 0.02f, 0.02f} : tile_color(p.x, p.y);
      for (size_t c = 0; c < 3; ++c) {
        diffuse.at(Attribute::ShDc, i)[c] = (color[c] - 0.5f) / kShDc;
        diffuse.at(Attribute::F0, i)[c] = logit(kPaneF0);
      }
      *diffuse.at(Attribute::Roughness, i) = logit(kPaneRoughness);
      *diffuse.at(Attribute::SpecularWeight, i) = logit(glass ? kPaneSpecular : 0.002f);
      *diffuse.at(Attribute::Transmission, i) = logit(glass ? kPaneTransmission : 0.002f);
    });
    const auto first = uint32_t(mesh.positions.size()), side = uint32_t(n + 1);
    for (uint32_t j = 0; j < side; ++j)
      for (uint32_t i = 0; i < side; ++i) {
        mesh.positions.push_back(centre + (2 * float(i) / float(n) - 1) * a + (2 * float(j) / float(n) - 1) * b);
        mesh.normals.push_back(normal);
        mesh.colors.push_back({0.5f, 0.5f, 0.5f});
      }
    for (uint32_t j = 0; j + 1 < side; ++j)
      for (uint32_t i = 0; i + 1 < side; ++i) {
        const uint32_t v = first + j * side + i;
        mesh.faces.push_back({v, v + 1, v + side});
        mesh.faces.push_back({v + 1, v + side + 1, v + side});
      }
  }
};

}  // namespace vitrine::test
