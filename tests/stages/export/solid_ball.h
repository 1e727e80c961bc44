// The floor and the pane of pane_scene.h and a ball of solid glass beside the pane.
#pragma once

#include "core/render/model/thick_glass.h"
#include "core/render/picture/trained_scene.h"
#include "tests/core/scene/mesh/shapes.h"
#include "tests/stages/export/pane_scene.h"
#include "tests/support/spheres.h"

namespace vitrine::test {

struct SolidBallScene : PaneScene {
  static constexpr float kRadius = 0.2f, kIor = 1.33f;
  static inline const Vec3f kCentre{0.55f, 0, 0.3f};
  size_t ball_faces = 0;

  SolidBallScene() {
    const SplatLayer ball = sphere_layer(kRadius, 1200);
    for (size_t i = 0; i < ball.size(); ++i) {
      const size_t to = diffuse.size();
      diffuse.resize(to + 1);
      for (Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity, Attribute::ShDc})
        std::copy_n(ball.at(a, i), ball.width(a), diffuse.at(a, to));
      for (size_t c = 0; c < 3; ++c) {
        diffuse.at(Attribute::Mean, to)[c] += kCentre[c];
        diffuse.at(Attribute::F0, to)[c] = logit(kPaneF0);
      }
      *diffuse.at(Attribute::Roughness, to) = logit(kPaneRoughness);
      *diffuse.at(Attribute::SpecularWeight, to) = logit(kPaneSpecular);
      *diffuse.at(Attribute::Transmission, to) = logit(kPaneTransmission);
    }
    TriMesh shell = shapes::sphere(kCentre, kRadius, 40, 80);
    ball_faces = shell.faces.size();
    // Normals as an extracted mesh has them: off by steps of a voxel.
    for (size_t v = 0; v < shell.normals.size(); ++v)
      shell.normals[v] = normalized(shell.normals[v] + 0.2f * Vec3f{std::sin(float(v)), std::cos(float(v)), 0});
    shell.colors.assign(shell.positions.size(), {0.5f, 0.5f, 0.5f});
    const auto first = uint32_t(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), shell.positions.begin(), shell.positions.end());
    mesh.normals.insert(mesh.normals.end(), shell.normals.begin(), shell.normals.end());
    mesh.colors.insert(mesh.colors.end(), shell.colors.begin(), shell.colors.end());
    for (const auto& f : shell.faces) mesh.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
  }

  static ImageOptions image(bool solid) {
    ImageOptions options;
    options.transmission.glass = Glass::Thin;
    if (solid) options.transmission.thick = std::make_shared<ThickGlass>(shapes::sphere(kCentre, kRadius, 60, 120), kIor, 0.03f);
    return options;
  }
  void write(const fs::path& root, bool solid = true) const {
    PaneScene::write(root);
    make_folders(root / "optimize/optimize");
    write_image_options(root / "optimize/optimize/model.json", image(solid));
  }
  // What stands behind glass: a square of two faces.
  static void add_content(TriMesh& content, const Vec3f& centre) {
    const auto first = uint32_t(content.positions.size());
    for (const float y : {-0.05f, 0.05f})
      for (const float z : {-0.05f, 0.05f}) content.positions.push_back(centre + Vec3f{0, y, z});
    content.normals.resize(content.positions.size(), {1, 0, 0});
    content.colors.resize(content.positions.size(), {0.5f, 0.5f, 0.5f});
    content.faces.push_back({first, first + 2, first + 1});
    content.faces.push_back({first + 1, first + 2, first + 3});
  }
};

}  // namespace vitrine::test
