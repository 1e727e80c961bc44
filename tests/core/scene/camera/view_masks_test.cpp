#include "core/scene/camera/view_masks.h"

#include <gtest/gtest.h>

#include "core/foundation/base/file.h"
#include "core/scene/image/ldr.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

class ViewMasks : public ::testing::Test {
 protected:
  template <class Image>
  std::optional<ImageF> read_back(const Image& image) const {
    const fs::path path = view_mask_path(folder_.path(), MaskClass::Specular, view_);
    make_folders(path.parent_path());
    if constexpr (std::is_same_v<Image, Image16>)
      write_png16(path, image);
    else
      write_ldr(path, image);
    return read_view_mask(folder_.path(), MaskClass::Specular, view_);
  }

  TemporaryFolder folder_;
  View view_{.name = "left/b.jpg", .intrinsics = {6, 4, 5, 5, 3, 2}, .cam_from_world = {}};
};

TEST_F(ViewMasks, HaveTheValuesOfTheirFile) {
  EXPECT_EQ(view_mask_path("out", MaskClass::Specular, view_), fs::path("out/masks/specular/left/b.png"));
  EXPECT_FALSE(read_view_mask(folder_.path(), MaskClass::Specular, view_));
  Image16 soft(6, 4, 1, uint16_t(0));
  soft.at(2, 1) = 13107;
  const ImageF mask = read_back(soft).value();
  EXPECT_EQ(mask.channels(), 1);
  EXPECT_NEAR(mask.at(2, 1), 0.2f, 1e-6f);
  EXPECT_FALSE(read_view_mask(folder_.path(), MaskClass::Object, view_));
  // A soft edge alone is faint: no file of labels, where every value above nothing would be all.
  EXPECT_NEAR(read_back(Image8(6, 4, 1, uint8_t(5))).value().at(0, 0), 5 / 255.f, 1e-6f);
  // Painted over in a program that saves colour.
  const ImageF coloured = read_back(Image8(6, 4, 3, uint8_t(255))).value();
  EXPECT_EQ(coloured.channels(), 1);
  EXPECT_EQ(coloured.at(5, 3), 1.f);
}

TEST_F(ViewMasks, OfAnotherSizeAreRefused) {
  for (const auto& [width, height] : {std::pair{3, 2}, {12, 8}, {4, 6}}) {
    const Error e = error_of([&] { read_back(Image8(width, height, 1, uint8_t(255))); });
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    EXPECT_EQ(e.detail().code, "MASK_SIZE");
    EXPECT_NE(e.detail().where.find("left/b.png"), std::string::npos);
  }
}

}  // namespace
}  // namespace vitrine
