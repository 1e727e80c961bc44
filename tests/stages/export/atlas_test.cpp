// Charts, texels and gaps of the texture atlas; frames of exported files.
#include <set>

#include <gtest/gtest.h>

#include "core/foundation/base/rng.h"
#include "core/foundation/math/spherical_harmonics.h"
#include "stages/export/bake/atlas.h"
#include "stages/export/bake/pbr_mesh.h"
#include "stages/export/bake/texels.h"
#include "stages/export/formats/source.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

// A sheet over (u, v) in [0,1]^2.
template <class F>
TriMesh sheet(int nu, int nv, F&& point) {
  TriMesh m;
  const auto side = uint32_t(nu + 1);
  for (int j = 0; j <= nv; ++j)
    for (int i = 0; i <= nu; ++i) m.positions.push_back(point(float(i) / float(nu), float(j) / float(nv)));
  for (uint32_t j = 0; j < uint32_t(nv); ++j)
    for (uint32_t i = 0; i < uint32_t(nu); ++i) {
      const uint32_t v = j * side + i;
      m.faces.push_back({v, v + 1, v + side});
      m.faces.push_back({v + 1, v + side + 1, v + side});
    }
  return m;
}
TriMesh sphere() {
  return sheet(48, 24, [](float u, float v) {
    const float a = 6.2831853f * u, b = 0.02f + 3.1f * v;
    return Vec3f{std::sin(b) * std::cos(a), -std::sin(b) * std::sin(a), std::cos(b)};
  });
}
// A ramp that winds three times around an axis: every turn lies over the one before, all faces look up.
TriMesh winding_ramp() {
  return sheet(20, 240, [](float u, float v) {
    const float a = 3 * 6.2831853f * v, r = 0.4f + 0.6f * u;
    return Vec3f{r * std::cos(a), r * std::sin(a), 0.5f * v};
  });
}

void expect_sound(const TriMesh& mesh, const Atlas& atlas) {
  // Rectangles inside the atlas, and apart.
  for (size_t i = 0; i < atlas.charts.size(); ++i) {
    const AtlasChart& a = atlas.charts[i];
    EXPECT_GE(a.x, 0);
    EXPECT_GE(a.y, 0);
    EXPECT_LE(a.x + a.width, atlas.size);
    EXPECT_LE(a.y + a.height, atlas.size);
    for (size_t j = i + 1; j < atlas.charts.size(); ++j) {
      const AtlasChart& b = atlas.charts[j];
      EXPECT_TRUE(a.x + a.width <= b.x || b.x + b.width <= a.x || a.y + a.height <= b.y || b.y + b.height <= a.y)
          << "charts " << i << " and " << j << " overlap";
    }
  }
  // Faces inside their chart's rectangle with padding; texels claimed twice are rare roundings.
  std::set<std::pair<int, int>> taken;
  size_t twice = 0, all = 0;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const uint32_t chart = atlas.chart_of_face[f];
    ASSERT_LT(chart, atlas.charts.size());
    const AtlasChart& c = atlas.charts[chart];
    Vec2f corner[3];
    for (size_t k = 0; k < 3; ++k) {
      corner[k] = atlas.texel(chart, mesh.positions[mesh.faces[f][k]]);
      EXPECT_GE(corner[k].x, float(c.x) + 1);
      EXPECT_LE(corner[k].x, float(c.x + c.width) - 1);
      EXPECT_GE(corner[k].y, float(c.y) + 1);
      EXPECT_LE(corner[k].y, float(c.y + c.height) - 1);
    }
    for_texels_of(corner, [&](int x, int y, const Vec3f& b) {
      ++all;
      twice += !taken.insert({x, y}).second;
      EXPECT_NEAR(b.x + b.y + b.z, 1, 1e-4);
    });
  }
  EXPECT_LE(double(twice), 0.002 * double(all)) << "overlapping faces";
  EXPECT_EQ(covered_texels(atlas, mesh).size(), taken.size());
  // Every face has its area in texels, but for what its slope takes.
  double area = 0;
  for (const auto& v : mesh.faces)
    area += 0.5 * length(cross(mesh.positions[v[1]] - mesh.positions[v[0]], mesh.positions[v[2]] - mesh.positions[v[0]]));
  const double texels = area * atlas.texels_per_unit * atlas.texels_per_unit;
  EXPECT_GT(double(all), 0.6 * texels);
  EXPECT_LT(double(all), 1.02 * texels);
}

TEST(Atlas, OfASphereHasAFewSoundCharts) {
  const TriMesh mesh = sphere();
  const Atlas atlas = make_atlas(mesh, 256);
  EXPECT_LT(atlas.charts.size(), 30u);
  expect_sound(mesh, atlas);
}

TEST(Atlas, TakesAWindingRampApart) {
  const TriMesh mesh = winding_ramp();
  const Atlas atlas = make_atlas(mesh, 256);
  EXPECT_GE(atlas.charts.size(), 3u) << "one chart cannot hold three turns";
  expect_sound(mesh, atlas);
}

TEST(Atlas, OfLooseTrianglesGivesEachItsChart) {
  TriMesh mesh;
  Rng rng(5);
  for (uint32_t i = 0; i < 200; ++i) {
    for (int k = 0; k < 3; ++k) mesh.positions.push_back({rng.normal(), rng.normal(), rng.normal()});
    mesh.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const Atlas atlas = make_atlas(mesh, 512);
  EXPECT_EQ(atlas.charts.size(), 200u);
  expect_sound(mesh, atlas);
}

TEST(Atlas, SurvivesNeedlesAndPoints) {
  TriMesh mesh;
  mesh.positions = {{0, 0, 0}, {1000, 0, 0}, {500, 1e-6f, 0}, {1, 1, 1}};
  mesh.faces = {{0, 1, 2}, {3, 3, 3}, {0, 1, 1}};
  const Atlas atlas = make_atlas(mesh, 64);
  EXPECT_EQ(atlas.chart_of_face.size(), 3u);
  for (const AtlasTexel& t : covered_texels(atlas, mesh)) EXPECT_LT(t.face, 3u);
}

TEST(Atlas, SaysWhenTheTexturesAreTooSmall) {
  TriMesh mesh;
  for (uint32_t i = 0; i < 100; ++i) {
    for (const Vec3f& p : {Vec3f{0, 0, 0}, Vec3f{1, 0, 0}, Vec3f{0, 1, 0}}) mesh.positions.push_back(p + Vec3f{0, 0, float(i)});
    mesh.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const Error e = error_of([&] { make_atlas(mesh, 8); });
  EXPECT_EQ(e.kind(), ErrorKind::Usage);
  EXPECT_EQ(e.detail().code, "TEXTURE_TOO_SMALL");
  EXPECT_NE(e.detail().why.find("100 pieces"), std::string::npos) << e.what();
  EXPECT_NE(e.detail().hint.find("texture_size=64"), std::string::npos) << e.what();
  EXPECT_EQ(make_atlas(mesh, 64).charts.size(), 100u) << "the hint helps";
}

TEST(TexelCover, GivesCentresOnEdgesToTheRightAndBelow) {
  const auto covers = [](const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    bool found = false;
    const Vec2f corner[3] = {a, b, c};
    for_texels_of(corner, [&](int x, int y, const Vec3f&) { found |= x == 4 && y == 4; });
    return found;
  };
  // The centre (4.5, 4.5) lies on the middle of an upright and of a level edge.
  EXPECT_TRUE(covers({4.5f, 0}, {4.5f, 9}, {9, 4.5f}));
  EXPECT_FALSE(covers({4.5f, 0}, {4.5f, 9}, {0, 4.5f}));
  EXPECT_TRUE(covers({0, 4.5f}, {9, 4.5f}, {4.5f, 9}));
  EXPECT_FALSE(covers({0, 4.5f}, {9, 4.5f}, {4.5f, 0}));
}

TEST(TexelCover, GivesTheTexelsOfASharedEdgeToOneTriangle) {
  // The diagonal of a square passes exactly through centres of texels.
  const Vec2f a{0.5f, 0.5f}, b{8.5f, 0.5f}, c{8.5f, 8.5f}, d{0.5f, 8.5f};
  std::multiset<std::pair<int, int>> seen;
  const Vec2f one[3] = {a, b, c}, two[3] = {a, c, d};
  for_texels_of(one, [&](int x, int y, const Vec3f&) { seen.insert({x, y}); });
  for_texels_of(two, [&](int x, int y, const Vec3f&) { seen.insert({x, y}); });
  EXPECT_EQ(seen.size(), 64u);
  for (const auto& texel : seen) EXPECT_EQ(seen.count(texel), 1u);
}

TEST(FillGaps, TakesTheNearestAndKeepsTheKnown) {
  Image8 image(64, 64, 3);
  std::vector<uint8_t> known(64 * 64, 0);
  const auto put = [&](int x, int y, uint8_t v) {
    for (int c = 0; c < 3; ++c) image.at(x, y, c) = v;
    known[size_t(y) * 64 + size_t(x)] = 1;
  };
  for (int y = 8; y < 16; ++y)
    for (int x = 8; x < 16; ++x) put(x, y, 200), put(x + 32, y + 32, 40);
  fill_gaps(image, known);
  EXPECT_EQ(image.at(10, 10), 200);
  EXPECT_EQ(image.at(45, 45), 40);
  EXPECT_EQ(image.at(7, 10), 200);
  EXPECT_EQ(image.at(16, 12), 200);
  EXPECT_EQ(image.at(39, 45, 2), 40);
  for (uint8_t v : image.data()) EXPECT_TRUE(v >= 40 && v <= 200);
}

TEST(PbrValues, MirrorsAreMetalGlassIsClearDielectricsKeepTheirFresnelTerm) {
  const PbrValues mirror = pbr_values({.color = {0.1f, 0.1f, 0.1f}, .f0 = {0.9f, 0.8f, 0.7f}, .roughness = 0.1f});
  EXPECT_EQ(mirror.metallic, 1);
  EXPECT_FLOAT_EQ(mirror.base_color.x, 0.9f);
  const PbrValues pane = pbr_values({.color = {0, 0, 0}, .f0 = {0.08f, 0.08f, 0.08f}, .roughness = 0, .transmission = 1});
  EXPECT_EQ(pane.metallic, 0);
  EXPECT_EQ(pane.transmission, 1);
  EXPECT_EQ(pane.base_color, (Vec3f{1, 1, 1}));
  EXPECT_NEAR(pane.specular_color.x * kSpecularColorFactor * kDielectricF0, 0.08f, 1e-6);
  const PbrValues paint = pbr_values({.color = {0.3f, 0.2f, 1.7f}, .f0 = {0.04f, 0.04f, 0.04f}});
  EXPECT_FLOAT_EQ(paint.base_color.x, 0.3f);
  EXPECT_FLOAT_EQ(paint.base_color.z, 1);
}

TEST(ExportFrame, TurnsSurfelsWithTheirColours) {
  SplatLayer layer(LayerKind::Diffuse, 3, 20);
  Rng rng(11);
  for (const AttributeRow& r : kAttributes)
    for (float& v : layer.values(r.id)) v = rng.normal();
  const auto radiance = [](const SplatLayer& l, size_t i, const Vec3f& d, size_t c) {
    float basis[16];
    sh_basis(3, d, basis);
    float v = basis[0] * l.at(Attribute::ShDc, i)[c];
    for (size_t k = 1; k < 16; ++k) v += basis[k] * l.at(Attribute::ShRest, i)[3 * (k - 1) + c];
    return v;
  };
  for (size_t choice = 0; choice < kExportAxesWords.size(); ++choice) {
    const std::string_view word = kExportAxesWords[choice];
    const ExportFrame frame = ExportFrame::of(ExportAxes(choice), 2.5);
    EXPECT_EQ(frame.mirrored(), word[0] == 'l');
    EXPECT_EQ(frame.y_up(), word[2] == 'y');
    EXPECT_EQ(frame.direction({0, 0, 1}), (word[2] == 'y' ? Vec3f{0, 1, 0} : Vec3f{0, 0, 1}));
    const SplatLayer out = in_frame(layer, frame);
    for (size_t i = 0; i < layer.size(); ++i) {
      for (int trial = 0; trial < 4; ++trial) {
        const Vec3f d = normalized(Vec3f{rng.normal(), rng.normal(), rng.normal()});
        for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(radiance(out, i, frame.direction(d), c), radiance(layer, i, d, c), 2e-5);
      }
      // The disk's axes go where the frame takes them, up to the sign of the normal.
      const auto rotation = [](const SplatLayer& l, size_t k) {
        const float* q = l.at(Attribute::Rotation, k);
        return rotation_matrix(normalized(Quatf{q[0], q[1], q[2], q[3]}));
      };
      const Mat3f before = rotation(layer, i), after = rotation(out, i);
      EXPECT_GT(dot(after.c0, frame.direction(before.c0)), 0.9999f);
      EXPECT_GT(dot(after.c1, frame.direction(before.c1)), 0.9999f);
      EXPECT_GT(std::abs(dot(after.c2, frame.direction(before.c2))), 0.9999f);
      EXPECT_NEAR(out.at(Attribute::LogScale, i)[1], layer.at(Attribute::LogScale, i)[1] + std::log(2.5f), 1e-5);
    }
  }
}

}  // namespace
}  // namespace vitrine
