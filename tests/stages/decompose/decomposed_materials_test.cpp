#include "core/render/picture/decomposed_materials.h"

#include <gtest/gtest.h>

#include "core/foundation/base/file.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

TEST(DecomposedMaterials, RoundTripAndDamage) {
  const TemporaryFolder folder;
  DecomposedMaterials m;
  m.resize(2);
  m.albedo = {{0.1f, 0.2f, 0.3f}, {0.4f, 0.5f, 0.6f}};
  m.f0 = {{0.04f, 0.05f, 0.06f}, {1, 1, 1}};
  m.roughness = {0.3f, 0}, m.specular_weight = {0.5f, 0.25f}, m.transmission = {0, 1};
  write_decomposed_materials(folder.path(), m);
  const DecomposedMaterials back = read_decomposed_materials(folder.path());
  EXPECT_EQ(back.albedo, m.albedo);
  EXPECT_EQ(back.f0, m.f0);
  EXPECT_EQ(back.roughness, m.roughness);
  EXPECT_EQ(back.specular_weight, m.specular_weight);
  EXPECT_EQ(back.transmission, m.transmission);
  EXPECT_TRUE(back.albedo_behind_glass.empty());
  const auto expect_damage_is_noticed = [&] {
    const fs::path path = decomposed_materials_path(folder.path());
    const std::string good = read_file(path);
    std::string not_a_number = good;
    for (size_t i = good.size() - 4; i < good.size(); ++i) not_a_number[i] = char(0xff);
    for (const std::string& bad :
         {good.substr(0, good.size() - 3), good + "x", std::string("ply\n"), std::string(), not_a_number}) {
      write_file(path, bad);
      EXPECT_EQ(error_of([&] { read_decomposed_materials(folder.path()); }).kind(), ErrorKind::Input);
    }
  };
  expect_damage_is_noticed();
  m.albedo_behind_glass = {{0.2f, 0.3f, 0.4f}, {0, 1, 0}, {0.5f, 0.5f, 0.25f}};
  write_decomposed_materials(folder.path(), m);
  const DecomposedMaterials both = read_decomposed_materials(folder.path());
  EXPECT_EQ(both.albedo, m.albedo);
  EXPECT_EQ(both.transmission, m.transmission);
  EXPECT_EQ(both.albedo_behind_glass, m.albedo_behind_glass);
  expect_damage_is_noticed();
}

}  // namespace
}  // namespace vitrine
