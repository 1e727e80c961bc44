// Masks from a network: what its numbers mean is as declared, photos overrule each other, and what cannot be run is refused with
// the reason. The networks are single operators, so that their answer is known: what goes in comes out.
#include <gtest/gtest.h>

#include "core/foundation/base/hash.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/parallel.h"
#include "stages/masks/masks.h"
#include "tests/stages/masks/ball_capture.h"
#include "tests/stages/normals/tiny_onnx.h"
#include "tests/support/error_of.h"
#include "tests/support/settings_files.h"

namespace vitrine {
namespace {

using namespace test;

// Two pixels with three channels each.
NetworkOutput answer(std::vector<float> values, bool planes = true) {
  return {.channels = 3, .width = 2, .height = 1, .planes = planes, .values = std::move(values), .shape = "1 x 3 x 1 x 2"};
}

std::vector<float> values_of(const NetworkOutput& out, NetworkActivation activation, std::vector<double> channels,
                             double threshold = 0.5) {
  NetworkMasksConfig config{.outputs = out.channels, .activation = activation, .threshold = threshold};
  return class_values(out, config, channels, "net.onnx");
}

TEST(ClassValues, AreWhatTheActivationSays) {
  const NetworkOutput out = answer({0, 2, -1, 1, 3, -2});  // pixel 0: 0 -1 3, pixel 1: 2 1 -2
  const auto sigmoid = [](double x) { return 1 / (1 + std::exp(-x)); };
  const auto softmax = [](double x, double a, double b) { return std::exp(x) / (std::exp(x) + std::exp(a) + std::exp(b)); };
  const auto near = [](const std::vector<float>& found, double a, double b) {
    EXPECT_NEAR(found.at(0), std::clamp(2 * a - 0.5, 0.0, 1.0), 1e-6);
    EXPECT_NEAR(found.at(1), std::clamp(2 * b - 0.5, 0.0, 1.0), 1e-6);
  };
  near(values_of(out, NetworkActivation::Sigmoid, {1}), sigmoid(-1), sigmoid(1));
  near(values_of(out, NetworkActivation::Sigmoid, {0, 2}), sigmoid(3), sigmoid(2));  // the larger one
  near(values_of(out, NetworkActivation::Softmax, {0}), softmax(0, -1, 3), softmax(2, 1, -2));
  near(values_of(out, NetworkActivation::Softmax, {0, 1}), 1 - softmax(3, 0, -1), 1 - softmax(-2, 2, 1));
  near(values_of(out, NetworkActivation::Softmax, {0, 1, 2}), 1, 1);
  near(values_of(out, NetworkActivation::Argmax, {2}), 1, 0);
  near(values_of(out, NetworkActivation::Argmax, {0, 1}), 0, 1);
  near(values_of(out, NetworkActivation::Probability, {1}), 0, 1);  // clamped
  near(values_of(answer({0, -1, 3, 2, 1, -2}, false), NetworkActivation::Sigmoid, {1}), sigmoid(-1), sigmoid(1));
  const NetworkOutput labels{.channels = 1, .width = 2, .height = 1, .values = {7, 2}, .shape = "1 x 1 x 2"};
  near(values_of(labels, NetworkActivation::Labels, {7, 9}), 1, 0);
}

TEST(ClassValues, ThresholdBecomesOneHalf) {
  const NetworkOutput out = answer({0.3f, 0.475f, 0.1f, 0.9f, 0, 0});
  const auto soft = values_of(out, NetworkActivation::Probability, {0}, 0.3);
  EXPECT_NEAR(soft[0], 0.5, 1e-6);
  EXPECT_NEAR(soft[1], 0.75, 1e-6);
  EXPECT_EQ(values_of(out, NetworkActivation::Probability, {1}, 0.3), (std::vector<float>{0, 1}));  // 0.1 and 0.9 are decided
  const NetworkOutput broken = answer({0, NAN, 0, 0, 0, 0});
  const Error e = error_of([&] { values_of(broken, NetworkActivation::Sigmoid, {0}); });
  EXPECT_EQ(e.detail().code, "BAD_NETWORK_OUTPUT");
}

class Networked : public testing::Test, public BallCapture {
 protected:
  // Its answer is the photo, so that what is red (0.8 and more in sRGB) is the class of channel 0.
  Networked() { put(one_operator_network("Relu", kWidth, kHeight)); }
  void put(std::string_view content) const { write_file(file(), content); }
  fs::path file() const { return folder.path() / "net.onnx"; }
  std::unique_ptr<RecordingContext> run(std::vector<std::pair<const char*, const char*>> extra = {}, bool given = true) const {
    std::map<std::string, fs::path> inputs{{"sfm", sfm()}};
    if (given) inputs["mask_network"] = file();
    auto context = std::make_unique<RecordingContext>(inputs);
    Stage stage = masks_stage();
    std::vector<std::pair<const char*, const char*>> options{{"onnx.width", "96"},     {"onnx.height", "72"},
                                                             {"onnx.outputs", "3"},    {"onnx.activation", "probability"},
                                                             {"onnx.specular", "[0]"}, {"onnx.threshold", "0.7"}};
    options.insert(options.end(), extra.begin(), extra.end());
    for (const auto& [option, value] : options) stage.options.find(option)->assign(value, "test");
    EXPECT_EQ(stage.problem(), "");
    stage.run(*context);
    return context;
  }
  static nlohmann::json report_of(const RecordingContext& context) {
    return nlohmann::json::parse(read_file(context.output() / "masks/report.json"));
  }
  static std::string problem(const char* option, const char* value, const char* other = nullptr, const char* other_value = "") {
    Stage stage = masks_stage();
    stage.options.find(option)->assign(value, "test");
    if (other != nullptr) stage.options.find(other)->assign(other_value, "test");
    return stage.problem();
  }
};

TEST_F(Networked, MasksAreWhatItFindsWithoutFurtherWord) {
  const auto context = run();
  EXPECT_GT(worst_overlap(*context, "specular"), 0.97);  // voted: the hull's edge is its own
  const auto report = report_of(*context);
  EXPECT_EQ(report["classes"]["specular"]["source"], "onnx");
  EXPECT_EQ(report["classes"]["specular"]["network"]["sha256"], sha256_hex(read_file(file())));
  EXPECT_TRUE(report["classes"]["specular"]["voted"].get<bool>());
  EXPECT_EQ(report["classes"]["transparent"]["source"], "none");  // nothing is proposed beside a network
}

TEST_F(Networked, PhotosOverruleOneThatIsWrong) {
  // One photo without the ball, one with something else beside it.
  write_photo(2, Image8(kWidth, kHeight, 1));
  Image8 more = truth[6];
  for (int y = 4; y < 20; ++y)
    for (int x = 4; x < 20; ++x) more.at(x, y) = 255;
  write_photo(6, more);
  const auto voted = run();
  EXPECT_GT(overlap_of(*voted, "specular", 6), 0.95);  // measured 0.968, 0.893 alone
  EXPECT_GT(worst_overlap(*voted, "specular"), 0.88);
  const Image8 sure = read_grey8(voted->output() / "masks/confidence/v6.png");
  EXPECT_LT(sure.at(10, 10), 80);   // overruled
  EXPECT_GT(sure.at(90, 60), 110);  // agreed
}

TEST_F(Networked, MasksThatMeetNowhereStayAsTheyAre) {
  // Spots that wander through the photos are no object in space.
  for (size_t v = 0; v < views.size(); ++v) {
    Image8 spot(kWidth, kHeight, 1);
    const int left = int(v * 8), top = int(v * 37 % 60);
    for (int y = top; y < top + 10; ++y)
      for (int x = left; x < left + 10; ++x) spot.at(x, y) = 255;
    write_photo(v, spot);
  }
  const auto context = run();
  EXPECT_FALSE(report_of(*context)["classes"]["specular"]["voted"].get<bool>());
  EXPECT_EQ(context->warnings.count("MASKS_NOT_VOTED"), 1u);
  EXPECT_EQ(read_grey8(context->output() / "masks/specular/v1.png").at(12, 40) > 127, true);
}

TEST_F(Networked, SameBytesForAnyNumberOfThreads) {
  set_thread_limit(1);
  const Digest one = digest_folder(run()->output());
  set_thread_limit(3);
  EXPECT_EQ(digest_folder(run()->output()), one);
  set_thread_limit(0);
}

TEST_F(Networked, WhatCannotBeRunIsRefusedWithTheReason) {
  const auto code = [&](std::string_view content) {
    put(content);
    const Error e = error_of([&] { run(); });
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    return e.detail().code;
  };
  EXPECT_EQ(code(""), "NOT_ONNX");
  EXPECT_EQ(code("\x89PNG\r\n\x1a\n"), "NOT_ONNX");
  EXPECT_EQ(code(one_operator_network("Relu", kWidth, kHeight).substr(0, 60)), "NOT_ONNX");
  EXPECT_EQ(code(one_operator_network("CumSum", kWidth, kHeight)), "UNSUPPORTED_OPERATOR");
  EXPECT_EQ(code(one_operator_network("GlobalAveragePool", kWidth, kHeight)), "BAD_NETWORK_OUTPUT");
  put(one_operator_network("Relu", kWidth, kHeight));
  const Error shape = error_of([&] { run({{"onnx.outputs", "5"}}); });
  EXPECT_EQ(shape.detail().code, "BAD_NETWORK_OUTPUT");
  EXPECT_NE(std::string(shape.what()).find("5 channels"), std::string::npos) << shape.what();
  EXPECT_EQ(error_of([&] { run({{"onnx.sha256", "0123"}}); }).detail().code, "WRONG_DIGEST");
  fs::remove(file());
  EXPECT_EQ(error_of([&] { run(); }).kind(), ErrorKind::Input);
  const Error none = error_of([&] { run({{"specular.source", "onnx"}}, false); });
  EXPECT_EQ(none.kind(), ErrorKind::Usage);
  EXPECT_NE(none.detail().hint.find("input.mask_network"), std::string::npos);
}

TEST_F(Networked, ContradictionsAreSaid) {
  EXPECT_NE(problem("specular.source", "onnx").find("masks.onnx.specular names none"), std::string::npos);
  EXPECT_NE(problem("onnx.object", "[1]").find("no channel of 0 to 0"), std::string::npos);
  EXPECT_NE(problem("onnx.object", "[0.5]").find("names 0.5"), std::string::npos);
  EXPECT_NE(problem("onnx.activation", "softmax").find("2 or more"), std::string::npos);
  EXPECT_NE(problem("onnx.activation", "labels", "onnx.outputs", "3").find("one number a pixel"), std::string::npos);
  EXPECT_EQ(problem("onnx.activation", "labels", "onnx.object", "[15]"), "");
  EXPECT_NE(problem("onnx.width", "64").find("masks.onnx.width"), std::string::npos);
}

TEST_F(Networked, ANetworkThatNoClassUsesIsSaid) {
  const Error unnamed = error_of([&] { run({{"onnx.specular", "[]"}}); });
  EXPECT_EQ(unnamed.kind(), ErrorKind::Usage);
  EXPECT_EQ(unnamed.detail().code, "NETWORK_UNUSED");
  EXPECT_NE(unnamed.detail().hint.find("masks.onnx.transparent"), std::string::npos);
  EXPECT_EQ(run({{"specular.source", "none"}})->warnings.count("NETWORK_UNUSED"), 1u);
  EXPECT_EQ(run()->warnings.count("NETWORK_UNUSED"), 0u);
}

TEST_F(Networked, AClassThatItNeverFindsIsSaid) {
  const auto context = run({{"onnx.specular", "[1]"}});  // nothing is that green
  EXPECT_EQ(context->warnings.count("MASKS_EMPTY"), 1u);
  EXPECT_FALSE(fs::exists(context->output() / "masks/specular"));
}

TEST(SegmenterSettings, AreAllUnderstood) { EXPECT_GE(expect_settings_understood("masks", masks_stage), 2u); }

}  // namespace
}  // namespace vitrine
