// The objects of one generated scene in another: the truth that compositions are measured against.
#include "sample_data/generate/guest.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/error.h"

namespace vitrine::generate {
namespace {

Scene with_plate(bool object) {
  Scene scene;
  scene.parts.push_back({.name = "plate",
                         .shape = rectangle({0.2f, 0, 0.1f}, {1, 0, 0}, {0, 1, 0}, 2),
                         .material = {.albedo = [](const SurfacePoint& at) { return at.position; }},
                         .object = object});
  scene.parts.push_back({.name = "floor", .shape = rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 2)});
  return scene;
}

TEST(Guest, StandsWhereThePlacePutsItWithItsTexture) {
  Scene host = with_plate(true);
  add_guest(host, with_plate(true), guest_place("3,-2,90,0.5"));
  ASSERT_EQ(host.parts.size(), 3u);  // the guest's floor stays at home
  const Part& guest = host.parts.back();
  EXPECT_EQ(guest.name, "guest_plate");
  const Vec3f corner = guest.shape.mesh.positions.front();  // (0.2, 0, 0.1) turned to (0, 0.2, 0.1), halved, moved
  EXPECT_NEAR(corner.x, 3, 1e-6f);
  EXPECT_NEAR(corner.y, -1.9f, 1e-6f);
  EXPECT_NEAR(corner.z, 0.05f, 1e-6f);
  const Vec3f albedo = guest.material.albedo({.position = corner, .normal = {0, 0, 1}, .uv = {}});
  EXPECT_NEAR(albedo.x, 0.2f, 1e-5f);
  EXPECT_NEAR(albedo.y, 0, 1e-5f);
  EXPECT_NEAR(albedo.z, 0.1f, 1e-5f);
}

TEST(Guest, IsTheOnlyObject) {
  Scene host = with_plate(true);
  add_guest(host, with_plate(true), {});
  EXPECT_FALSE(host.parts[0].object);
  EXPECT_TRUE(host.parts.back().object);
}

TEST(Guest, PlaceOfTheWrongFormIsRefused) {
  for (const char* text : {"", "1,2,3", "1,2,3,0", "1,2,3,-1", "1,2,3,1,5", "1,2,x,1", "1,2,nan,1"})
    EXPECT_THROW(guest_place(text), Error) << text;
}

}  // namespace
}  // namespace vitrine::generate
