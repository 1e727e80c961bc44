// OBJ with its textures and PLY with materials, read by parsers of their own.
#include <cstring>
#include <sstream>

#include <gtest/gtest.h>

#include "core/scene/image/ldr.h"
#include "core/foundation/math/color.h"
#include "core/render/picture/decomposed_materials.h"
#include "core/render/picture/trained_scene.h"
#include "stages/export/export.h"
#include "tests/stages/export/pane_scene.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using test::PaneScene;
using test::RecordingContext;

class PaneFiles : public testing::Test {
 protected:
  PaneFiles() { scene_.write(root_.path()); }
  RecordingContext context() const {
    std::map<std::string, fs::path> inputs;
    for (const char* stage : {"sfm", "optimize", "mesh", "decompose"})
      if (fs::exists(root_.path() / stage)) inputs[stage] = root_.path() / stage;
    return RecordingContext(inputs);
  }
  // Albedo 0.6 0.5 0.4 everywhere, other materials as the scene's.
  void write_materials(size_t surfels) const {
    DecomposedMaterials m;
    m.resize(surfels);
    for (size_t i = 0; i < surfels; ++i) {
      m.albedo[i] = {0.6f, 0.5f, 0.4f};
      m.roughness[i] = 0.35f;
      m.f0[i] = {0.04f, 0.04f, 0.04f};
      m.specular_weight[i] = 0;
      m.transmission[i] = 0;
    }
    make_folders(root_.path() / "decompose/decompose");
    write_decomposed_materials(root_.path() / "decompose", m);
  }

  TemporaryFolder root_;
  PaneScene scene_;
};

struct Obj {
  std::vector<Vec3f> v, vn;
  std::vector<Vec2f> vt;
  struct Face {
    std::string group, material;
    std::array<std::array<size_t, 3>, 3> corner;  // v, vt, vn from 0
  };
  std::vector<Face> faces;
  std::string library;

  explicit Obj(const fs::path& path) {
    std::istringstream in(read_file(path));
    Face state{};
    for (std::string line; std::getline(in, line);) {
      std::istringstream words(line);
      std::string word;
      words >> word;
      Vec3f p{};
      if (word == "v" || word == "vn") {
        words >> p.x >> p.y >> p.z;
        (word == "v" ? v : vn).push_back(p);
      } else if (word == "vt") {
        words >> p.x >> p.y;
        vt.push_back({p.x, p.y});
      } else if (word == "g") {
        words >> state.group;
      } else if (word == "usemtl") {
        words >> state.material;
      } else if (word == "mtllib") {
        words >> library;
      } else if (word == "f") {
        for (auto& corner : state.corner) {
          char slash = 0;
          words >> corner[0] >> slash >> corner[1] >> slash >> corner[2];
          for (size_t& i : corner) --i;
        }
        faces.push_back(state);
      }
    }
  }
};

TEST_F(PaneFiles, ObjHasTexturedGroupsForFloorAndGlass) {
  RecordingContext c = context();
  run_export({.formats = {"mesh-obj"}, .texture_size = 512}, c);
  const fs::path folder = c.output() / "export";
  const Obj obj(folder / "mesh.obj");
  ASSERT_EQ(obj.faces.size(), scene_.mesh.faces.size());
  EXPECT_EQ(obj.v.size(), scene_.mesh.positions.size());
  const ImageF picture = read_srgb(folder / "textures/obj/base_color.png");
  const ImageF transmission = read_unchanged(folder / "textures/obj/transmission.png");
  size_t glass = 0, looked = 0;
  for (const Obj::Face& f : obj.faces) {
    EXPECT_EQ(f.group, f.material);
    Vec3f p{};
    float u = 0, v = 0;
    for (const auto& corner : f.corner) {
      ASSERT_TRUE(corner[0] < obj.v.size() && corner[1] < obj.vt.size() && corner[2] < obj.vn.size());
      p += obj.v[corner[0]] / 3.f;
      u += obj.vt[corner[1]].x / 3, v += obj.vt[corner[1]].y / 3;
    }
    const int x = int(u * 512), y = int((1 - v) * 512);  // v counts from below
    const bool pane = std::abs(p.x) < 1e-4f && p.z > 0.05f;
    EXPECT_EQ(f.group, pane ? "glass" : "opaque");
    glass += pane;
    EXPECT_NEAR(transmission.at(x, y), pane ? test::kPaneTransmission : 0, 0.3) << p.x << " " << p.y << " " << p.z;
    const float fx = 2 * p.x - std::floor(2 * p.x), fy = 2 * p.y - std::floor(2 * p.y);
    if (pane || std::min({fx, fy, 1 - fx, 1 - fy}) < 0.25f || std::max(std::abs(p.x), std::abs(p.y)) > 0.95f) continue;
    ++looked;
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(picture.at(x, y, k), srgb_from_linear(test::tile_color(p.x, p.y)[size_t(k)]), 0.02);
  }
  EXPECT_EQ(glass, scene_.mesh.faces.size() - scene_.floor_faces);
  EXPECT_GT(looked, 500u);

  const std::string library = read_file(folder / obj.library);
  EXPECT_NE(library.find("newmtl glass"), std::string::npos);
  EXPECT_EQ(library.find("Kd 0"), std::string::npos) << "a grey Kd darkens the texture";
  std::istringstream lines(library);
  for (std::string line; std::getline(lines, line);)
    if (const size_t at = line.find("textures/"); at != std::string::npos) {
      EXPECT_TRUE(fs::exists(folder / line.substr(at))) << line;
    }
}

TEST_F(PaneFiles, FacesStayFrontFacingInMirroredFrames) {
  for (const ExportAxes axes : {ExportAxes::Rhyu, ExportAxes::Lhzu, ExportAxes::Lhyu}) {
    RecordingContext c = context();
    run_export({.formats = {"mesh-obj"}, .axes = axes, .scale = 2, .texture_size = 256}, c);
    const Obj obj(c.output() / "export/mesh.obj");
    Vec3f high{};
    for (const Vec3f& p : obj.v)
      for (size_t k = 0; k < 3; ++k) high[k] = std::max(high[k], p[k]);
    EXPECT_NEAR(axes == ExportAxes::Lhzu ? high.z : high.y, 1.8f, 1e-4);
    for (const Obj::Face& f : obj.faces) {
      const Vec3f a = obj.v[f.corner[0][0]], b = obj.v[f.corner[1][0]], d = obj.v[f.corner[2][0]];
      EXPECT_GT(dot(cross(b - a, d - a), obj.vn[f.corner[0][2]]), 0) << kExportAxesWords[size_t(axes)];
    }
  }
}

struct VertexRow {
  float position[3], normal[3];
  uint8_t color[3];
  float f0[3], roughness, transmission;
  float albedo[3];
};

// The rows of mesh.ply; the header must be the expected one.
std::vector<VertexRow> rows_of(const fs::path& path, bool albedo, size_t vertices) {
  const std::string bytes = read_file(path);
  const size_t end = bytes.find("end_header\n") + 11;
  std::istringstream header(bytes.substr(0, end));
  std::vector<std::string> names;
  for (std::string line; std::getline(header, line);) {
    std::istringstream words(line);
    std::string word, type, name;
    words >> word >> type >> name;
    if (word == "element") {
      EXPECT_EQ(name, type == "vertex" ? std::to_string(vertices) : name);
    }
    if (word == "property" && type != "list") names.push_back(type == "uchar" ? fmt::format("8 {}", name) : name);
  }
  std::vector<std::string> expected{"x",       "y",      "z",    "nx",   "ny",   "nz",        "8 red",
                                    "8 green", "8 blue", "f0_r", "f0_g", "f0_b", "roughness", "transmission"};
  if (albedo) expected.insert(expected.end(), {"albedo_r", "albedo_g", "albedo_b"});
  EXPECT_EQ(names, expected);
  std::vector<VertexRow> rows(vertices);
  const size_t width = albedo ? 59 : 47;
  for (size_t i = 0; i < vertices; ++i) {
    const char* from = bytes.data() + end + i * width;
    std::memcpy(rows[i].position, from, 24);
    std::memcpy(rows[i].color, from + 24, 3);
    std::memcpy(rows[i].f0, from + 27, 20);
    if (albedo) std::memcpy(rows[i].albedo, from + 47, 12);
  }
  return rows;
}

TEST_F(PaneFiles, PlyHasMaterialsAtTheVertices) {
  RecordingContext c = context();
  run_export({.formats = {"mesh-ply"}}, c);
  const size_t n = scene_.mesh.positions.size();
  const auto rows = rows_of(c.output() / "export/mesh.ply", false, n);
  size_t panes = 0;
  for (size_t i = 0; i < n; ++i) {
    const Vec3f& p = scene_.mesh.positions[i];
    EXPECT_EQ(rows[i].position[2], p.z);
    EXPECT_NEAR(rows[i].color[0], 255 * srgb_from_linear(0.5f), 1);  // the colour that was fused
    const bool pane = i >= 41 * 41;
    if (p.z < 0.2f && pane) continue;  // where the pane meets the floor
    if (!pane && std::abs(p.x) < 0.1f) continue;
    panes += pane;
    EXPECT_NEAR(rows[i].transmission, pane ? test::kPaneTransmission : 0.002f, 0.01);
    EXPECT_NEAR(rows[i].f0[1], pane ? 0.0975f : 0.04f, 0.002);
    EXPECT_NEAR(rows[i].roughness, pane ? test::kPaneRoughness : 1, 0.01);
  }
  EXPECT_GT(panes, 200u);
}

// The blend rtrgs weighs the transmitted light with k_s tau, the reflected one with k_s F.
TEST_F(PaneFiles, TransmissionOfTheBlendRtrgsHasItsSpecularWeight) {
  ImageOptions options;
  options.composite.blend = LayerBlend::RtrGs;
  make_folders(root_.path() / "optimize/optimize");
  write_image_options(root_.path() / "optimize/optimize/model.json", options);
  const size_t n = scene_.mesh.positions.size(), on_pane = n - 10;  // away from the floor
  RecordingContext trained = context();
  run_export({.formats = {"mesh-ply"}}, trained);
  const VertexRow row = rows_of(trained.output() / "export/mesh.ply", false, n)[on_pane];
  EXPECT_NEAR(row.transmission, test::kPaneSpecular * test::kPaneTransmission, 1e-3);
  EXPECT_NEAR(row.f0[0], test::kPaneSpecular * test::kPaneF0, 1e-3);

  DecomposedMaterials m;
  m.resize(scene_.diffuse.size());
  for (size_t i = 0; i < m.size(); ++i) m.specular_weight[i] = 0.5f, m.transmission[i] = 0.8f, m.f0[i] = {0.1f, 0.1f, 0.1f};
  make_folders(root_.path() / "decompose/decompose");
  write_decomposed_materials(root_.path() / "decompose", m);
  RecordingContext relit = context();
  run_export({.formats = {"mesh-ply"}}, relit);
  const VertexRow second = rows_of(relit.output() / "export/mesh.ply", true, n)[on_pane];
  EXPECT_NEAR(second.transmission, 0.4, 1e-3);
  EXPECT_NEAR(second.f0[0], 0.05, 1e-3);
}

// Two sides of a box's edge, one of them cut into many slivers: what counts is the angle, not the area of the triangles.
TEST_F(PaneFiles, NormalsOfAMeshWithoutAnyAreIndependentOfItsTriangles) {
  TriMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, -9}, {1, 0, -9}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}, {0, 4, 5}, {0, 5, 1}};
  write_mesh_ply(root_.path() / "mesh/mesh/mesh.ply", mesh);
  RecordingContext c = context();
  run_export({.formats = {"mesh-obj"}, .texture_size = 64}, c);
  const Obj obj(c.output() / "export/mesh.obj");
  EXPECT_NEAR(obj.vn.at(0).z, std::sqrt(0.5f), 1e-3);
  EXPECT_NEAR(obj.vn.at(0).y, -std::sqrt(0.5f), 1e-3);
}

TEST_F(PaneFiles, ColoursAreAlbedoWhenTheSceneWasDecomposed) {
  write_materials(scene_.diffuse.size());
  RecordingContext c = context();
  run_export({.formats = {"mesh-ply", "mesh-obj"}, .texture_size = 256}, c);
  for (const VertexRow& row : rows_of(c.output() / "export/mesh.ply", true, scene_.mesh.positions.size())) {
    EXPECT_NEAR(row.albedo[0], 0.6, 1e-4);
    EXPECT_NEAR(row.albedo[2], 0.4, 1e-4);
    EXPECT_NEAR(row.color[1], 255 * srgb_from_linear(0.5f), 1);
    EXPECT_NEAR(row.roughness, 0.35, 1e-4);
  }
  const ImageF picture = read_srgb(c.output() / "export/textures/obj/base_color.png");
  for (size_t i = 0; i < picture.pixel_count(); ++i) ASSERT_NEAR(picture.data()[3 * i], srgb_from_linear(0.6f), 0.005);
  EXPECT_NE(read_file(c.output() / "export/mesh.obj").find("albedo"), std::string::npos);
}

TEST_F(PaneFiles, MaterialsOfAnotherSceneAreRefused) {
  write_materials(scene_.diffuse.size() - 1);
  RecordingContext c = context();
  const Error e = error_of([&] { run_export({.formats = {"mesh-ply"}}, c); });
  EXPECT_EQ(e.kind(), ErrorKind::Input);
  EXPECT_EQ(e.detail().code, "BAD_MATERIALS");
}

TEST_F(PaneFiles, AnEmptyMeshIsRefused) {
  write_mesh_ply(root_.path() / "mesh/mesh/mesh.ply", {});
  for (const char* format : {"mesh-ply", "mesh-obj", "mesh-glb"}) {
    RecordingContext c = context();
    const Error e = error_of([&] { run_export({.formats = {format}}, c); });
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    EXPECT_NE(std::string(e.what()).find("mesh.ply"), std::string::npos);
  }
}

}  // namespace
}  // namespace vitrine
