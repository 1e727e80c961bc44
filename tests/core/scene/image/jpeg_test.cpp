// Where a JPEG ends, and that every way in which one is not whole is found.
#include <gtest/gtest.h>

#include "core/foundation/base/file.h"
#include "core/foundation/base/rng.h"
#include "core/scene/image/file_kind.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/picture_file.h"
#include "core/scene/image/segments.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

using namespace std::string_literals;
using namespace std::string_view_literals;

Image8 grain(int width, int height) {
  Image8 image(width, height, 3);
  Rng rng(11);
  for (uint8_t& v : image.data()) v = uint8_t(64 + rng.below(128));
  return image;
}

class Jpeg : public testing::Test {
 protected:
  Jpeg() {
    write_ldr(folder.path() / "a.jpg", grain(80, 56));
    baseline = read_file(folder.path() / "a.jpg");
    progressive = jpeg_bytes(grain(80, 56), 90);
  }
  fs::path file(const std::string& bytes) const {
    write_file(folder.path() / "b.jpg", bytes);
    return folder.path() / "b.jpg";
  }
  TemporaryFolder folder;
  std::string baseline, progressive;
};

std::string junk(size_t bytes, uint64_t seed) {
  std::string out(bytes, '\0');
  Rng rng(seed);
  for (char& c : out) c = char(rng.below(256));
  return out;
}

TEST_F(Jpeg, WhatFollowsThePictureIsIgnored) {
  const std::string film = "\0\0\0\x18"s + "ftypmp42" + junk(300'000, 1);
  ASSERT_TRUE(progressive.find("\xff\xc2") != std::string::npos);
  for (const std::string& jpeg : {baseline, progressive}) {
    const ImageF plain = read_srgb(file(jpeg));
    for (const std::string& trailer : {std::string(1, '\0'), std::string(400'000, '\0'), junk(40'000, 2), junk(900'000, 3), film,
                                       jpeg, jpeg.substr(0, 700), std::string("\xff\xd9"), std::string("\xff\xd8\xff")}) {
      EXPECT_EQ(jpeg_structure(jpeg + trailer).end, jpeg.size());
      EXPECT_EQ(missing_end(jpeg + trailer), "");
      EXPECT_EQ(read_srgb(file(jpeg + trailer)), plain);
    }
    EXPECT_EQ(jpeg_trailer(jpeg + std::string(99, '\0'), jpeg.size()), "");
    EXPECT_EQ(jpeg_trailer(jpeg + film, jpeg.size()), "a film");
    EXPECT_EQ(jpeg_trailer(jpeg + jpeg, jpeg.size()), "further pictures");
    EXPECT_EQ(examine_picture(jpeg + film, ".jpg").aside, "a JPEG with a film behind the picture: only the picture is read");
  }
}

TEST_F(Jpeg, AThumbnailInsideEndsNothing) {
  const std::string thumbnail = "Exif\0\0"s + baseline;
  std::string segment = "\xff\xe1";
  segment += char((thumbnail.size() + 2) >> 8);
  segment += char((thumbnail.size() + 2) & 255);
  const std::string with = baseline.substr(0, 2) + segment + thumbnail + baseline.substr(2);
  EXPECT_EQ(jpeg_structure(with).end, with.size());
  EXPECT_NE(jpeg_structure(with.substr(0, with.size() - 500)).damage, "") << "the thumbnail's end marker is not the picture's";
}

TEST_F(Jpeg, EveryCutIsFound) {
  for (const std::string& jpeg : {baseline, progressive})
    for (size_t length = 3; length < jpeg.size(); length += 1 + length / 8) {
      const std::string cut = jpeg.substr(0, length);
      EXPECT_NE(missing_end(cut), "") << length;
      EXPECT_NE(missing_end(cut + std::string(5000, '\0')), "") << length << " and zeros";
      EXPECT_NE(error_of([&] { read_srgb(file(cut + std::string(5000, '\0'))); }).detail().why, "") << length;
      // Other bytes may end it by chance: then the decoder has to find out.
      EXPECT_NE(error_of([&] { read_srgb(file(cut + junk(3000, length))); }).detail().why, "") << length << " and other bytes";
    }
  // Not even a false end marker makes half a picture whole.
  EXPECT_NE(error_of([&] { read_srgb(file(baseline.substr(0, baseline.size() / 2) + "\xff\xd9")); }).detail().why, "");
}

TEST_F(Jpeg, OneThatLacksNothingButItsEndMarkerIsRead) {
  const std::string without = baseline.substr(0, baseline.size() - 2);
  EXPECT_EQ(read_srgb(file(without)), read_srgb(file(baseline)));
  ASSERT_EQ(examine_picture(without, ".jpg").notes.size(), 1u);
  EXPECT_EQ(examine_picture(without, ".jpg").notes[0], "a JPEG without its end marker, whose rows are all there: it is read");
  for (const size_t missing : {20, 200, 2000})
    EXPECT_NE(error_of([&] { read_srgb(file(baseline.substr(0, baseline.size() - missing))); }).detail().why, "") << missing;
  // Of a progressive one nobody knows which scans would follow.
  EXPECT_NE(error_of([&] { read_srgb(file(progressive.substr(0, progressive.size() - 2))); }).detail().why, "");
}

TEST_F(Jpeg, KindsThatAreNotReadAreNamed) {
  const size_t frame = baseline.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  const auto why = [&](size_t at, char value) {
    std::string changed = baseline;
    changed[frame + at] = value;
    return error_of([&] { read_srgb(file(changed)); }).detail().why;
  };
  EXPECT_NE(why(4, 12).find("12 bits per sample"), std::string::npos);
  EXPECT_NE(why(1, '\xc3').find("lossless"), std::string::npos);
  EXPECT_NE(why(1, '\xc5').find("hierarchical"), std::string::npos);
  EXPECT_NE(why(9, 4).find("CMYK"), std::string::npos);
  EXPECT_NE(why(9, 2).find("2 channels"), std::string::npos);
}

TEST_F(Jpeg, AGreyOneAndASmallDecodingAreRead) {
  write_ldr(folder.path() / "g.jpg", Image8(33, 17, 1, 90));
  EXPECT_EQ(read_unchanged(folder.path() / "g.jpg").channels(), 1);
  EXPECT_EQ(read_srgb(folder.path() / "g.jpg").channels(), 3);
  EXPECT_EQ(read_grey8(folder.path() / "g.jpg").at(5, 5), 90);
  EXPECT_EQ(read_srgb8(folder.path() / "a.jpg", 4).width(), 20);
  EXPECT_EQ(read_srgb8(folder.path() / "a.jpg", 4).height(), 14);
}

TEST(Png, TrailersAreIgnoredAndCutsAreFound) {
  const TemporaryFolder folder;
  write_ldr(folder.path() / "a.png", grain(40, 30));
  const std::string png = read_file(folder.path() / "a.png");
  write_file(folder.path() / "b.png", png + junk(100'000, 4));
  EXPECT_EQ(read_srgb(folder.path() / "b.png"), read_srgb(folder.path() / "a.png"));
  for (size_t length = 1; length < png.size(); length += 101) {
    write_file(folder.path() / "c.png", png.substr(0, length));
    EXPECT_NE(error_of([&] { read_srgb(folder.path() / "c.png"); }).detail().why, "") << length;
  }
  EXPECT_NE(examine_picture("\x89PNG\r\n\x1a\n\0\0\0\x04"
                            "CgBI\x50\0\x20\x02"sv,
                            ".png")
                .refusal.find("CgBI"),
            std::string::npos);
  std::string flipped = png;
  flipped[png.size() / 2] = char(flipped[png.size() / 2] ^ 1);
  write_file(folder.path() / "c.png", flipped);
  EXPECT_NE(error_of([&] { read_srgb(folder.path() / "c.png"); }).detail().why.find("damaged"), std::string::npos);
}

TEST(FileKind, RawPhotosAreKnownByTheirContent) {
  const std::pair<std::string_view, const char*> kinds[] = {
      {"\0\0\0\x18"
       "ftypcrx \0\0\0\0crx isom"sv,
       "a raw photo (CR3)"},
      {"FUJIFILMCCD-RAW 0201"sv, "a raw photo (RAF)"},
      {"IIRO\x08\0\0\0"sv, "a raw photo (ORF)"},
  };
  for (const auto& [bytes, name] : kinds) {
    EXPECT_EQ(probe_photo(bytes).format, PhotoFormat::Raw) << name;
    EXPECT_NE(foreign_content(bytes, ".jpg").find(name), std::string::npos) << "as a mask";
  }
}

TEST(FileKind, WhatIsCalledAPhotoAndIsNoneIsNamed) {
  const std::pair<std::string_view, const char*> kinds[] = {
      {"\0\0\0\x18"
       "ftypheic\0\0\0\0mif1heic"sv,
       "a HEIC photo"},
      {"\0\0\0\x18"
       "ftypmif1\0\0\0\0mif1avif"sv,
       "an AVIF picture"},
      {"\0\0\0\x18"
       "ftypisom\0\0\0\0mp42isom"sv,
       "a film"},
      {"RIFF\x10\0\0\0WEBPVP8 "sv, "a WebP picture"},
      {"GIF89a\x01\0\x01\0"sv, "a GIF"},
      {"BM\x36\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\1\0\0\0\1\0\0\0"sv, "a BMP picture"},
      {"\0\0\0\x0cJXL \r\n\x87\n"sv, "a JPEG XL picture"},
      {"\xff\x0a\xfa\x7f"sv, "a JPEG XL picture"},
      {"\0\0\0\x0cjP  \r\n\x87\n"sv, "a JPEG 2000 picture"},
      {"version https://git-lfs.github.com/spec/v1\noid sha256:12\nsize 9\n"sv, "a pointer of Git LFS"},
      {"\xef\xbb\xbf <!DOCTYPE html><html><head>"sv, "a web page"},
      {"  <html lang=\"en\">"sv, "a web page"},
      {"<?xml version=\"1.0\"?><Error><Code>AccessDenied</Code></Error>"sv, "an XML file"},
      {"{\"error\": \"rate limit\"}"sv, "a JSON file"},
      {"not found\n"sv, "a text file"},
      {"PK\x03\x04\x14\0"sv, "a ZIP archive"},
      {"%PDF-1.7"sv, "a PDF"},
      {"8BPS\0\1"sv, "a Photoshop document"},
      {"\0\x05\x16\x07\0\x02\0\0"sv, "AppleDouble"},
      {"\0\0\0\0\0\0\0\0\0\0\0\0"sv, "a file of zeros"},
      {"\r\n\xff\xd8\xff\xe0\0\x10JFIF"sv, "a JPEG behind 2 bytes that do not belong to it"},
      {"\x89PNG\n\x1a\n\0\0\0\rIHDR"sv, "line ends were converted"},
      {"\x13\x37\xc0\xde\x80\x01\x02"sv, "begins with the bytes 13 37 c0 de"},
  };
  for (const auto& [bytes, name] : kinds) {
    const PictureFile examined = examine_picture(bytes, ".jpg");
    EXPECT_NE(examined.refusal.find(name), std::string::npos) << name << ": " << examined.refusal;
    EXPECT_EQ(examined.refusal.find("damaged"), std::string::npos) << examined.refusal;
  }
  EXPECT_EQ(examine_picture("", ".jpg").refusal, "the file is empty");
}

}  // namespace
}  // namespace vitrine
