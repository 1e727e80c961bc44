// The data of ct/page.html: means of large volumes, densities in steps, and what a page decodes to.
#include <zlib.h>

#include <gtest/gtest.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "stages/tomography/page_volume.h"
#include "tests/stages/tomography/phantoms.h"

namespace vitrine {
namespace {

VoxelGrid<float> jar(std::array<int, 3> size) {
  return test::truth(test::closed_jar(), {.origin = {-.9, -.8, -.95}, .cell = 1.8 / size[0], .size = size, .values = {}});
}

std::string unpacked_base64(std::string_view text) {
  const std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  unsigned bits = 0, count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6 | unsigned(digits.find(c)), count += 6;
    if (count >= 8) out += char(bits >> (count -= 8) & 255);
  }
  return out;
}

std::string element(const std::string& page, const std::string& id) {
  const size_t at = page.find("id=\"" + id + "\">"), begin = page.find('>', at) + 1;
  return page.substr(begin, page.find("</script>", begin) - begin);
}

// As stages/tomography/page/volume.js decodes it.
struct Decoded {
  nlohmann::json head;
  std::vector<double> densities;
};
Decoded decoded(const std::string& page) {
  Decoded out{nlohmann::json::parse(element(page, "head")), {}};
  const auto size = out.head["size"].get<std::array<int, 3>>();
  const size_t n = size_t(size[0]) * size_t(size[1]) * size_t(size[2]);
  const std::string packed = unpacked_base64(element(page, "steps"));
  std::string bytes(2 * n, '\0');
  uLongf length = bytes.size();
  EXPECT_EQ(
      uncompress(reinterpret_cast<Bytef*>(bytes.data()), &length, reinterpret_cast<const Bytef*>(packed.data()), packed.size()),
      Z_OK);
  EXPECT_EQ(length, bytes.size());
  const double low = out.head["low"], high = out.head["high"];
  for (size_t i = 0; i < n; ++i) {
    const int step = int(uint8_t(bytes[i])) | int(uint8_t(bytes[n + i])) << 8;
    out.densities.push_back(low + step * (high - low) / out.head["steps"].get<double>());
  }
  return out;
}

constexpr const char* kEmpty = "<body><!-- the data --></body>";

TEST(PageVolume, DecodesToTheVolumeWithinHalfAStep) {
  TemporaryFolder folder;
  VoxelGrid<float> volume = jar({40, 36, 44});
  for (size_t i = 0; i < volume.count(); i += 7) volume.values[i] -= 0.001f * float(i % 100);  // also below 0
  const size_t bytes =
      write_volume_page(folder.path() / "page.html", kEmpty, volume, {.unit = "cm", .iso = .3, .seen = SeenCylinder{.9, 1}});
  const std::string page = read_file(folder.path() / "page.html");
  EXPECT_EQ(page.size(), bytes);
  const Decoded d = decoded(page);
  ASSERT_EQ(d.densities.size(), volume.count());
  const double half = (d.head["high"].get<double>() - d.head["low"].get<double>()) / kPageSteps / 2;
  double worst = 0;
  for (size_t i = 0; i < volume.count(); ++i) worst = std::max(worst, std::abs(d.densities[i] - double(volume.values[i])));
  EXPECT_LE(worst, half * 1.001);
  EXPECT_GT(worst, half / 4) << "values lie between the steps";
  EXPECT_EQ(d.head["unit"], "cm");
  EXPECT_EQ(d.head["radius"], .9);
  EXPECT_EQ(d.head["cell"], volume.cell);
  EXPECT_EQ(d.head["origin"][1], -.8);
}

TEST(PageVolume, OneDensityOnlyIsNoDivisionByZero) {
  TemporaryFolder folder;
  const VoxelGrid<float> volume{.origin = {}, .cell = 1, .size = {3, 2, 2}, .values = std::vector<float>(12, 0.25f)};
  write_volume_page(folder.path() / "page.html", kEmpty, volume, {});
  const Decoded d = decoded(read_file(folder.path() / "page.html"));
  EXPECT_TRUE(d.head["radius"].is_null());
  for (const double v : d.densities) EXPECT_EQ(v, 0.25);
}

TEST(PageVolume, LargeVolumesAreMeansAtTheSamePlaces) {
  const VoxelGrid<float> volume = jar({48, 40, 56});
  const size_t most = 30000;
  const VoxelGrid<float> small = averaged_volume(volume, most);
  EXPECT_LE(small.count(), most);
  EXPECT_GT(small.count(), most * 8 / 10) << "no coarser than needed";
  EXPECT_EQ(small.origin.x, volume.origin.x);
  double worst = 0, sum = 0;
  for (size_t c = 0; c < 3; ++c) EXPECT_GE(small.size[c] * small.cell, volume.size[c] * volume.cell * (1 - 1e-9));
  // A cell is the mean of the densities in it: compared with points of the volume.
  small.each_in_order([&](int x, int y, int z) {
    double mean = 0;
    int count = 0;
    for (int k = 0; k < 1000; ++k) {
      const Vec3d p =
          small.centre(x, y, z) + small.cell * Vec3d{(k % 10) / 10. - .45, (k / 10 % 10) / 10. - .45, (k / 100) / 10. - .45};
      const auto [i, j, l] = volume.cell_of(p);
      if (volume.has(i, j, l)) mean += double(volume.at(i, j, l)), ++count;
    }
    if (count < 100) return;  // a cell at the far border, of which the volume has a thin part
    const double off = std::abs(double(small.at(x, y, z)) - mean / count);
    worst = std::max(worst, off), sum += off;
  });
  EXPECT_LT(sum / double(small.count()), 0.005);
  EXPECT_LT(worst, 0.12) << "of a largest density of 1: a tenth of a cell at its side";
  EXPECT_EQ(averaged_volume(volume, volume.count()).values, volume.values);
}

TEST(PageVolume, MeansOfAWholeFactorAreExact) {
  VoxelGrid<float> volume{.origin = {}, .cell = 1, .size = {4, 4, 4}, .values = {}};
  for (int i = 0; i < 64; ++i) volume.values.push_back(float(i));
  const VoxelGrid<float> small = averaged_volume(volume, 8);
  ASSERT_EQ(small.count(), 8u);
  EXPECT_EQ(small.cell, 2);
  EXPECT_FLOAT_EQ(small.values[0], (0 + 1 + 4 + 5 + 16 + 17 + 20 + 21) / 8.f);
  EXPECT_FLOAT_EQ(small.values[7], 63 - small.values[0]);
}

}  // namespace
}  // namespace vitrine
