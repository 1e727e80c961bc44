// What the program behind `vitrine view` puts into a page. How the page looks: tests/pages.
#include "stages/view/view.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include "core/render/picture/decomposed_materials.h"
#include "core/scene/image/ldr.h"
#include "stages/page_text.h"
#include "stages/view/page_blocks.h"
#include "stages/view/page_surfels.h"
#include "tests/core/render/relight/relit_ball.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiny_capture.h"

namespace vitrine {
namespace {

using nlohmann::json;
using test::RecordingContext;

constexpr const char* kPage = "<html><!-- the data --></html>";

class ViewStage : public testing::Test {
 protected:
  ViewStage() {
    make_folders(decompose() / "decompose");
    write_decomposed_materials(decompose(), test::relit_ball({0.8f, 0.4f, 0.2f}).materials);
    write_environment(decomposed_environment_path(decompose()), Environment(ImageF(16, 8, 3, 1.f)));
  }
  fs::path decompose() const { return folder.path() / "artifact"; }
  std::map<std::string, fs::path> inputs() const {
    return {{"sfm", capture.sfm()}, {"optimize", capture.optimize()}, {"mesh", capture.mesh()}, {"decompose", decompose()}};
  }
  static std::string page(RecordingContext& context, const ViewConfig& config = {.rays = 8}) {
    write_view(kPage, config, context);
    return read_file(context.output() / "view.html");
  }
  static std::string part(const std::string& page, const std::string& id) {
    const std::string mark = "id=\"" + id + "\">";
    const size_t begin = page.find(mark) + mark.size();
    return page.substr(begin, page.find("</script>", begin) - begin);
  }
  TemporaryFolder folder;
  test::TinyCapture capture;
};

TEST_F(ViewStage, ThePageHoldsCamerasPhotosAndSurfels) {
  RecordingContext context(inputs());
  const std::string text = page(context);
  EXPECT_TRUE(text.starts_with("<html><script")) << text.substr(0, 100);
  EXPECT_TRUE(text.ends_with("</html>"));
  const json scene = json::parse(part(text, "scene"));
  EXPECT_EQ(scene["surfels"], capture.layer.size());
  EXPECT_EQ(scene["solid"], capture.layer.size());
  EXPECT_EQ(scene["left_out"], 0);
  EXPECT_TRUE(scene["relit"]);
  ASSERT_EQ(scene["cameras"].size(), 8u);
  EXPECT_EQ(scene["cameras"][0]["width"], test::TinyCapture::kWidth);
  EXPECT_TRUE(scene["cameras"][0]["heldout"]);
  EXPECT_FALSE(scene["cameras"][1]["heldout"]);
  const json photos = json::parse(part(text, "photos"));
  ASSERT_EQ(photos.size(), 8u);
  EXPECT_TRUE(photos[0].get<std::string>().starts_with("data:image/jpeg;base64,/9j/"));
  EXPECT_TRUE(context.warnings.empty());
  EXPECT_EQ(read_srgb(context.output() / "view_relit.jpg").width(), test::TinyCapture::kWidth);
}

TEST_F(ViewStage, SameBytesForAnyNumberOfThreads) {
  std::vector<std::string> pages, pictures;
  for (const int threads : {1, 3}) {
    set_thread_limit(threads);
    RecordingContext context(inputs());
    pages.push_back(page(context));
    pictures.push_back(read_file(context.output() / "view_relit.jpg"));
  }
  set_thread_limit(0);
  EXPECT_EQ(pages[0], pages[1]);
  EXPECT_EQ(pictures[0], pictures[1]);
}

TEST_F(ViewStage, WithoutMaterialsItSaysThatItCannotRelight) {
  auto few = inputs();
  few.erase("decompose");
  RecordingContext context(few);
  EXPECT_FALSE(json::parse(part(page(context), "scene"))["relit"]);
  EXPECT_TRUE(context.warnings.contains("VIEW_NO_LIGHT"));
  EXPECT_FALSE(fs::exists(context.output() / "view_relit.jpg"));
}

TEST_F(ViewStage, TooManySurfelsLeaveOutThoseThatShowLeast) {
  RecordingContext context(inputs());
  const json scene = json::parse(part(page(context, {.surfels = 1000, .photo_side = 0, .rays = 8}), "scene"));
  EXPECT_EQ(scene["surfels"], 1000);
  EXPECT_EQ(scene["left_out"], capture.layer.size() - 1000);
  EXPECT_NE(context.warnings["VIEW_SURFELS"].find("leaves out 800 of 1800 surfels"), std::string::npos)
      << context.warnings["VIEW_SURFELS"];
}

TEST_F(ViewStage, NamesOfPhotosStayInTheirElement) {
  const std::string text = page_of(kPage, {json_part("scene", {{"name", "</script><script>alert(1)"}})});
  EXPECT_EQ(text.find("</script><script>alert"), std::string::npos);
  EXPECT_EQ(json::parse(part(text, "scene"))["name"], "</script><script>alert(1)");
}

TEST_F(ViewStage, APageOfAnotherBuildIsRefused) {
  const Error e = error_of([&] { page_of("<html></html>", {}); });
  EXPECT_EQ(e.kind(), ErrorKind::Dependency);
  EXPECT_EQ(e.detail().code, "NO_PAGE");
}

TEST(PageBlocks, BytesOfAnArrayStandPlaneByPlane) {
  PageBlocks blocks;
  const std::vector<uint16_t> words{0x0102, 0x0304, 0x0506, 0x0708};
  blocks.words("w", words, 2);
  EXPECT_EQ(blocks.buffer(), std::string("\x02\x06\x01\x05\x04\x08\x03\x07", 8));
  EXPECT_EQ(blocks.directory()[0]["count"], 4);
  const std::string packed = deflated(blocks.buffer());
  std::string out(8, '\0');
  uLongf size = out.size();
  ASSERT_EQ(uncompress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(packed.data()), packed.size()),
            Z_OK);
  EXPECT_EQ(out, blocks.buffer());
  EXPECT_EQ(half_bits(1.f), 0x3c00);
  EXPECT_EQ(half_bits(1e9f), 0x7bff);  // the largest there is
  EXPECT_EQ(rounded_half(1.1f, 3), 1.125f);
  EXPECT_EQ(half_bits(rounded_half(-65000.f, 2)), 0xfb00) << "down where up is not finite";
}

TEST(PageSurfels, ThoseThatShowTheLightOfThePhotosAreFlagged) {
  TrainedScene scene;
  scene.surfels.diffuse = test::sphere_layer(0.4, 100);
  scene.surfels.reflection = SplatLayer(LayerKind::Reflection, 0, 7);
  DecomposedMaterials materials;
  materials.resize(100);
  for (size_t i = 0; i < 100; ++i) materials.albedo[i] = {i == 42 || i == 43 ? 0.f : 0.5f, 0, 0};
  materials.f0[43] = {0.04f, 0.04f, 0.04f};  // black, and a surface
  PageSurfels surfels = page_surfels(scene, std::vector<Vec3d>{{1, 0, 0}}, 1000);
  mark_sky(materials, surfels);
  for (size_t k = 0; k < surfels.layer.size(); ++k)
    EXPECT_EQ((surfels.flags[k] & kSkySurfel) != 0, surfels.of_diffuse[k] == 42) << k;
}

// Half of a ball is wax: its surfels borrow light from each other, near ones most.
TEST(PageSurfels, WaxBorrowsLightFromWaxAround) {
  RelitScene scene = test::relit_ball({0.8f, 0.6f, 0.4f});
  const size_t n = scene.materials.size();
  const auto x_of = [&](size_t i) { return scene.trained.surfels.diffuse.at(Attribute::Mean, i)[0]; };
  const PageSurfels surfels = page_surfels(scene.trained, std::vector<Vec3d>{{1, 0, 0}}, 100000);
  PageBlocks none;
  add_subsurface(scene, surfels, none);
  EXPECT_TRUE(none.directory().empty()) << "nothing scatters";
  scene.materials.scatter.resize(n);
  size_t wax = 0;
  for (size_t i = 0; i < n; ++i)
    if (x_of(i) > 0) scene.materials.scatter[i] = {0.04f, 0.02f, 0.01f}, ++wax;
  PageBlocks blocks;
  add_subsurface(scene, surfels, blocks);
  const auto& list = blocks.directory();
  ASSERT_EQ(list.size(), 3u);
  ASSERT_EQ(list[0]["count"], wax);
  ASSERT_EQ(list[1]["count"], 24 * wax);
  // Byte plane by byte plane; little-endian.
  const auto word = [&](size_t block, size_t at) {
    const size_t width = list[block]["width"], count = list[block]["count"], offset = list[block]["offset"],
                 items = count / width;
    uint32_t value = 0;
    for (size_t byte = 0; byte < 4; ++byte)
      value |= uint32_t(uint8_t(blocks.buffer()[offset + (at % width * 4 + byte) * items + at / width])) << (8 * byte);
    return value;
  };
  const auto share = [&](size_t at) {
    const size_t width = list[2]["width"], items = size_t(list[2]["count"]) / width;
    return double(uint8_t(blocks.buffer()[size_t(list[2]["offset"]) + at % width * items + at / width]));
  };
  for (size_t s = 0; s < wax; s += 37) {
    const uint32_t self = word(0, s);
    EXPECT_GT(surfels.layer.at(Attribute::Mean, self)[0], 0);
    Vec3d sum{}, far{};
    for (size_t j = 0; j < 24; ++j) {
      const uint32_t lender = word(1, 24 * s + j);
      EXPECT_GT(surfels.layer.at(Attribute::Mean, lender)[0], 0) << "the other half is opaque";
      for (size_t c = 0; c < 3; ++c) {
        sum[c] += share(3 * (24 * s + j) + c);
        if (j >= 8) far[c] += share(3 * (24 * s + j) + c);
      }
    }
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], 255, 12);
    EXPECT_GT(far.x, far.z) << "red light goes farther";
  }
}

TEST(PageSurfels, ConstantPartsOfColoursAreFineWhereItIsDark) {
  PageSurfels surfels;
  surfels.layer = SplatLayer(LayerKind::Diffuse, 0, 3);
  const float colors[3][3] = {{0.001f, 0.0005f, 0}, {1, 0.25f, 9}, {-0.01f, 0.5f, 2}};
  for (size_t i = 0; i < 3; ++i)
    for (size_t c = 0; c < 3; ++c) surfels.layer.at(Attribute::ShDc, i)[c] = (colors[i][c] - 0.5f) / kShDc;
  for (size_t i = 0; i < 3; ++i) surfels.layer.at(Attribute::Rotation, i)[0] = 1;
  surfels.flags.assign(3, 0);
  PageBlocks blocks;
  add_surfels(surfels, std::nullopt, blocks);
  const auto entry = *std::ranges::find_if(blocks.directory(), [](const auto& b) { return b["name"] == "constant"; });
  const size_t offset = entry["offset"];
  const auto word = [&](size_t i, size_t c) {  // first all low bytes of c = 0, then their high ones, then those of c = 1
    const auto byte = [&](size_t plane) { return uint8_t(blocks.buffer()[offset + 3 * plane + i]); };
    return int16_t(byte(2 * c) | byte(2 * c + 1) << 8);
  };
  for (size_t i = 0; i < 3; ++i) {
    const int green = word(i, 0);
    const int roots[3] = {word(i, 1) + green, green, word(i, 2) + green};
    for (size_t c = 0; c < 3; ++c) {
      const float root = float(roots[c]) / 1023, now = root * std::abs(root);
      EXPECT_NEAR(now, colors[i][c], 0.001f * std::sqrt(std::abs(colors[i][c])) + 1e-6f) << i << " " << c;
    }
  }
}

// A ball among cameras: a photo sees what faces it. Near its rim a ball of flat surfels is none, and either is right.
TEST(PhotoCoverage, IsOfThePhotosThatAConvexThingFaces) {
  constexpr double kRim = 0.5;
  const test::TinyCapture capture;
  TrainedScene scene;
  scene.surfels.diffuse = capture.layer;
  std::vector<Vec3d> eyes;
  for (const View& v : capture.views) eyes.push_back(v.centre_in_world());
  const PageSurfels surfels = page_surfels(scene, eyes, 5000);
  const auto found = page_coverage(surfels, capture.views, 0.01f);
  ASSERT_EQ(found.size(), surfels.drawn);
  const auto widest = [](const std::vector<Vec3d>& ways) {
    double most = 0;
    for (const Vec3d& a : ways)
      for (const Vec3d& b : ways) most = std::max(most, std::acos(std::min(1.0, dot(a, b))) * 180 / std::numbers::pi);
    return most;
  };
  size_t certain = 0, unseen = 0;
  for (size_t i = 0; i < found.size(); ++i) {
    const float* m = surfels.layer.at(Attribute::Mean, i);
    const Vec3d place{m[0], m[1], m[2]};
    std::vector<Vec3d> faced, possible;
    for (const Vec3d& eye : eyes) {
      const Vec3d way = normalized(eye - place);
      const double cosine = dot(way, normalized(place));
      if (cosine >= kRim) faced.push_back(way);
      if (cosine > -kRim) possible.push_back(way);
    }
    EXPECT_GE(found[i].photos, int(faced.size())) << i;
    EXPECT_LE(found[i].photos, int(possible.size())) << i;
    EXPECT_GE(found[i].widest_deg, widest(faced) - 1e-4) << i;
    EXPECT_LE(found[i].widest_deg, widest(possible) + 1e-4) << i;
    certain += faced.size() > 1, unseen += possible.empty();
  }
  EXPECT_GT(certain, 500u);
  EXPECT_GT(unseen, 5u) << "no camera looks at the ball from below";
}

// A screen between the ball and one camera takes that photo from it; a screen of glass does not.
TEST(PhotoCoverage, IsLessBehindAScreenAndTheSameBehindGlass) {
  const test::TinyCapture capture;
  const std::vector<View> photo{capture.views[0]};
  const Vec3d eye = photo[0].centre_in_world();
  TrainedScene scene;
  scene.image.transmission.glass = Glass::Thin;
  scene.surfels.transmittance =
      SplatLayer(LayerKind::Transmittance, 0, 1);  // far away: with it, glass stands apart from the rest
  scene.surfels.transmittance.at(Attribute::Mean, 0)[0] = -50;
  scene.surfels.transmittance.at(Attribute::Rotation, 0)[0] = 1;
  const auto seen_of_the_ball = [&](float transmission) {
    scene.surfels.diffuse = capture.layer;
    SplatLayer& all = scene.surfels.diffuse;
    const size_t screen = all.size();
    for (size_t i = 0; i < screen; ++i) *all.at(Attribute::Transmission, i) = -4;
    all.resize(screen + 1);
    for (size_t c = 0; c < 3; ++c) all.at(Attribute::Mean, screen)[c] = float(0.7 * eye[c]);
    const Quatd q = quaternion(inverse(photo[0].cam_from_world).rotation);
    const float rotation[] = {float(q.w), float(q.x), float(q.y), float(q.z)};
    std::ranges::copy(rotation, all.at(Attribute::Rotation, screen));
    for (size_t c = 0; c < 2; ++c) all.at(Attribute::LogScale, screen)[c] = 1;
    *all.at(Attribute::Opacity, screen) = 20;
    *all.at(Attribute::Transmission, screen) = transmission;
    const PageSurfels surfels = page_surfels(scene, std::vector<Vec3d>{eye}, 5000);
    const auto found = page_coverage(surfels, photo, 0.01f);
    size_t seen = 0;
    for (size_t i = 0; i < found.size(); ++i) seen += surfels.of_diffuse[i] < screen && found[i].photos > 0;
    return seen;
  };
  const size_t behind_glass = seen_of_the_ball(4);
  EXPECT_GT(behind_glass, 300u);
  EXPECT_LT(behind_glass, 1100u) << "the far side";
  EXPECT_EQ(seen_of_the_ball(-4), 0u);
}

TEST(PhotoCoverage, IsAByteOfBoth) {
  EXPECT_EQ(coverage_byte({0, 0}), 0);
  EXPECT_EQ(coverage_byte({3, 29.9}), 8 * 3 + 2);
  EXPECT_EQ(coverage_byte({12, 60}), 8 * 12 + 6);
  EXPECT_EQ(coverage_byte({300, 175}), 8 * 12 + 6);
}

// Glass whose shape is known is drawn from it; the surfels that carry it for other programs stay out.
TEST(PageSurfels, GlassStandsBehindTheRestUnlessItsShapeIsKnown) {
  TrainedScene scene;
  scene.surfels.diffuse = test::sphere_layer(0.4, 100);
  for (size_t i = 0; i < 30; ++i) *scene.surfels.diffuse.at(Attribute::Transmission, i) = 4;
  for (size_t i = 30; i < 100; ++i) *scene.surfels.diffuse.at(Attribute::Transmission, i) = -4;
  scene.surfels.transmittance = SplatLayer(LayerKind::Transmittance, 0, 5);
  scene.surfels.reflection = SplatLayer(LayerKind::Reflection, 0, 7);
  scene.image.transmission.glass = Glass::Thin;
  const std::vector<Vec3d> eyes{{1, 0, 0}};
  const PageSurfels open = page_surfels(scene, eyes, 1000);
  EXPECT_EQ(open.solid, 75u);
  EXPECT_EQ(open.drawn, 105u);
  EXPECT_EQ(open.layer.size(), 112u);
  size_t inside = 0;
  for (size_t k = 0; k < open.solid; ++k) inside += (open.flags[k] & kInsideSurfel) != 0;
  EXPECT_EQ(inside, 5u);
  auto set = std::make_shared<ShapeSet>();
  set->entries.push_back(
      {.shape = Box{Mat3d::identity(), {-1, -1, -1}, {1, 1, 1}}, .role = ShapeRole::Sheet, .tolerance = 0.02, .clear = {}});
  scene.image.shape.set = set;
  const PageSurfels shaped = page_surfels(scene, eyes, 1000);
  EXPECT_EQ(shaped.drawn, shaped.solid);
  EXPECT_EQ(shaped.solid, 75u);
}

TEST(PageShapes, FacesOfABoxKnowTheirPlanes) {
  ShapeSet set;
  set.entries.push_back({.shape = Box{Mat3d::identity(), {-1, -1, -1}, {1, 1, 1}},
                         .role = ShapeRole::Sheet,
                         .tolerance = 0.02,
                         .clear = {1, 1, 1, 1, 0, 1},
                         .object = 3});
  PageBlocks blocks;
  const auto shapes = add_shapes(&set, blocks);
  ASSERT_EQ(shapes["facets"].size(), 6u);
  EXPECT_EQ(shapes["entries"][0]["role"], "sheet");
  EXPECT_EQ(shapes["entries"][0]["object"], 3);
  EXPECT_FALSE(shapes["facets"][4]["clear"]);
  EXPECT_NEAR(shapes["facets"][5]["at_pane"].get<double>(), 0.008, 1e-9);
  EXPECT_EQ(blocks.directory()[3]["name"], "shape_corner");
  EXPECT_EQ(blocks.directory()[3]["count"], 36);
  set.entries[0].role = ShapeRole::Solid;
  PageBlocks of_solid;
  EXPECT_EQ(add_shapes(&set, of_solid)["entries"][0]["role"], "sheet") << "the page knows no other glass";
  PageBlocks none;
  EXPECT_TRUE(add_shapes(nullptr, none)["entries"].empty());
}

}  // namespace
}  // namespace vitrine
