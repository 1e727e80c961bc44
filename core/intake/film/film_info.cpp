#include "core/intake/film/film_info.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/process.h"
#include "core/foundation/config/text.h"

namespace vitrine {

namespace {

using Json = nlohmann::json;

constexpr int kMaxSide = 16384;  // pixels of a frame

struct Code {
  const char* name;  // of ffmpeg
  unsigned code;     // ITU-T H.273
};
constexpr Code kPrimaries[] = {{"bt709", 1}, {"bt470m", 4}, {"bt470bg", 5},   {"smpte170m", 6}, {"smpte240m", 7},
                               {"film", 8},  {"bt2020", 9}, {"smpte431", 11}, {"smpte432", 12}, {"ebu3213", 22}};
constexpr Code kTransfers[] = {{"bt709", 1},      {"bt470m", 4},        {"gamma22", 4},      {"bt470bg", 5},
                               {"gamma28", 5},    {"smpte170m", 6},     {"linear", 8},       {"bt2020-10", 14},
                               {"bt2020-12", 15}, {"iec61966-2-1", 13}, {"iec61966-2-4", 1}, {"smpte2084", 16},
                               {"smpte428", 17},  {"arib-std-b67", 18}};
struct Matrix {
  const char* name;
  const char* of_filter;
};
constexpr Matrix kMatrices[] = {
    {"bt709", "bt709"},         {"fcc", "fcc"},         {"bt470bg", "bt601"}, {"smpte170m", "smpte170m"},
    {"smpte240m", "smpte240m"}, {"bt2020nc", "bt2020"}, {"gbr", "bt709"}};  // gbr: already RGB
constexpr const char* kExport = "export it as H.264 or HEVC in MP4, or export its frames as PNG or TIFF";

template <size_t N>
std::optional<unsigned> code_of(const Code (&list)[N], const std::string& name) {
  for (const Code& c : list)
    if (name == c.name) return c.code;
  return std::nullopt;
}

// A string or number field; empty if it is missing or of another type.
std::string text_at(const Json& j, const char* key) {
  const auto at = j.find(key);
  if (at == j.end()) return {};
  return at->is_string() ? at->get<std::string>() : at->is_number() ? at->dump() : std::string();
}

std::optional<double> number_at(const Json& j, const char* key) {
  const std::string text = text_at(j, key);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

// "4:3" as a ratio; 1 when unknown.
double aspect_of(const std::string& text) {
  const size_t colon = text.find(':');
  if (colon == std::string::npos) return 1;
  const double a = std::atof(text.c_str()), b = std::atof(text.c_str() + colon + 1);
  constexpr double kMost = 4;
  const double ratio = a > 0 && b > 0 ? a / b : 1;
  return ratio > 1 / kMost && ratio < kMost ? ratio : 1;
}

// Bits per sample of a pixel format of ffmpeg: "yuv420p10le", "p010le", "rgb48le" (48 per pixel); those without a byte order
// have 8.
int bits_of(const std::string& format) {
  if (!format.ends_with("le") && !format.ends_with("be")) return 8;
  const size_t end = format.size() - 2, begin = format.find_last_not_of("0123456789", end - 1) + 1;
  const int number = std::atoi(format.substr(begin, end - begin).c_str());
  return number > 8 && number < 16 ? number : 16;
}

// EXIF orientation of a display matrix (ISO/IEC 14496-12): x' = a x + c y, y' = b x + d y. Nullopt if it is no quarter turn.
std::optional<int> orientation_of(const std::string& matrix) {
  std::vector<double> v;  // rows of three after a colon each
  for (size_t colon = matrix.find(':'); colon != std::string::npos; colon = matrix.find(':', colon + 1)) {
    const char* at = matrix.c_str() + colon + 1;
    for (int i = 0; i < 3; ++i) {
      char* end = nullptr;
      v.push_back(std::strtod(at, &end));
      if (end == at) return std::nullopt;
      at = end;
    }
  }
  if (v.size() < 6) return std::nullopt;
  const auto sign = [](double x) { return x > 0.5 * 65536 ? 1 : x < -0.5 * 65536 ? -1 : 0; };
  const std::array<int, 4> m{sign(v[0]), sign(v[1]), sign(v[3]), sign(v[4])};
  constexpr std::array<std::array<int, 4>, 8> kTurns{
      {{1, 0, 0, 1}, {-1, 0, 0, 1}, {-1, 0, 0, -1}, {1, 0, 0, -1}, {0, 1, 1, 0}, {0, 1, -1, 0}, {0, -1, -1, 0}, {0, -1, 1, 0}}};
  for (size_t i = 0; i < kTurns.size(); ++i)
    if (m == kTurns[i]) return int(i) + 1;
  return std::nullopt;
}

void take_side_data(const Json& stream, FilmInfo& info) {
  const auto list = stream.find("side_data_list");
  if (list == stream.end() || !list->is_array()) return;
  for (const Json& side : *list) {
    if (!side.is_object()) continue;
    if (side.contains("displaymatrix")) {
      if (const auto turn = orientation_of(text_at(side, "displaymatrix")))
        info.orientation = *turn;
      else
        info.notes.push_back("its rotation is no quarter turn and is not applied");
    }
    if (number_at(side, "dv_profile") == 5)
      throw_bad_film(info.path, "its colours are Dolby Vision profile 5, which other decoders cannot convert",
                     "export it as HDR10, HLG or SDR");
  }
}

void take_colors(const Json& stream, FilmInfo& info) {
  const std::string primaries = text_at(stream, "color_primaries"), transfer = text_at(stream, "color_transfer"),
                    matrix = text_at(stream, "color_space"), range = text_at(stream, "color_range");
  const auto unset = [](const std::string& s) { return s.empty() || s == "unknown" || s == "reserved" || s == "unspecified"; };
  if (matrix == "ictcp" || matrix == "bt2020c" || matrix == "ycgco" || matrix.starts_with("chroma-derived"))
    throw_bad_film(info.path, fmt::format("its colour matrix {} is not supported", matrix), kExport);
  const auto p = code_of(kPrimaries, primaries), t = code_of(kTransfers, transfer);
  const bool wide = matrix == "bt2020nc";
  info.color.primaries = p.value_or(wide ? 9 : 1);
  info.color.transfer = t.value_or(1);
  if (!p || !t)
    info.notes.push_back(unset(primaries) && unset(transfer)
                             ? "its colours are not tagged: BT.709 is assumed"
                             : fmt::format("its colours ({}, {}) are not tagged completely: BT.709 is assumed for the rest",
                                           unset(primaries) ? "no primaries" : primaries,
                                           unset(transfer) ? "no curve" : transfer));
  constexpr int kStandardDefinition = 576;  // rows; ITU-R BT.601 below, BT.709 above
  info.matrix = info.height <= kStandardDefinition && !p ? "bt601" : info.color.primaries == 9 ? "bt2020" : "bt709";
  for (const Matrix& m : kMatrices)
    if (matrix == m.name) info.matrix = m.of_filter;
  const auto stored_as = [&](const char* start) { return info.pixel_format.starts_with(start); };
  info.is_rgb = stored_as("gbr") || stored_as("rgb") || stored_as("bgr");
  info.full_range = range == "pc" || stored_as("yuvj") || info.is_rgb;
}

const Json* video_stream(const Json& streams) {
  for (const Json& s : streams) {
    if (!s.is_object() || text_at(s, "codec_type") != "video") continue;
    const auto disposition = s.find("disposition");
    const bool cover = disposition != s.end() && disposition->is_object() && number_at(*disposition, "attached_pic") == 1;
    if (!cover) return &s;
  }
  return nullptr;
}

std::string streams_text(const Json& streams) {
  std::string text;
  for (const Json& s : streams)
    if (s.is_object()) text += (text.empty() ? "" : ", ") + text_at(s, "codec_type");
  return text.empty() ? "no stream" : "only " + text;
}

}  // namespace

std::vector<std::string> film_input(const fs::path& film) {
  return {"-protocol_whitelist", "file", "-format_whitelist", "mov,matroska,avi,mpegts,mpeg", "-i", "file:" + film.string()};
}

std::string film_program(std::string_view name) {
  if (const auto program = find_program(name)) return program->string();
  throw Error(ErrorKind::Dependency, fmt::format("films are read with {}, which is not installed", name),
              {.why = "no program of this name is in PATH",
               .hint = "apt-get install ffmpeg, or give photos without films",
               .code = "NO_FFMPEG"});
}

void throw_bad_film(const fs::path& film, std::string why, std::string hint) {
  throw Error(ErrorKind::Input, "a film cannot be used",
              {.where = film.string(), .why = std::move(why), .hint = std::move(hint), .code = "BAD_FILM"});
}

FilmInfo parse_film_info(std::string_view json, const fs::path& film) {
  const Json document = Json::parse(json, nullptr, false);
  const auto streams = document.is_object() ? document.find("streams") : document.end();
  if (!document.is_object() || streams == document.end() || !streams->is_array())
    throw_bad_film(film, "ffprobe finds no film in it", "is it a film, and was it copied completely?");
  const Json* video = video_stream(*streams);
  if (video == nullptr)
    throw_bad_film(film, fmt::format("it has no video stream: {}", streams_text(*streams)), "give a film with pictures");
  FilmInfo info;
  info.path = film;
  info.codec = text_at(*video, "codec_name");
  info.pixel_format = text_at(*video, "pix_fmt");
  const std::string tag = text_at(*video, "codec_tag_string");
  if (tag == "encv" || tag == "drmi" || tag == "drms")
    throw_bad_film(film, "it is encrypted (copy protection)", "use a film without copy protection");
  const auto index = number_at(*video, "index"), width = number_at(*video, "width"), height = number_at(*video, "height");
  if (!index || *index < 0 || *index > 1000) throw_bad_film(film, "its video stream has no number", kExport);
  if (!width || !height || *width < 1 || *height < 1 || *width > kMaxSide || *height > kMaxSide)
    throw_bad_film(film, fmt::format("its frames have no usable size ({} x {})", width.value_or(0), height.value_or(0)), kExport);
  info.stream = int(*index);
  const double aspect = aspect_of(text_at(*video, "sample_aspect_ratio"));
  info.width = std::clamp(int(std::lround(*width * aspect)), 1, kMaxSide);
  info.height = int(*height);
  if (info.pixel_format.empty() || info.codec.empty())
    throw_bad_film(film, "its video cannot be decoded: damaged, encrypted, or of an unknown codec", kExport);
  info.bits = bits_of(info.pixel_format);
  const std::string order = text_at(*video, "field_order");
  info.interlaced = !order.empty() && order != "progressive" && order != "unknown";
  if (info.interlaced) info.notes.push_back("it is interlaced: the rows between are interpolated");
  info.seconds = std::max(number_at(*video, "duration").value_or(0), 0.0);
  if (const auto format = document.find("format"); info.seconds <= 0 && format != document.end() && format->is_object())
    info.seconds = std::max(number_at(*format, "duration").value_or(0), 0.0);
  take_side_data(*video, info);
  take_colors(*video, info);
  return info;
}

FilmInfo read_film_info(const fs::path& film) {
  std::error_code ec;
  if (const auto size = fs::file_size(film, ec); ec || size == 0)
    throw_bad_film(film, ec ? ec.message() : std::string("it is empty (0 bytes)"), "copy it from the camera again");
  const TemporaryFolder folder("vitrine-film");
  const fs::path answer = folder.path() / "film.json";
  std::vector<std::string> words{film_program("ffprobe"), "-v", "error", "-of", "json", "-show_format", "-show_streams"};
  for (const std::string& w : film_input(film)) words.push_back(w);
  words.insert(words.end(), {"-o", answer.string()});
  std::string reason;  // the last error without the address of its source: "moov atom not found"
  const ProcessResult r = run_process({.arguments = words, .on_line = [&](std::string_view line) {
                                         if (line.starts_with("[") && line.find("] ") != line.npos)
                                           reason = line.substr(line.find("] ") + 2);
                                       }});
  throw_if_interrupted();
  if (!r.ok()) {
    if (reason.find("moov atom not found") != reason.npos)
      throw_bad_film(film, "it is truncated or no film (moov atom not found)", "copy it from the camera again, completely");
    throw_bad_film(film, "ffprobe cannot open it" + (reason.empty() ? "" : ": " + reason), "is it a film, and complete?");
  }
  return parse_film_info(read_file(answer), film);
}

}  // namespace vitrine
