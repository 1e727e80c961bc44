// Which channels of an EXR are the picture, and where its pixels go.
#include <gtest/gtest.h>

#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfRgbaFile.h>
#include <ImfStandardAttributes.h>
#include <ImfTiledOutputFile.h>

#include "core/foundation/base/file.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/resample.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

std::string chosen(const std::vector<ExrPart>& parts, const std::vector<std::string>& views = {}) {
  const ExrColors c = exr_colors(parts, views);
  if (!c.refusal.empty()) return c.refusal;
  std::string text = fmt::format("{}:", c.part);
  for (const std::string& name : c.channels) text += " " + name;
  return text;
}
std::string chosen(std::vector<std::string> channels) { return chosen({ExrPart{"", "", false, std::move(channels)}}); }

std::vector<std::string> rgb_of(const std::string& prefix) { return {prefix + "B", prefix + "G", prefix + "R"}; }
std::vector<std::string> together(std::vector<std::vector<std::string>> lists) {
  std::vector<std::string> all;
  for (const auto& list : lists) all.insert(all.end(), list.begin(), list.end());
  return all;
}

TEST(ExrLayers, TheCombinedLayerIsThePicture) {
  EXPECT_EQ(chosen(rgb_of("")), "0: R G B");
  EXPECT_EQ(chosen(together({rgb_of("ViewLayer.Combined."), {"ViewLayer.Depth.Z"}})),
            "0: ViewLayer.Combined.R ViewLayer.Combined.G ViewLayer.Combined.B");
  EXPECT_EQ(chosen(together({rgb_of("ViewLayer.DiffCol."), rgb_of("ViewLayer.Combined."), {"ViewLayer.CryptoObject00.r"}})),
            "0: ViewLayer.Combined.R ViewLayer.Combined.G ViewLayer.Combined.B");
  EXPECT_EQ(chosen(together({rgb_of("Composite.Combined."), rgb_of("A.Combined.")})),
            "0: Composite.Combined.R Composite.Combined.G Composite.Combined.B");
  EXPECT_EQ(chosen(together({rgb_of("diffuse."), rgb_of("beauty.")})), "0: beauty.R beauty.G beauty.B");
  EXPECT_EQ(chosen(together({rgb_of("diffuse."), rgb_of("")})), "0: R G B");
  EXPECT_EQ(chosen(together({rgb_of("crypto00."), {"Image.red", "Image.green", "Image.blue"}, {"Z"}})),
            "0: Image.red Image.green Image.blue");
  EXPECT_EQ(chosen({"Y"}), "0: Y");
  EXPECT_EQ(chosen({"BY", "RY", "Y"}), "0: Y RY BY");
  EXPECT_EQ(chosen(together({{"Y"}, rgb_of("render.")})), "0: render.R render.G render.B");
}

TEST(ExrLayers, WithoutAPictureTheNamesAreSaid) {
  EXPECT_NE(chosen({"N.X", "N.Y", "N.Z", "depth.Z"}).find("N.X, N.Y, N.Z, depth.Z"), std::string::npos);
  const std::string two = chosen(together({rgb_of("diffuse."), rgb_of("specular.")}));
  EXPECT_NE(two.find("\"diffuse\", \"specular\""), std::string::npos) << two;
  EXPECT_NE(chosen({ExrPart{"", "", true, rgb_of("")}}).find("deep"), std::string::npos);
}

TEST(ExrLayers, PartsAndViews) {
  EXPECT_EQ(chosen({{"depth", "", false, {"Z"}}, {"rgb", "", false, rgb_of("")}}), "1: R G B");
  EXPECT_EQ(chosen({{"diffuse", "", false, rgb_of("")}, {"beauty", "", false, rgb_of("")}}), "1: R G B");
  EXPECT_EQ(chosen({{"a", "right", false, rgb_of("")}, {"b", "left", false, rgb_of("")}}), "1: R G B");
  EXPECT_EQ(chosen({{"", "", false, together({rgb_of(""), rgb_of("right.")})}}, {"left", "right"}), "0: R G B");
  EXPECT_EQ(chosen(together({rgb_of("V.Combined.right."), rgb_of("V.Combined.left.")})),
            "0: V.Combined.left.R V.Combined.left.G V.Combined.left.B");
  EXPECT_EQ(exr_colors({{"", "", false, together({rgb_of("V.Combined.right."), rgb_of("V.Combined.left.")})}}, {}).notes.back(),
            "an EXR of several views: \"left\" is read");
}

class ExrFiles : public testing::Test {
 protected:
  // Channels that all hold x + 100 y in the coordinates of the file, plus 1000 times their number.
  void add_channels(Imf::FrameBuffer& buffer, Imf::Header& header, const std::vector<std::string>& names,
                    Imf::PixelType type = Imf::FLOAT) {
    const Imath::Box2i w = header.dataWindow();
    const int width = w.max.x - w.min.x + 1, height = w.max.y - w.min.y + 1;
    for (size_t c = 0; c < names.size(); ++c) {
      header.channels().insert(names[c], Imf::Channel(type));
      std::vector<float>& v = planes.emplace_back(size_t(width) * size_t(height));
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) v[size_t(y * width + x)] = float(x + w.min.x + 100 * (y + w.min.y) + 1000 * int(c));
      buffer.insert(
          names[c],
          Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(v.data()) - (ptrdiff_t(w.min.x) + ptrdiff_t(w.min.y) * width) * 4, 4,
                     size_t(width) * 4));
    }
  }
  fs::path scanlines(Imf::Header header, const std::vector<std::string>& names) {
    Imf::FrameBuffer buffer;
    add_channels(buffer, header, names);
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(header.dataWindow().max.y - header.dataWindow().min.y + 1);
    return path;
  }
  static Imf::Header windows(Imath::Box2i display, Imath::Box2i data) { return Imf::Header(display, data); }
  TemporaryFolder folder;
  fs::path path = folder.path() / "a.exr";
  std::vector<std::vector<float>> planes;
};

TEST_F(ExrFiles, PixelsStandInTheDisplayWindow) {
  const Imath::Box2i display({10, 20}, {29, 31});
  for (const Imath::Box2i& data :
       {display, Imath::Box2i({14, 22}, {20, 40}), Imath::Box2i({-5, -7}, {60, 50}), Imath::Box2i({29, 31}, {80, 90})}) {
    const ExrPicture picture = read_exr_picture(scanlines(windows(display, data), {"R", "G", "B"}));
    ASSERT_EQ(picture.rgb.width(), 20);
    ASSERT_EQ(picture.rgb.height(), 12);
    for (int y = 0; y < 12; ++y)
      for (int x = 0; x < 20; ++x)
        for (int c = 0; c < 3; ++c)
          ASSERT_EQ(picture.rgb.at(x, y, c),
                    data.intersects(Imath::V2i(x + 10, y + 20)) ? float(x + 10 + 100 * (y + 20) + 1000 * c) : 0.f);
    EXPECT_EQ(picture.notes.empty(), data == display);
  }
  EXPECT_NE(error_of([&] {
              read_exr_rgb(scanlines(windows(display, Imath::Box2i({100, 100}, {110, 110})), {"R", "G", "B"}));
            })
                .detail()
                .why.find("outside of its display window"),
            std::string::npos);
}

TEST_F(ExrFiles, ALayerIsReadWithItsAlpha) {
  const ExrPicture picture =
      read_exr_picture(scanlines(Imf::Header(7, 5), {"V.Combined.R", "V.Combined.G", "V.Combined.B", "V.Combined.A", "V.Depth.Z",
                                                     "V.DiffCol.R", "V.DiffCol.G", "V.DiffCol.B"}),
                       true);
  EXPECT_EQ(picture.rgb.at(3, 2, 1), 1203.f);
  EXPECT_EQ(picture.alpha.at(3, 2), 3203.f);
  ASSERT_EQ(picture.notes.size(), 1u);
  EXPECT_EQ(picture.notes[0], "an EXR of several layers: the one called \"V.Combined\" is read");
  EXPECT_EQ(read_exr(path).channels.size(), 8u);
}

TEST_F(ExrFiles, PartsTilesAndLuminanceChroma) {
  {
    std::vector<Imf::Header> headers(2, Imf::Header(7, 5));
    std::vector<Imf::FrameBuffer> buffers(2);
    add_channels(buffers[0], headers[0], {"Z"});
    add_channels(buffers[1], headers[1], {"R", "G", "B"});
    for (size_t p = 0; p < 2; ++p) headers[p].setType(Imf::SCANLINEIMAGE), headers[p].setName(p == 0 ? "depth" : "rgb");
    Imf::MultiPartOutputFile file(path.c_str(), headers.data(), 2);
    for (int p = 0; p < 2; ++p) {
      Imf::OutputPart part(file, p);
      part.setFrameBuffer(buffers[size_t(p)]);
      part.writePixels(5);
    }
  }
  EXPECT_EQ(read_exr_rgb(path).at(3, 2, 2), 2203.f);
  {
    Imf::Header header(37, 29);
    header.setTileDescription(Imf::TileDescription(16, 16, Imf::MIPMAP_LEVELS));
    Imf::FrameBuffer buffer;
    add_channels(buffer, header, {"R", "G", "B"});
    Imf::TiledOutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    for (int level = 0; level < file.numLevels(); ++level)
      file.writeTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
  }
  EXPECT_EQ(read_exr_rgb(path).width(), 37);
  EXPECT_EQ(read_exr_rgb(path).at(30, 20, 1), 3030.f);
  {
    std::vector<Imf::Rgba> pixels(40 * 30, Imf::Rgba(0.5f, 0.25f, 0.125f, 1.f));
    Imf::RgbaOutputFile file(path.c_str(), 40, 30, Imf::WRITE_YC);
    file.setFrameBuffer(pixels.data(), 1, 40);
    file.writePixels(30);
  }
  const ImageF chroma = read_exr_rgb(path);
  ASSERT_EQ(chroma.width(), 40);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(chroma.at(20, 15, c), 0.5 / (1 << c), 0.01);
}

TEST_F(ExrFiles, WholeNumbersAreNoColours) {
  Imf::Header header(4, 4);
  std::vector<uint32_t> plane(16, 7);
  Imf::FrameBuffer buffer;
  for (const char* name : {"R", "G", "B"}) {
    header.channels().insert(name, Imf::Channel(Imf::UINT));
    buffer.insert(name, Imf::Slice(Imf::UINT, reinterpret_cast<char*>(plane.data()), 4, 16));
  }
  {
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(4);
  }
  EXPECT_NE(error_of([&] { read_exr_rgb(path); }).detail().why.find("whole numbers"), std::string::npos);
}

TEST(RepairedValues, AreCountedByWhatTheyWere) {
  ImageF image(8, 1, 1);
  const float values[] = {NAN, INFINITY, -INFINITY, -0.5f, 1e9f, 0.f, 65504.f, 2.f};
  std::copy(std::begin(values), std::end(values), image.data().begin());
  const RepairedValues r = repair_values(image);
  EXPECT_EQ(std::vector<float>(image.data().begin(), image.data().end()),
            (std::vector<float>{0, 65504, 0, 0, 65504, 0, 65504, 2}));
  EXPECT_EQ(r.text(), "2 values that are not numbers were set to 0, 2 above 65504 (or infinite) to 65504, 1 below 0 to 0");
}

}  // namespace
}  // namespace vitrine
