#include "stages/normals/normals.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/foundation/base/hash.h"
#include "core/foundation/base/json.h"
#include "core/observe/network/photo_network.h"
#include "tests/stages/normals/still_life.h"
#include "tests/stages/normals/tiny_onnx.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"
#include "tests/support/settings_files.h"

namespace vitrine {
namespace {

using test::degrees;
using test::one_operator_network;
using test::RecordingContext;
using test::StillLife;

const fs::path kRooms = fs::path(VITRINE_SOURCE_DIR) / "stages/normals/network/rooms.onnx";

TEST(Sha256, IsThatOfTheStandard) {
  EXPECT_EQ(sha256_hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256_hex(std::string(1000000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

// --- the network that is built in -------------------------------------------------------------------------------------------
// tests/stages/normals/rooms: pictures of core/observe/network/rooms with seeds that training never drew (README there).
TEST(BuiltInNetwork, SeesTheWallsOfRoomsItNeverSaw) {
  NormalNetwork network(std::nullopt, built_in_network_config());
  EXPECT_TRUE(network.built_in());
  EXPECT_EQ(network.sha256(), built_in_network_sha256());
  EXPECT_EQ(network.sha256(), sha256_hex(read_file(kRooms)));
  double sum = 0, sum_facing = 0, weighted = 0, weights = 0;
  size_t pixels = 0, rooms = 0;
  const fs::path folder = fs::path(VITRINE_SOURCE_DIR) / "tests/stages/normals/rooms";
  for (int i = 0;; ++i, ++rooms) {
    const fs::path photo = folder / fmt::format("room_{}.png", i), truth = folder / fmt::format("room_{}_normal.png", i);
    if (!fs::exists(photo)) break;
    const ImageF srgb = read_srgb(photo), encoded = read_unchanged(truth);
    ASSERT_EQ(network.input_size(640, 480), std::make_pair(srgb.width(), srgb.height()));
    const NormalMap map = network.predict(srgb);
    ASSERT_EQ(map.normal.width(), encoded.width());
    ASSERT_EQ(map.normal.height(), encoded.height());
    for (int y = 0; y < encoded.height(); ++y)
      for (int x = 0; x < encoded.width(); ++x) {
        const float* p = encoded.pixel(x, y);
        const Vec3f t{2 * p[0] - 1, 2 * p[1] - 1, 2 * p[2] - 1};
        const double angle = degrees(map.at(x, y), t), sure = double(map.confidence.at(x, y));
        sum += angle;
        weighted += sure * angle, weights += sure;
        sum_facing += degrees({0, 0, -1}, t);  // what one gets without looking
        ++pixels;
      }
  }
  ASSERT_EQ(rooms, 8u);
  const double mean = sum / double(pixels), blind = sum_facing / double(pixels);
  RecordProperty("mean_deg", std::to_string(mean));
  EXPECT_LT(mean, 17);  // seen: 15.97; facing the camera everywhere would be 52
  EXPECT_LT(mean, 0.6 * blind) << blind;
  EXPECT_LT(weighted / weights, mean);  // where it is sure it is better
}

// --- networks of other people ------------------------------------------------------------------------------------------------
TEST(OnnxGraph, ListsTheOperatorsOfARealFile) {
  const auto operators = onnx_operators(read_file(kRooms), "rooms");
  EXPECT_TRUE(operators.contains("Conv"));
  EXPECT_TRUE(operators.contains("Resize"));
  EXPECT_TRUE(unsupported_operators(operators).empty());
  EXPECT_EQ(unsupported_operators({"Conv", "CumSum", "MatMul"}), (std::vector<std::string>{"CumSum", "MatMul"}));
}

struct Network {
  TemporaryFolder folder;
  fs::path file = folder.path() / "net.onnx";
  explicit Network(std::string_view content) { write_file(file, content); }
};

Error refusal(std::string_view content, OnnxConfig config = {}, int width = 64, int height = 48) {
  const Network file(content);
  return error_of([&] {
    NormalNetwork network(file.file, config);
    network.predict(ImageF(width, height, 3, 0.5f));
  });
}

TEST(GivenNetwork, IsRefusedWithTheReasonWhenItCannotBeRun) {
  const std::string rooms = read_file(kRooms), relu = one_operator_network("Relu", 64, 48);
  EXPECT_EQ(refusal("").detail().code, "NOT_ONNX");
  EXPECT_EQ(refusal("weights of some other kind, as text").detail().code, "NOT_ONNX");
  EXPECT_EQ(refusal(rooms.substr(0, rooms.size() / 2)).detail().code, "NOT_ONNX");
  EXPECT_EQ(refusal("\x89PNG\r\n\x1a\n").detail().code, "NOT_ONNX");
  const Error crash = refusal(one_operator_network("CumSum", 64, 48));
  EXPECT_EQ(crash.detail().code, "UNSUPPORTED_OPERATOR");
  EXPECT_NE(crash.detail().why.find("CumSum"), std::string::npos);
  EXPECT_EQ(refusal(one_operator_network("Conv", 64, 48)).detail().code, "UNSUPPORTED_NETWORK");  // without weights
  EXPECT_EQ(refusal(one_operator_network("GlobalAveragePool", 64, 48)).detail().code, "BAD_NETWORK_OUTPUT");
  EXPECT_EQ(refusal(relu, {.doubt = NormalDoubt::Kappa}).detail().code, "BAD_NETWORK_OUTPUT");
  const Error digest = refusal(relu, {.input = {.sha256 = std::string(64, '0')}});
  EXPECT_EQ(digest.detail().code, "WRONG_DIGEST");
  EXPECT_NE(digest.detail().why.find(sha256_hex(relu)), std::string::npos);
  for (const Error& e : {crash, digest}) EXPECT_EQ(e.kind(), ErrorKind::Input);
  EXPECT_EQ(error_of([] { NormalNetwork("/no/such/file.onnx", {}); }).kind(), ErrorKind::Input);
}

TEST(GivenNetwork, TakesChannelsMeanAndEncodingAsDeclared) {
  // Relu of what goes in: what comes out tells what went in.
  const Network file(one_operator_network("Relu", 64, 48));
  ImageF photo(64, 48, 3);
  for (size_t i = 0; i < photo.pixel_count(); ++i)
    photo.data()[3 * i] = 0.9f, photo.data()[3 * i + 1] = 0.5f, photo.data()[3 * i + 2] = 0.4f;
  const auto first = [&](const OnnxConfig& config) { return NormalNetwork(file.file, config).predict(photo).at(5, 7); };
  const auto near = [](const Vec3f& a, const Vec3f& b) { return length(a - normalized(b)) < 1e-5f; };
  EXPECT_TRUE(near(first({}), {0.9f, 0.5f, 0.4f}));
  EXPECT_TRUE(near(first({.input = {.channels = ChannelOrder::Bgr}}), {0.4f, 0.5f, 0.9f}));
  EXPECT_TRUE(near(first({.output = NormalEncoding::Rgb}), {0.8f, 0.f, -0.2f}));
  EXPECT_TRUE(near(first({.input = {.mean = {0.1, 0.1, 0.1}, .deviation = {1, 2, 0.5}}}), {0.8f, 0.2f, 0.6f}));
  EXPECT_EQ(NormalNetwork(file.file, {.input = {.max_side = 64, .multiple = 16}}).input_size(4000, 3000), std::make_pair(64, 48));
  EXPECT_EQ(NormalNetwork(file.file, {.input = {.width = 32, .height = 40}}).input_size(4000, 3000), std::make_pair(32, 40));
}

// Photos that are pictures of their own normals, and a network that hands them through: the whole stage with a known answer.
TEST(GivenNetwork, MakesTheMapsOfTheStage) {
  const StillLife life(4);
  for (size_t v = 0; v < life.views.size(); ++v) {
    ImageF srgb(StillLife::kWidth, StillLife::kHeight, 3);
    for (int y = 0; y < srgb.height(); ++y)
      for (int x = 0; x < srgb.width(); ++x) {
        const Vec3f n = life.normal(v, x + 0.5, y + 0.5);
        for (size_t c = 0; c < 3; ++c) srgb.at(x, y, int(c)) = (n[c] + 1) / 2;
      }
    write_exr_rgb(linear_image_path(life.sfm(), life.views[v]), linear_from_srgb_image(srgb), ExrPrecision::Float);
  }
  const Network file(one_operator_network("Relu", StillLife::kWidth, StillLife::kHeight));
  const auto run = [&](int threads) {
    set_thread_limit(threads);
    auto context =
        std::make_unique<RecordingContext>(std::map<std::string, fs::path>{{"sfm", life.sfm()}, {"network", file.file}});
    Stage stage = normals_stage();
    for (const auto& [option, value] :
         {std::pair{"onnx.space", "camera-opencv"}, {"onnx.width", "96"}, {"onnx.height", "72"}, {"onnx.output", "rgb"}})
      stage.options.find(option)->assign(value, "test");
    stage.run(*context);
    set_thread_limit(0);
    return context;
  };
  const auto context = run(1);
  const fs::path normals = context->output() / "normals";
  const auto report = nlohmann::json::parse(read_file(normals / "report.json"));
  EXPECT_EQ(report["source"], "onnx");
  EXPECT_EQ(report["network"]["sha256"], sha256_hex(read_file(file.file)));
  EXPECT_FALSE(report["network"]["built_in"].get<bool>());
  double worst = 0;
  for (size_t v = 0; v < life.views.size(); ++v) {
    const ExrImage map = read_exr(normals / (life.views[v].stem() + ".exr"));
    for (int y = 0; y < StillLife::kHeight; ++y)
      for (int x = 0; x < StillLife::kWidth; ++x) {
        if (life.at(v, x + 0.5, y + 0.5).surface == StillLife::Nothing) continue;
        const float* p = map.pixels.pixel(x, y);
        ASSERT_GT(squared_length(Vec3f{p[0], p[1], p[2]}), 0.9f) << x << " " << y;
        worst = std::max(worst, degrees({p[0], p[1], p[2]}, life.normal(v, x + 0.5, y + 0.5)));
      }
  }
  EXPECT_LT(worst, 0.2);
  EXPECT_EQ(digest_folder(normals), digest_folder(run(3)->output() / "normals"));
}

TEST(PredictorSettings, AreAllUnderstood) {
  const auto chooses_a_source = [](const Stage& stage) { EXPECT_NE(stage.options.find("source")->text(), "auto"); };
  EXPECT_GE(test::expect_settings_understood("normals", normals_stage, chooses_a_source), 4u);
  Stage stage = normals_stage();
  stage.options.find("onnx.width")->assign("384", "test");
  EXPECT_NE(stage.problem(), "");
}

}  // namespace
}  // namespace vitrine
