#include "core/scene/light/environment.h"

#include <array>
#include <charconv>
#include <cmath>
#include <string>

#include "core/foundation/base/error.h"
#include "core/foundation/math/vec.h"

namespace vitrine {

namespace {

using Rgbe = std::array<uint8_t, 4>;

constexpr size_t kMaxPixels = size_t(1) << 28, kAlwaysFine = size_t(1) << 22, kPixelsPerByte = 64;
constexpr int kLeastCoded = 8, kMostCoded = 0x7fff;  // scanline widths that allow run-length coding per component

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

// Pixel order. `major` is the axis of the scanlines.
struct HdrSize {
  int width = 0, height = 0;
  bool columns = false;                 // scanlines are columns
  bool flip_x = false, flip_y = false;  // from right to left, from bottom to top
  int lines() const { return columns ? width : height; }
  int line_length() const { return columns ? height : width; }
};

struct HdrHeader {
  HdrSize size;
  std::array<double, 3> scale{1, 1, 1};  // products of EXPOSURE and COLORCORR
  bool xyz = false;
  std::vector<std::string> notes;
};

// Parses all numbers of the text, separated by blanks.
std::vector<double> numbers_of(std::string_view text) {
  std::vector<double> out;
  for (;;) {
    const size_t start = text.find_first_not_of(" \t");
    if (start == std::string_view::npos) return out;
    text.remove_prefix(start);
    if (text.front() == '+') text.remove_prefix(1);
    double v = 0;
    const auto r = std::from_chars(text.data(), text.data() + text.size(), v);
    if (r.ec != std::errc()) return out;
    out.push_back(v);
    text.remove_prefix(static_cast<size_t>(r.ptr - text.data()));
  }
}

// Parses "-Y height +X width" and the seven other orders.
HdrSize read_size(Reader& in) {
  const std::string_view line = in.line();
  const auto bad = [&] { in.fail(fmt::format("its size \"{}\" is not of the form \"-Y height +X width\"", line.substr(0, 60))); };
  HdrSize size;
  std::string_view rest = line;
  char axes[2] = {};
  for (int i = 0; i < 2; ++i) {
    if (i == 1) {
      if (!rest.starts_with(' ')) bad();
      rest.remove_prefix(1);
    }
    if (rest.size() < 4 || (rest[0] != '+' && rest[0] != '-') || (rest[1] != 'X' && rest[1] != 'Y') || rest[2] != ' ') bad();
    axes[i] = rest[1];
    (rest[1] == 'X' ? size.flip_x : size.flip_y) = rest[0] == (rest[1] == 'X' ? '-' : '+');
    int& side = rest[1] == 'X' ? size.width : size.height;
    rest.remove_prefix(3);
    const auto r = std::from_chars(rest.data(), rest.data() + rest.size(), side);
    if (r.ec != std::errc() || side < 1) bad();
    rest.remove_prefix(static_cast<size_t>(r.ptr - rest.data()));
  }
  if (axes[0] == axes[1] || rest.find_first_not_of(" \t") != std::string_view::npos) bad();
  size.columns = axes[0] == 'X';
  if (size_t(size.width) * size_t(size.height) > kMaxPixels)
    in.fail(fmt::format("its size of {} x {} pixels is not plausible", size.width, size.height));
  return size;
}

bool usual_primaries(const std::vector<double>& p) {
  constexpr double kTolerance = 0.02,
                   kRec709[] = {0.64, 0.33, 0.30, 0.60, 0.15, 0.06};  // Radiance's own primaries have a green of 0.29
  for (size_t i = 0; i < 6; ++i)
    if (std::abs(p[i] - kRec709[i]) > kTolerance) return false;
  return true;
}

HdrHeader read_header(Reader& in) {
  if (!in.line().starts_with("#?")) in.fail("it does not begin with #?");
  HdrHeader header;
  size_t exposures = 0, corrections = 0;
  for (std::string_view line = in.line(); !line.empty(); line = in.line()) {
    const auto value = [&](std::string_view key) { return line.substr(key.size()); };
    if (line.starts_with("FORMAT=")) {
      std::string_view format = value("FORMAT=");
      const size_t first = std::min(format.find_first_not_of(' '), format.size());
      format = format.substr(first, format.find_last_not_of(' ') + 1 - first);
      header.xyz = format == "32-bit_rle_xyze";
      if (!header.xyz && format != "32-bit_rle_rgbe")
        in.fail(fmt::format("its {} is neither 32-bit_rle_rgbe nor 32-bit_rle_xyze", line.substr(0, 60)));
    } else if (line.starts_with("EXPOSURE=") || line.starts_with("COLORCORR=")) {
      const bool exposure = line.starts_with("EXPOSURE=");
      const std::vector<double> factors = numbers_of(value(exposure ? "EXPOSURE=" : "COLORCORR="));
      if (factors.size() < (exposure ? 1 : 3)) in.fail(fmt::format("its {} holds too few numbers", line.substr(0, 60)));
      for (size_t c = 0; c < 3; ++c) {
        const double factor = factors[exposure ? 0 : c];
        if (!(factor > 0 && std::isfinite(factor))) in.fail(fmt::format("its {} is no factor", line.substr(0, 60)));
        header.scale[c] *= factor;
      }
      ++(exposure ? exposures : corrections);
    } else if (line.starts_with("PRIMARIES=")) {
      const std::vector<double> primaries = numbers_of(value("PRIMARIES="));
      if (primaries.size() >= 8 && !usual_primaries(primaries))
        header.notes.push_back(
            fmt::format("its primaries ({}) are not those of sRGB: its colours are taken as they are", value("PRIMARIES=")));
    } else if (line.starts_with("PIXASPECT=")) {
      const std::vector<double> aspect = numbers_of(value("PIXASPECT="));
      if (!aspect.empty() && std::abs(aspect[0] - 1) > 0.01)
        header.notes.push_back(fmt::format("its pixels are not square ({}): they are taken as square", line));
    }
  }
  const auto& s = header.scale;
  if (s[0] != 1 || s[1] != 1 || s[2] != 1)
    header.notes.push_back(fmt::format(
        "its values are divided by {}{}{}{}", exposures > 0 ? "EXPOSURE" : "", exposures > 0 && corrections > 0 ? " and " : "",
        corrections > 0 ? "COLORCORR" : "",
        s[0] == s[1] && s[1] == s[2] ? fmt::format(" ({:g})", s[0]) : fmt::format(" ({:g}, {:g}, {:g})", s[0], s[1], s[2])));
  if (header.xyz) header.notes.emplace_back("its CIE XYZ values are converted to RGB of the primaries of Rec. 709");
  header.size = read_size(in);
  const HdrSize& size = header.size;
  if (size.columns || size.flip_x || size.flip_y)
    header.notes.emplace_back("its rows and columns are put upright, as its header says");
  return header;
}

using Rows = std::array<Vec3d, 3>;
Rows inverse_of_columns(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const double determinant = dot(a, cross(b, c));
  return {cross(b, c) / determinant, cross(c, a) / determinant, cross(a, b) / determinant};
}

// XYZ to RGB with Rec. 709 primaries and equal-energy white: XYZ (1, 1, 1) gives RGB (1, 1, 1).
Rows rgb_from_xyz() {
  const Vec3d red{0.64, 0.33, 0.03}, green{0.30, 0.60, 0.10}, blue{0.15, 0.06, 0.79}, white{1, 1, 1};
  const Rows amounts = inverse_of_columns(red, green, blue);
  return inverse_of_columns(red * dot(amounts[0], white), green * dot(amounts[1], white), blue * dot(amounts[2], white));
}

// Components one after the other. A count above 128 repeats one byte (count - 128) times; a smaller count precedes literal bytes.
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

// Uncompressed pixels; (1, 1, 1, n) repeats the previous pixel n times. Consecutive repeats are digits of base 256.
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

ImageF parse_radiance_hdr(std::string_view bytes, const std::string& name, std::vector<std::string>* notes) {
  Reader in(bytes, name);
  const HdrHeader header = read_header(in);
  const HdrSize& size = header.size;
  // Every line takes at least 4 bytes in either coding. This check avoids allocating more memory than the file can fill.
  if (in.left() / 4 < size_t(size.lines())) in.fail("the file ends in the middle of the picture");
  // A coded line takes 8 bytes per 127 pixels. Repeats in flat lines could compress more, but no program writes large images that
  // way.
  const size_t pixels = size_t(size.width) * size_t(size.height);
  if (pixels > kAlwaysFine && pixels / kPixelsPerByte > in.left())
    in.fail(fmt::format("{} bytes cannot hold {} x {} pixels", in.left(), size.width, size.height));
  ImageF image(size.width, size.height, 3);
  std::vector<Rgbe> line(static_cast<size_t>(size.line_length()));
  const Rows to_rgb = rgb_from_xyz();
  const bool scaled = header.scale[0] != 1 || header.scale[1] != 1 || header.scale[2] != 1;
  for (int l = 0; l < size.lines(); ++l) {
    const Rgbe start = in.peek4();
    const bool coded = size.line_length() >= kLeastCoded && size.line_length() <= kMostCoded && start[0] == 2 && start[1] == 2 &&
                       start[2] * 256 + start[3] == size.line_length();
    coded ? read_coded(in, line) : read_flat(in, line);
    for (int i = 0; i < size.line_length(); ++i) {
      const Rgbe& p = line[static_cast<size_t>(i)];
      if (p[3] == 0) continue;
      const int x = size.columns ? l : i, y = size.columns ? i : l;
      float* const to = image.pixel(size.flip_x ? size.width - 1 - x : x, size.flip_y ? size.height - 1 - y : y);
      const float unit = std::ldexp(1.f, p[3] - 136);
      for (size_t c = 0; c < 3; ++c) to[c] = unit * p[c];
      if (scaled)
        for (size_t c = 0; c < 3; ++c) to[c] = static_cast<float>(to[c] / header.scale[c]);
      if (header.xyz) {
        const Vec3d xyz{to[0], to[1], to[2]};
        for (size_t c = 0; c < 3; ++c) to[c] = static_cast<float>(dot(to_rgb[c], xyz));
      }
    }
  }
  if (notes != nullptr) notes->insert(notes->end(), header.notes.begin(), header.notes.end());
  return image;
}

}  // namespace vitrine
