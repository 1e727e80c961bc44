#include "stages/relight/metals.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/light/environment.h"
#include "stages/relight/light_solver.h"
#include "tests/evaluate/tiny_capture.h"

namespace vitrine {
namespace {

// A ball that shows the light around it times a copper's reflectance.
class Kettle {
 public:
  static constexpr Vec3f kCopper{0.9f, 0.6f, 0.45f};

  explicit Kettle(const Vec3f& light) : light_(light) {
    scene.surfels.diffuse = capture.layer;
    for (const View& v : capture.views) {
      ImageF photo(v.intrinsics.width, v.intrinsics.height, 3);
      for (size_t i = 0; i < photo.data().size(); ++i) photo.data()[i] = float(v.gain[i % 3]) * kCopper[i % 3] * light[i % 3];
      write_exr_rgb(linear_image_path(capture.sfm(), v), photo, ExrPrecision::Float);
    }
  }
  Metals metals(float masked = 1) const {
    ImageF map(16, 8, 3);
    for (size_t i = 0; i < map.data().size(); ++i) map.data()[i] = light_[i % 3];
    const Environment environment(map);
    return find_metals({.sfm_folder = capture.sfm(),
                        .scene = scene,
                        .views = capture.views,
                        .environment = environment,
                        .mirrors = [&](const View&, const Intrinsics& k) { return ImageF(k.width, k.height, 1, masked); },
                        .cell = 0.05f,
                        .reach = 0.05f});
  }

  test::TinyCapture capture;
  TrainedScene scene;

 private:
  Vec3f light_;
};

TEST(Metals, CopperIsCopperUnderAnyLight) {
  for (const Vec3f& light : {Vec3f{0.5f, 0.5f, 0.5f}, Vec3f{0.3f, 0.5f, 0.9f}}) {
    const Kettle kettle(light);
    const Metals found = kettle.metals();
    ASSERT_EQ(found.metals.size(), 1u);
    const Vec3f tint = found.metals[0].tint;
    EXPECT_NEAR(luminance(tint), 1, 1e-4);
    EXPECT_NEAR(tint.y / tint.x, 0.6 / 0.9, 0.01);
    EXPECT_NEAR(tint.z / tint.x, 0.45 / 0.9, 0.01);
    EXPECT_GT(std::ranges::count(found.of_surfel, 0), std::ptrdiff_t(found.of_surfel.size() / 2));
  }
}

TEST(Metals, WithoutEvidenceThereIsNone) {
  Kettle kettle({0.5f, 0.5f, 0.5f});
  EXPECT_TRUE(kettle.metals(0).metals.empty());
  EXPECT_TRUE(std::ranges::all_of(kettle.metals(0).of_surfel, [](int m) { return m < 0; }));
  // Marked, but it never learnt to reflect.
  std::ranges::fill(kettle.scene.surfels.diffuse.values(Attribute::SpecularWeight), -6.f);
  std::ranges::fill(kettle.scene.surfels.diffuse.values(Attribute::F0), -3.f);
  EXPECT_TRUE(kettle.metals().metals.empty());
  EXPECT_TRUE(std::ranges::all_of(kettle.metals().of_surfel, [](int m) { return m < 0; }));
}

TEST(Metals, ATintKeepsHowMuchIsReflected) {
  const Vec3f tint = Kettle::kCopper / luminance(Kettle::kCopper);
  for (const LayerBlend blend : {LayerBlend::RtrGs, LayerBlend::Layered}) {
    const auto reflection = [&](float k, const Vec3f& f0) {
      return layer_weights<float>(blend, {f0, k, 0, 1}, {.reflection = true}).reflection;
    };
    float k = 0.4f;
    Vec3f f0{0.3f, 0.35f, 0.4f};
    const float before = luminance(reflection(k, f0));
    tint_reflection(blend, tint, k, f0);
    const Vec3f after = reflection(k, f0);
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(after[c], before * tint[c], 1e-5);
    float faint = 0.02f;
    f0 = {0.04f, 0.04f, 0.04f};
    tint_reflection(blend, tint, faint, f0);
    EXPECT_EQ(f0, (Vec3f{0.04f, 0.04f, 0.04f}));
    EXPECT_EQ(faint, 0.02f);
    // A bright mirror reflects no more than there is.
    k = 0.9f, f0 = {0.9f, 0.9f, 0.9f};
    tint_reflection(blend, tint, k, f0);
    for (size_t c = 0; c < 3; ++c) EXPECT_LE(reflection(k, f0)[c], 1);
  }
}

}  // namespace
}  // namespace vitrine
