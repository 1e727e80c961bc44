// Two balls side by side, seen from a ring of eight cameras: what each selector must find is known by construction. Ball A is the
// class "specular" in the masks and component 1 of the mesh, ball B component 2; each has something in it that only glass shows.
#pragma once

#include "core/scene/light/environment.h"
#include "core/render/picture/part_labels.h"
#include "core/render/picture/decomposed_materials.h"
#include "tests/support/tiny_capture.h"
#include "tests/support/written_objects.h"

namespace vitrine::test {

class TwoBalls {
 public:
  static constexpr size_t kSurfelsA = 900, kSurfelsB = 600, kHidden = 1, kSky = 3, kInside = 5;
  static constexpr double kRadiusA = 0.18, kRadiusB = 0.12;
  static inline const Vec3d kA{-0.22, 0, 0}, kB{0.24, 0, 0};

  TwoBalls() {
    layer = SplatLayer(LayerKind::Diffuse, 0, 0);
    append(layer, sphere_layer(kRadiusA, kSurfelsA), kA);
    append(layer, sphere_layer(kRadiusB, kSurfelsB), kB);
    append(layer, sphere_layer(0.001, kHidden), kA);        // nobody sees it
    append(layer, sphere_layer(3, kSky), Vec3d{0, 0, 40});  // the sky, far off
    materials.resize(layer.size());
    for (size_t i = 0; i < layer.size(); ++i) {
      const bool sky = i >= kSurfelsA + kSurfelsB + kHidden;
      materials.albedo[i] = sky ? Vec3f{} : Vec3f{0.6f, 0.5f, 0.4f};
      materials.f0[i] = sky ? Vec3f{} : Vec3f{0.04f, 0.04f, 0.04f};
      materials.roughness[i] = 0.5f;
      materials.specular_weight[i] = sky ? 0.f : 0.1f;
    }
    append(behind_glass, sphere_layer(0.03, kInside), kA);
    append(behind_glass, sphere_layer(0.03, kInside), kB);
    materials.albedo_behind_glass.assign(behind_glass.size(), Vec3f{0.6f, 0.5f, 0.4f});
    mesh = sphere_mesh(kRadiusA, kA, 24, 48);
    const TriMesh b = sphere_mesh(kRadiusB, kB, 12, 24);
    vertices_a = mesh.positions.size(), faces_a = mesh.faces.size();
    for (const auto& f : b.faces)
      mesh.faces.push_back({f[0] + uint32_t(vertices_a), f[1] + uint32_t(vertices_a), f[2] + uint32_t(vertices_a)});
    mesh.positions.insert(mesh.positions.end(), b.positions.begin(), b.positions.end());
    mesh.colors.assign(mesh.positions.size(), Vec3f{0.5f, 0.5f, 0.5f});

    write_decomposed_materials(decompose(), materials);
    write_environment(decomposed_environment_path(decompose()), Environment(ImageF(8, 4, 3, 1.f)));
    write_masks();
    const std::vector<LabelledView> labels = labelled_views(LabelledObjects::all(masks()), capture.views);
    assign_objects({}, labels, 0.01f, layer, behind_glass);
    mesh.object_ids = labels_of_vertices(mesh, labels);
    write_layer(capture.optimize() / "gaussians/diffuse.ply", layer);
    write_layer(capture.optimize() / "gaussians/transmittance.ply", behind_glass);
    write_mesh_ply(capture.mesh() / "mesh/mesh.ply", mesh);
  }

  fs::path decompose() const { return folder.path() / "decompose"; }
  fs::path masks() const { return folder.path() / "masks"; }
  std::map<std::string, fs::path> artifacts() const {
    return {{"sfm", capture.sfm()},   {"optimize", capture.optimize()},
            {"mesh", capture.mesh()}, {"decompose", decompose()},
            {"masks", masks()},       {"objects", masks()}};
  }
  bool in_a(size_t surfel) const { return surfel < kSurfelsA || surfel == kSurfelsA + kSurfelsB; }
  bool in_b(size_t surfel) const { return surfel >= kSurfelsA && surfel < kSurfelsA + kSurfelsB; }

  TinyCapture capture;
  SplatLayer layer, behind_glass{LayerKind::Transmittance, 0, 0};
  DecomposedMaterials materials;
  TriMesh mesh;
  size_t vertices_a = 0, faces_a = 0;

 private:
  static void append(SplatLayer& to, const SplatLayer& more, const Vec3d& by) {
    const size_t first = to.size();
    to.resize(first + more.size());
    for (size_t i = 0; i < more.size(); ++i) {
      for (const AttributeRow& r : kAttributes)
        for (size_t c = 0; c < to.width(r.id); ++c) to.at(r.id, first + i)[c] = more.at(r.id, i)[c];
      for (size_t c = 0; c < 3; ++c) to.at(Attribute::Mean, first + i)[c] += float(by[c]);
    }
  }
  static double hit(const Vec3d& eye, const Vec3d& direction, const Vec3d& centre, double radius) {
    const Vec3d d = normalized(direction), o = eye - centre;
    const double b = dot(o, d), root = b * b - dot(o, o) + radius * radius;
    return root < 0 ? 1e9 : -b - std::sqrt(root);
  }
  void write_masks() const {
    make_folders(masks() / "masks/specular");
    for (const View& v : capture.views) {
      Image8 mask(v.intrinsics.width, v.intrinsics.height, 1);
      const Rigid world_from_cam = inverse(v.cam_from_world);
      for (int y = 0; y < mask.height(); ++y)
        for (int x = 0; x < mask.width(); ++x) {
          const Vec3d ray = world_from_cam.rotation * v.intrinsics.ray(x + 0.5, y + 0.5), eye = world_from_cam.translation;
          const double a = hit(eye, ray, kA, kRadiusA), b = hit(eye, ray, kB, kRadiusB);
          mask.at(x, y) = a < 1e8 && a < b ? 255 : 0;
        }
      write_ldr(masks() / "masks/specular" / (v.stem() + ".png"), mask);
    }
    write_objects_artifact(masks(), masks(), capture.views);
  }
  TemporaryFolder folder;
};

}  // namespace vitrine::test
