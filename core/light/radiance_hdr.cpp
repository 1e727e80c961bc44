#include "core/light/radiance_hdr.h"

#include <array>
#include <charconv>
#include <cmath>
#include <string>

#include "core/base/error.h"

namespace vitrine {

namespace {

using Rgbe = std::array<uint8_t, 4>;

constexpr size_t kMaxPixels = size_t(1) << 28, kAlwaysFine = size_t(1) << 22, kPixelsPerByte = 64;
constexpr int kLeastCoded = 8, kMostCoded = 0x7fff;  // widths of scanlines that can be coded by component

class Reader {
 public:
  Reader(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  [[noreturn]] void fail(const std::string& why) const {
    throw Error(ErrorKind::Input, "cannot read a Radiance HDR picture",
                {.where = name_, .why = why, .hint = "save it again, best as OpenEXR", .code = "BAD_HDR"});
  }
  size_t left() const { return bytes_.size() - at_; }
  uint8_t byte() {
    if (at_ == bytes_.size()) fail("the file ends in the middle of the picture");
    return static_cast<uint8_t>(bytes_[at_++]);
  }
  Rgbe peek4() const {
    if (left() < 4) fail("the file ends in the middle of the picture");
    Rgbe p;
    for (size_t c = 0; c < 4; ++c) p[c] = static_cast<uint8_t>(bytes_[at_ + c]);
    return p;
  }
  void skip(size_t n) { at_ += n; }
  std::string_view line() {
    const size_t end = bytes_.find('\n', at_);
    if (end == std::string_view::npos) fail("its header has no end");
    std::string_view text = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    if (!text.empty() && text.back() == '\r') text.remove_suffix(1);
    return text;
  }

 private:
  std::string_view bytes_;
  const std::string& name_;
  size_t at_ = 0;
};

struct Size {
  int width = 0, height = 0;
};

Size read_header(Reader& in) {
  if (!in.line().starts_with("#?")) in.fail("it does not begin with #?");
  for (std::string_view line = in.line(); !line.empty(); line = in.line())
    if (line.starts_with("FORMAT=") && line != "FORMAT=32-bit_rle_rgbe")
      in.fail(fmt::format("its {} is not 32-bit_rle_rgbe", line));
  const std::string_view line = in.line();
  const auto bad = [&] { in.fail(fmt::format("its size \"{}\" is not of the form \"-Y height +X width\"", line.substr(0, 60))); };
  const auto number = [&](std::string_view text, int& value) {
    const auto r = std::from_chars(text.data(), text.data() + text.size(), value);
    if (r.ec != std::errc() || value < 1) bad();
    return text.substr(static_cast<size_t>(r.ptr - text.data()));
  };
  Size size;
  if (!line.starts_with("-Y ")) bad();
  const std::string_view rest = number(line.substr(3), size.height);
  if (!rest.starts_with(" +X ")) bad();
  if (!number(rest.substr(4), size.width).empty()) bad();
  if (size_t(size.width) * size_t(size.height) > kMaxPixels)
    in.fail(fmt::format("its size of {} x {} pixels is not plausible", size.width, size.height));
  return size;
}

// One component after the other: a count above 128 repeats one byte (count - 128) times, else so many bytes follow.
void read_coded(Reader& in, std::vector<Rgbe>& row) {
  in.skip(4);
  for (size_t c = 0; c < 4; ++c)
    for (size_t x = 0; x < row.size();) {
      const size_t count = in.byte(), run = count > 128 ? count - 128 : count;
      if (run == 0 || x + run > row.size()) in.fail("a run of equal bytes leaves its scanline");
      const uint8_t repeated = count > 128 ? in.byte() : 0;
      for (size_t i = 0; i < run; ++i) row[x++][c] = count > 128 ? repeated : in.byte();
    }
}

// Whole pixels; (1, 1, 1, n) repeats the one before n times, several of them in turn are digits of base 256.
void read_flat(Reader& in, std::vector<Rgbe>& row) {
  int shift = 0;
  for (size_t x = 0; x < row.size();) {
    const Rgbe p = in.peek4();
    in.skip(4);
    if (p[0] == 1 && p[1] == 1 && p[2] == 1) {
      const size_t run = shift < 32 ? size_t(p[3]) << shift : row.size() + 1;
      if (x == 0 || x + run > row.size()) in.fail("a run of equal pixels leaves its scanline");
      for (size_t i = 0; i < run; ++i, ++x) row[x] = row[x - 1];
      shift += 8;
    } else {
      row[x++] = p;
      shift = 0;
    }
  }
}

}  // namespace

ImageF parse_radiance_hdr(std::string_view bytes, const std::string& name) {
  Reader in(bytes, name);
  const Size size = read_header(in);
  // A coded row takes at least 4 bytes, and so does anything flat: no memory for a size that the file cannot hold.
  if (in.left() / 4 < size_t(size.height)) in.fail("the file ends in the middle of the picture");
  // A coded row takes 8 bytes for 127 pixels. Runs in flat rows may say more, but no program writes so large a picture that way.
  const size_t pixels = size_t(size.width) * size_t(size.height);
  if (pixels > kAlwaysFine && pixels / kPixelsPerByte > in.left())
    in.fail(fmt::format("{} bytes cannot hold {} x {} pixels", in.left(), size.width, size.height));
  ImageF image(size.width, size.height, 3);
  std::vector<Rgbe> row(static_cast<size_t>(size.width));
  for (int y = 0; y < size.height; ++y) {
    const Rgbe start = in.peek4();
    const bool coded = size.width >= kLeastCoded && size.width <= kMostCoded && start[0] == 2 && start[1] == 2 &&
                       start[2] * 256 + start[3] == size.width;
    coded ? read_coded(in, row) : read_flat(in, row);
    for (int x = 0; x < size.width; ++x) {
      const Rgbe& p = row[static_cast<size_t>(x)];
      if (p[3] == 0) continue;
      const float unit = std::ldexp(1.f, p[3] - 136);
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = unit * p[static_cast<size_t>(c)];
    }
  }
  return image;
}

}  // namespace vitrine
