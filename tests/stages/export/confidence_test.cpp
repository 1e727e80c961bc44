// Confidence in exported files: of a ball whose upper half has other colours in the training photos than in the scene.
#include <cmath>
#include <cstring>
#include <sstream>

#include <gtest/gtest.h>

#include "stages/export/export.h"
#include "tests/stages/export/glb_reader.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiny_capture.h"

namespace vitrine {
namespace {

using test::RecordingContext;
using test::TinyCapture;

class ExportedConfidence : public testing::Test {
 protected:
  ExportedConfidence() {
    SplatLayer wrong = capture_.layer;
    for (size_t i = 0; i < wrong.size(); ++i)
      if (wrong.at(Attribute::Mean, i)[2] > 0)
        for (size_t c = 0; c < 3; ++c) wrong.at(Attribute::ShDc, i)[c] += wrong.at(Attribute::ShDc, i)[c] > 0 ? -1.2f : 1.2f;
    write_layer(capture_.optimize() / "gaussians/diffuse.ply", wrong);
  }

  fs::path written(RecordingContext& context, const std::string& format) {
    run_export({.formats = {format}}, context);
    return context.output() / "export";
  }

  // Mean confidence of the vertices above and below the middle.
  void expect_low_above(const std::vector<float>& height, const std::vector<float>& confidence) {
    ASSERT_EQ(height.size(), confidence.size());
    double above = 0, below = 0, n_above = 0, n_below = 0;
    for (size_t i = 0; i < height.size(); ++i) {
      EXPECT_GE(confidence[i], 0);
      EXPECT_LE(confidence[i], 1);
      if (height[i] > 0.1f && height[i] < 0.3f) above += confidence[i], ++n_above;
      if (height[i] < -0.1f && height[i] > -0.2f) below += confidence[i], ++n_below;
    }
    ASSERT_GT(n_above, 20);
    ASSERT_GT(n_below, 20);
    EXPECT_LT(above / n_above, 0.6 * below / n_below);
  }

  TinyCapture capture_;
};

TEST_F(ExportedConfidence, IsAPropertyOfTheVerticesOfThePly) {
  RecordingContext context(capture_.inputs(false));
  const std::string bytes = read_file(written(context, "mesh-ply") / "mesh.ply");
  const size_t end = bytes.find("end_header\n") + 11;
  std::istringstream header(bytes.substr(0, end));
  size_t vertices = 0, stride = 0, place = 0, properties = 0;
  for (std::string line; std::getline(header, line);) {
    std::istringstream words(line);
    std::string word, type, name;
    words >> word >> type >> name;
    if (word == "element" && type == "vertex") vertices = std::stoul(name);
    if (word != "property" || type == "list") continue;
    if (name == "confidence") place = stride, ++properties;
    stride += type == "float" ? 4 : type == "ushort" ? 2 : 1;
  }
  ASSERT_EQ(properties, 1u);
  std::vector<float> height(vertices), confidence(vertices);
  for (size_t i = 0; i < vertices; ++i) {
    std::memcpy(&height[i], bytes.data() + end + i * stride + 8, 4);
    std::memcpy(&confidence[i], bytes.data() + end + i * stride + place, 4);
  }
  expect_low_above(height, confidence);
}

TEST_F(ExportedConfidence, IsAnAttributeOfTheGlb) {
  RecordingContext context(capture_.inputs(false));
  const test::Glb glb(written(context, "mesh-glb") / "mesh.glb");
  const auto& attributes = glb.doc["meshes"][0]["primitives"][0]["attributes"];
  ASSERT_TRUE(attributes.contains("_CONFIDENCE"));
  const std::vector<float> positions = glb.positions(attributes["POSITION"]);
  std::vector<float> height;  // +Y is up
  for (size_t i = 1; i < positions.size(); i += 3) height.push_back(positions[i]);
  expect_low_above(height, glb.floats(attributes["_CONFIDENCE"], "SCALAR"));
}

TEST_F(ExportedConfidence, IsAbsentWithoutTheTrainingPhotos) {
  fs::remove(linear_image_path(capture_.sfm(), capture_.views[3]));
  RecordingContext context(capture_.inputs(false));
  const std::string bytes = read_file(written(context, "mesh-ply") / "mesh.ply");
  EXPECT_EQ(bytes.substr(0, bytes.find("end_header")).find("confidence"), std::string::npos);
}

}  // namespace
}  // namespace vitrine
