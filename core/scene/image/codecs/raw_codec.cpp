// Raw codec (LibRaw): interpolated camera colours from LibRaw, then white level, saturated pixels and the matrix to Rec. 709
// here.
#include "core/scene/image/codecs/camera_codecs_here.h"

#ifdef VITRINE_WITH_LIBRAW

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include <fmt/format.h>
#include <libraw/libraw.h>
#include <omp.h>

namespace vitrine {

namespace {

constexpr unsigned kMostRawMebibytes = 1024;

// Counted by LibRaw::error_count(). The type of the offset differs between versions.
template <class Offset>
void ignore_data_error(void*, const char*, Offset) {}

using Raw = std::unique_ptr<LibRaw>;

Raw make_raw() {
#if LIBRAW_COMPILE_CHECK_VERSION_NOTLESS(0, 21)
  Raw raw = std::make_unique<LibRaw>(LIBRAW_OPTIONS_NONE);
  raw->imgdata.rawparams.max_raw_memory_mb = kMostRawMebibytes;
#else
  Raw raw = std::make_unique<LibRaw>(LIBRAW_OPIONS_NO_MEMERR_CALLBACK);
  raw->imgdata.params.max_raw_memory_mb = kMostRawMebibytes;
#endif
  raw->set_dataerror_handler(ignore_data_error, nullptr);
  omp_set_num_threads(1);  // of this thread: photos are decoded in parallel
  return raw;
}

// "Maker Model", the maker once.
std::string camera_of(const libraw_iparams_t& p) {
  const std::string maker(p.make, strnlen(p.make, sizeof p.make)), model(p.model, strnlen(p.model, sizeof p.model));
  std::string name = maker.empty() || model.starts_with(maker) ? model : maker + " " + model;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c < 0x20 || c >= 0x7f; }, '?');
  return name;
}

std::string failure(const LibRaw& raw, int code) {
  const std::string camera = camera_of(raw.imgdata.idata);
  const std::string version = LibRaw::version();
  if (code == LIBRAW_FILE_UNSUPPORTED || code == LIBRAW_NOT_IMPLEMENTED)
    return fmt::format("LibRaw {} does not know this kind of raw photo{}: export a 16-bit TIFF, or a DNG", version,
                       camera.empty() ? "" : fmt::format(" ({})", camera));
  return fmt::format("LibRaw {} cannot read it ({}): it is damaged or cut short; copy it again", version,
                     code > 0 ? std::string("system error") : std::string(LibRaw::strerror(code)));
}

std::string open(LibRaw& raw, const std::string& path) {
  const int code = raw.open_file(path.c_str());
  if (code != LIBRAW_SUCCESS) return failure(raw, code);
  constexpr int kMostSide = 1 << 16;
  const libraw_image_sizes_t& s = raw.imgdata.sizes;
  const bool sane = s.width > 0 && s.height > 0 && s.width < kMostSide && s.height < kMostSide && raw.imgdata.idata.colors >= 1 &&
                    raw.imgdata.idata.colors <= 4;
  return sane ? std::string() : failure(raw, LIBRAW_DATA_ERROR);
}

// The multipliers that `open` left, R, G, B, second G: of the camera, else those of daylight.
std::array<float, 4> balance_of(const libraw_colordata_t& color) {
  for (const float* from : {color.cam_mul, color.pre_mul}) {
    std::array<float, 4> out{from[0], from[1], from[2], from[3] > 0 ? from[3] : from[1]};
    if (std::all_of(out.begin(), out.end(), [](float v) { return std::isfinite(v) && v > 1e-6f && v < 1e6f; })) return out;
  }
  return {1, 1, 1, 1};
}

bool knows_colors(const LibRaw& raw) {
  const libraw_colordata_t& c = raw.imgdata.color;
  float sum = 0;
  for (const auto& row : c.cam_xyz)
    for (const float v : row) sum += std::abs(v);
  for (const auto& dng : c.dng_color)
    for (const auto& row : dng.colormatrix)
      for (const float v : row) sum += std::abs(v);
  return raw.imgdata.idata.colors == 1 || sum > 0;
}

// Saturated channels of a pixel in balanced camera colours, where channel c saturates at `white[c]` >= 1. One that saturates is
// raised to the mean of those that do not; if all do, to the largest `white`. So a neutral light stays neutral at any
// brightness, and no channel loses a value above 1.
void restore_saturated(float* v, const float* white, size_t channels, float whitest) {
  constexpr float kNear = 0.97f;  // interpolation mixes saturated samples with others
  float sum = 0;
  size_t open = 0;
  for (size_t c = 0; c < channels; ++c)
    if (v[c] < kNear * white[c]) sum += v[c], ++open;
  if (open == channels) return;
  const float least = open > 0 ? sum / float(open) : whitest;
  for (size_t c = 0; c < channels; ++c)
    if (v[c] >= kNear * white[c]) v[c] = std::max(v[c], least);
}

// The processed samples of LibRaw, 16 bits, scaled so that the largest multiplier is 1.
void to_rec709(const LibRaw& raw, const std::array<float, 4>& balance, ImageF& out) {
  const libraw_data_t& d = raw.imgdata;
  const size_t channels = size_t(d.idata.colors);
  const float least = *std::min_element(balance.begin(), balance.begin() + long(std::min<size_t>(channels, 3))),
              most = *std::max_element(balance.begin(), balance.end());
  float white[4], whitest = 0;
  for (size_t c = 0; c < 4; ++c) white[c] = balance[c] / least;
  for (size_t c = 0; c < channels; ++c) whitest = std::max(whitest, white[c]);
  const float scale = most / least / 65535.f;
  out = ImageF(d.sizes.iwidth, d.sizes.iheight, 3);
  for (size_t i = 0; i < out.pixel_count(); ++i) {
    float v[4];
    for (size_t c = 0; c < 4; ++c) v[c] = float(d.image[i][c]) * scale;
    restore_saturated(v, white, channels, whitest);
    float* const rgb = &out.data()[3 * i];
    for (size_t c = 0; c < 3; ++c) {
      rgb[c] = channels == 1 ? v[0] : 0;
      for (size_t k = 0; channels > 1 && k < channels; ++k) rgb[c] += d.color.rgb_cam[c][k] * v[k];
    }
  }
}

std::string process(LibRaw& raw, const std::array<float, 4>& balance, bool half) {
  libraw_output_params_t& p = raw.imgdata.params;
  std::copy(balance.begin(), balance.end(), p.user_mul);
  p.use_camera_wb = p.use_auto_wb = 0;
  p.no_auto_bright = 1;
  p.adjust_maximum_thr = 0;  // else the white level follows the brightest pixel of each photo
  p.highlight = 1;           // no channel is clipped
  p.output_color = 0;        // camera colours; the matrix is applied here
  p.output_bps = 16;
  p.half_size = half ? 1 : 0;
  if (const int code = raw.unpack(); code != LIBRAW_SUCCESS) return failure(raw, code);
  if (raw.error_count() > 0) return failure(raw, LIBRAW_DATA_ERROR);
  if (const int code = raw.dcraw_process(); code != LIBRAW_SUCCESS) return failure(raw, code);
  return raw.imgdata.image ? std::string() : failure(raw, LIBRAW_DATA_ERROR);
}

}  // namespace

std::string read_raw_facts(const std::string& path, RawFacts& out) {
  const Raw raw = make_raw();
  if (std::string why = open(*raw, path); !why.empty()) return why;
  const libraw_data_t& d = raw->imgdata;
  // LibRaw's flips are bits: 1 = left and right, 2 = up and down, 4 = rows and columns.
  constexpr int kOrientations[] = {1, 2, 4, 3, 5, 8, 6, 7};
  const auto known = [](double v) { return std::isfinite(v) && v > 0 ? v : 0; };
  out = {.camera = camera_of(d.idata),
         .width = d.sizes.width,
         .height = d.sizes.height,
         .orientation = kOrientations[d.sizes.flip & 7],
         .balance = balance_of(d.color),
         .colors_known = knows_colors(*raw),
         .exposure_s = known(d.other.shutter),
         .f_number = known(d.other.aperture),
         .iso = known(d.other.iso_speed),
         .focal_mm = known(d.other.focal_len),
         .focal_35mm = known(d.lens.FocalLengthIn35mmFormat)};
  return {};
}

std::string decode_raw(const std::string& path, const RawRequest& request, ImageF& out) {
  const Raw raw = make_raw();
  if (std::string why = open(*raw, path); !why.empty()) return why;
  const std::array<float, 4> balance = request.balance[1] > 0 ? request.balance : balance_of(raw->imgdata.color);
  if (std::string why = process(*raw, balance, request.half); !why.empty()) return why;
  to_rec709(*raw, balance, out);
  return {};
}

std::string raw_version() { return fmt::format("LibRaw {}", LibRaw::version()); }

}  // namespace vitrine

#else

namespace vitrine {

namespace {
constexpr const char* kNoLibraw = "vitrine was built without LibRaw: install libraw-dev and build again";
}

std::string read_raw_facts(const std::string&, RawFacts&) { return kNoLibraw; }
std::string decode_raw(const std::string&, const RawRequest&, ImageF&) { return kNoLibraw; }
std::string raw_version() { return kNoLibraw; }

}  // namespace vitrine

#endif
