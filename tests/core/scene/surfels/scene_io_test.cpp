#include "core/scene/surfels/splat_scene.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/foundation/base/file.h"
#include "core/foundation/base/rng.h"

namespace vitrine {
namespace {

SplatLayer random_layer(LayerKind kind, int sh_degree, size_t size) {
  SplatLayer layer(kind, sh_degree, size);
  Rng rng(7, static_cast<uint64_t>(kind));
  for (const AttributeRow& r : kAttributes)
    for (float& v : layer.values(r.id)) v = 4 * rng.normal();
  return layer;
}

std::string error_of_reading(const fs::path& path) {
  try {
    read_layer(path);
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    EXPECT_EQ(e.detail().where, path.string());
    return e.what();
  }
  return "no error";
}

class SceneFile : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  fs::path path_ = folder_.path() / "ein Ordner/ü.ply";
  void write_changed(const std::string& from, const std::string& to) {
    write_layer(path_, random_layer(LayerKind::Diffuse, 1, 5));
    std::string bytes = read_file(path_);
    const size_t at = bytes.find(from);
    ASSERT_NE(at, std::string::npos);
    write_file(path_, bytes.replace(at, from.size(), to));
  }
};

TEST_F(SceneFile, KeepsEveryBitOfEveryLayerAndDegree) {
  for (LayerKind kind : kAllLayers)
    for (int degree = 0; degree <= 3; ++degree) {
      const SplatLayer layer = random_layer(kind, degree, 17);
      write_layer(path_, layer);
      EXPECT_EQ(read_layer(path_), layer) << name(kind) << " degree " << degree;
    }
}

TEST_F(SceneFile, KeepsAnEmptyLayer) {
  write_layer(path_, SplatLayer(LayerKind::Diffuse, 2, 0));
  EXPECT_EQ(read_layer(path_).size(), 0u);
}

TEST_F(SceneFile, NamesTheMeanXyzForOtherReaders) {
  write_layer(path_, random_layer(LayerKind::Diffuse, 1, 2));
  EXPECT_NE(read_file(path_).find("property float x\nproperty float y\nproperty float z\n"), std::string::npos);
}

TEST_F(SceneFile, EveryShorterFileIsRefused) {
  write_layer(path_, random_layer(LayerKind::Diffuse, 0, 2));
  const std::string bytes = read_file(path_);
  for (size_t size = 0; size < bytes.size(); ++size) {
    write_file(path_, std::string_view(bytes).substr(0, size));
    ASSERT_NE(error_of_reading(path_), "no error") << size << " of " << bytes.size() << " bytes";
  }
}

TEST_F(SceneFile, LongerFileIsRefused) {
  write_layer(path_, random_layer(LayerKind::Diffuse, 0, 2));
  write_file(path_, read_file(path_) + "x");
  EXPECT_NE(error_of_reading(path_).find("bytes"), std::string::npos);
}

TEST_F(SceneFile, AbsurdCountIsRefusedBeforeMemoryIsTaken) {
  write_changed("element vertex 5", "element vertex 2000000000");
  EXPECT_NE(error_of_reading(path_).find("2000000000"), std::string::npos);
  write_changed("element vertex 5", "element vertex 99999999999999999999");
  EXPECT_NE(error_of_reading(path_), "no error");
  write_changed("element vertex 5", "element vertex -5");
  EXPECT_NE(error_of_reading(path_), "no error");
}

TEST_F(SceneFile, UnknownLayerDegreeVersionAndPropertyAreRefused) {
  write_changed("vitrine_layer diffuse", "vitrine_layer diffise");
  EXPECT_NE(error_of_reading(path_).find("diffise"), std::string::npos);
  write_changed("sh_degree 1", "sh_degree 4");
  EXPECT_NE(error_of_reading(path_), "no error");
  write_changed("vitrine_format 1", "vitrine_format 9");
  EXPECT_NE(error_of_reading(path_).find("9"), std::string::npos);
  write_changed("property float opacity", "property float opaqueness");
  EXPECT_NE(error_of_reading(path_).find("opaqueness"), std::string::npos);
}

TEST_F(SceneFile, NonFiniteValueIsRefused) {
  SplatLayer layer = random_layer(LayerKind::Diffuse, 1, 3);
  layer.at(Attribute::Opacity, 1)[0] = std::numeric_limits<float>::quiet_NaN();
  write_layer(path_, layer);
  EXPECT_NE(error_of_reading(path_).find("opacity of surfel 1"), std::string::npos);
}

TEST_F(SceneFile, MissingFileAndOtherFormatsAreRefused) {
  EXPECT_NE(error_of_reading(folder_.path() / "none.ply"), "no error");
  write_file(path_, "ply\nformat ascii 1.0\nend_header\n");
  EXPECT_NE(error_of_reading(path_).find("binary little-endian"), std::string::npos);
}

}  // namespace
}  // namespace vitrine
