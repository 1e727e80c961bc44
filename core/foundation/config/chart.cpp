#include "core/foundation/config/chart.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "core/foundation/base/error.h"

namespace vitrine {

std::optional<PhotoBox> parse_photo_box(std::string_view text) {
  const size_t colon = text.rfind(':');
  if (colon == std::string_view::npos || colon == 0) return std::nullopt;
  PhotoBox box{.photo = std::string(text.substr(0, colon))};
  const char *at = text.data() + colon, *end = text.data() + text.size();
  for (int* number : {&box.x, &box.y, &box.width, &box.height}) {
    if (at == end || (*at != ':' && *at != ',')) return std::nullopt;
    const auto [next, error] = std::from_chars(at + 1, end, *number);
    if (error != std::errc()) return std::nullopt;
    at = next;
  }
  if (at != end || box.x < 0 || box.y < 0 || box.width < 1 || box.height < 1) return std::nullopt;
  return box;
}

std::optional<Length> parse_length(std::string_view text) {
  double value = 0;
  const auto [next, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc()) return std::nullopt;
  std::string_view unit = text.substr(size_t(next - text.data()));
  unit.remove_prefix(std::min(unit.find_first_not_of(' '), unit.size()));
  const double factor = unit.empty() || unit == "m" ? 1 : unit == "cm" ? 0.01 : unit == "mm" ? 0.001 : 0;
  const Length length{value * factor, !unit.empty()};
  if (!(length.metres > 0) || !std::isfinite(length.metres)) return std::nullopt;
  return length;
}

namespace {

constexpr std::string_view kSpaces = " \t\r\n";

std::string_view trimmed(std::string_view text) {
  const size_t first = text.find_first_not_of(kSpaces);
  return first == std::string_view::npos ? std::string_view() : text.substr(first, text.find_last_not_of(kSpaces) + 1 - first);
}

// "photo:x1,y1,x2,y2"
std::optional<ScaleBarMark> parse_mark(std::string_view text) {
  const size_t colon = text.rfind(':');
  if (colon == std::string_view::npos || colon == 0) return std::nullopt;
  ScaleBarMark mark{.photo = std::string(text.substr(0, colon))};
  const char *at = text.data() + colon, *end = text.data() + text.size();
  for (double* number : {&mark.x1, &mark.y1, &mark.x2, &mark.y2}) {
    if (at == end || *at != (number == &mark.x1 ? ':' : ',')) return std::nullopt;
    const auto [next, error] = std::from_chars(at + 1, end, *number);
    if (error != std::errc() || !std::isfinite(*number) || *number < 0) return std::nullopt;
    at = next;
  }
  if (at != end) return std::nullopt;
  return mark;
}

// "x,y,z"
std::optional<std::array<double, 3>> parse_point(std::string_view text) {
  std::array<double, 3> point{};
  const char *at = text.data(), *end = text.data() + text.size();
  for (size_t c = 0; c < 3; ++c) {
    if (c > 0 && (at == end || *at++ != ',')) return std::nullopt;
    const auto [next, error] = std::from_chars(at, end, point[c]);
    if (error != std::errc() || !std::isfinite(point[c])) return std::nullopt;
    at = next;
  }
  return at == end ? std::optional(point) : std::nullopt;
}

}  // namespace

ScaleBar parse_scale_bar(const std::string& text) {
  const auto fail = [&](std::string why) {
    return Error(ErrorKind::Usage, "the scale bar cannot be read",
                 {.where = text,
                  .why = std::move(why),
                  .hint = "its two ends in two or more photos, pixels of images/<photo> in the output folder, and its length: "
                          "\"IMG_0007.jpg:120,410,388,402 IMG_0011.jpg:96,377,301,455 = 5cm\"",
                  .code = "SCALE_BAR"});
  };
  const std::string_view all(text);
  const size_t equals = all.rfind('=');
  if (equals == std::string_view::npos) throw fail("it does not end with the length of the bar, as in \"= 5cm\"");
  const std::string_view length_text = trimmed(all.substr(equals + 1));
  const auto length = parse_length(length_text);
  if (!length || !length->has_unit)
    throw fail(fmt::format("its length must be a number above zero with the unit m, cm or mm, got \"{}\"", length_text));

  ScaleBar bar{.marks = {}, .length_m = length->metres};
  // A name with spaces extends until four numbers follow it.
  for (std::string_view rest = trimmed(all.substr(0, equals)); !rest.empty();) {
    std::optional<ScaleBarMark> mark;
    size_t end = 0;
    do {
      end = std::min(rest.find_first_of(kSpaces, end + 1), rest.size());
      mark = parse_mark(rest.substr(0, end));
    } while (!mark && end < rest.size());
    if (!mark) throw fail(fmt::format("\"{}\" is not photo:x1,y1,x2,y2 with four numbers, none below zero", rest));
    if (mark->x1 == mark->x2 && mark->y1 == mark->y2)
      throw fail(fmt::format("both ends are the same pixel of '{}'", mark->photo));
    if (std::ranges::any_of(bar.marks, [&](const ScaleBarMark& m) { return m.photo == mark->photo; }))
      throw fail(fmt::format("'{}' is marked twice", mark->photo));
    bar.marks.push_back(*std::move(mark));
    rest = trimmed(rest.substr(end));
  }
  if (bar.marks.size() < 2) throw fail("its ends must be marked in two photos at least");
  return bar;
}

double ScalePoints::scene_units() const { return std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]); }

ScalePoints parse_scale_points(const std::string& text) {
  const auto fail = [&](std::string why) {
    return Error(
        ErrorKind::Usage, "the scale points cannot be read",
        {.where = text,
         .why = std::move(why),
         .hint = "two points of the scene and the length between them: \"0.12,-0.4,0.3 0.5,0.1,0.3 24cm\"; `vitrine view` "
                 "writes this text (Measure)",
         .code = "SCALE_POINTS"});
  };
  std::string_view rest = trimmed(text);
  ScalePoints points;
  for (std::array<double, 3>* point : {&points.a, &points.b}) {
    const size_t end = std::min(rest.find_first_of(kSpaces), rest.size());
    const auto read = parse_point(rest.substr(0, end));
    if (!read) throw fail(fmt::format("\"{}\" is not x,y,z with three finite numbers", rest.substr(0, end)));
    *point = *read;
    rest = trimmed(rest.substr(end));
  }
  const auto length = parse_length(rest);
  if (!length || !length->has_unit)
    throw fail(fmt::format("the length must be a number above zero with the unit m, cm or mm, got \"{}\"", rest));
  points.length_m = length->metres;
  const double units = points.scene_units();
  if (!(units > 0) || !std::isfinite(units)) throw fail("the points are equal, or absurdly far apart");
  return points;
}

}  // namespace vitrine
