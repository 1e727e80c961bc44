#include "core/scene/image/color_profile.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <lcms2.h>

#include "core/foundation/base/hash.h"
#include "core/foundation/math/color.h"

namespace vitrine {

namespace {

// One Little CMS context per profile: no global state, and error messages are captured.
struct Context {
  std::string error;
  cmsContext handle = nullptr;
  Context() : handle(cmsCreateContext(nullptr, this)) {
    cmsSetLogErrorHandlerTHR(handle, [](cmsContext id, cmsUInt32Number, const char* text) {
      if (auto* self = static_cast<Context*>(cmsGetContextUserData(id)); self && self->error.empty()) self->error = text;
    });
  }
  ~Context() { cmsDeleteContext(handle); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
};

struct Lcms {
  std::shared_ptr<Context> context = std::make_shared<Context>();
  cmsHPROFILE profile = nullptr, rec709 = nullptr;
  cmsHTRANSFORM transform = nullptr;
  Lcms() = default;
  ~Lcms() {
    if (transform) cmsDeleteTransform(transform);
    if (rec709) cmsCloseProfile(rec709);
    if (profile) cmsCloseProfile(profile);
  }
  Lcms(const Lcms&) = delete;
  Lcms& operator=(const Lcms&) = delete;

  bool make_transform(cmsUInt32Number from) {
    const cmsCIExyY white{kRec709.white_x, kRec709.white_y, 1};
    const cmsCIExyYTRIPLE primaries{
        {kRec709.red_x, kRec709.red_y, 1}, {kRec709.green_x, kRec709.green_y, 1}, {kRec709.blue_x, kRec709.blue_y, 1}};
    cmsToneCurve* const linear = cmsBuildGamma(context->handle, 1.0);
    if (!linear) return false;
    cmsToneCurve* const curves[] = {linear, linear, linear};
    rec709 = cmsCreateRGBProfileTHR(context->handle, &white, &primaries, curves);
    cmsFreeToneCurve(linear);
    if (rec709)
      transform = cmsCreateTransformTHR(context->handle, profile, from, rec709, TYPE_RGB_FLT, INTENT_RELATIVE_COLORIMETRIC,
                                        cmsFLAGS_NOCACHE | cmsFLAGS_NOOPTIMIZE);
    return transform != nullptr;
  }
};

std::string description(cmsHPROFILE profile) {
  constexpr size_t kLongest = 64;
  char text[256] = {};
  cmsGetProfileInfoASCII(profile, cmsInfoDescription, "en", "US", text, sizeof text - 1);
  std::string name;
  for (const char* c = text; *c; ++c)
    if (*c >= 0x20 && *c < 0x7f && name.size() < kLongest) name += *c;
  while (name.ends_with(' ')) name.pop_back();
  return name.empty() ? "unnamed profile" : name;
}

std::string four_letters(cmsUInt32Number signature) {
  std::string word;
  for (int shift = 24; shift >= 0; shift -= 8) {
    const char c = static_cast<char>(signature >> shift & 0xff);
    word += c >= 0x20 && c < 0x7f ? c : '?';
  }
  while (word.ends_with(' ')) word.pop_back();
  return word;
}

// Linear extrapolation beyond the last entry: floating-point samples may be brighter than white.
ColorProfile::Curve curve_of_table(std::vector<float> table) {
  return [table = std::move(table)](double v) {
    const double at = std::max(v, 0.0) * double(table.size() - 1);
    const size_t i = static_cast<size_t>(std::min(at, double(table.size() - 2)));
    return table[i] + (at - double(i)) * (table[i + 1] - table[i]);
  };
}

// Tone curve of the profile; none if it is missing or invalid.
ColorProfile::Curve curve_of(const std::shared_ptr<Lcms>& lcms, cmsTagSignature tag) {
  const auto* curve = static_cast<const cmsToneCurve*>(cmsReadTag(lcms->profile, tag));
  if (!curve) return {};
  ColorProfile::Curve f;
  const cmsUInt32Number entries = cmsGetToneCurveEstimatedTableEntries(curve);
  // Little CMS evaluates tables with 16-bit output, which is coarse in dark tones; interpolate the table entries instead.
  if (cmsGetToneCurveParametricType(curve) == 0 && entries >= 2) {
    const cmsUInt16Number* table = cmsGetToneCurveEstimatedTable(curve);
    std::vector<float> values(entries);
    for (size_t i = 0; i < entries; ++i) values[i] = float(table[i]) / 65535.0f;
    f = curve_of_table(std::move(values));
  } else {
    f = [lcms, curve](double v) { return double(cmsEvalToneCurveFloat(curve, float(v))); };
  }
  const double dark = f(0), middle = f(0.5), bright = f(1);
  constexpr double kLargest = 16, kLeast = 1e-4;  // lower bound: gamma 13
  return dark >= -0.5 && middle > dark + kLeast && bright > middle && bright < kLargest ? f : ColorProfile::Curve{};
}

IccProfile unusable(const Lcms& lcms, std::string why) {
  if (!lcms.context->error.empty()) why += fmt::format(" (Little CMS: {})", lcms.context->error);
  return {.profile = nullptr, .problem = std::move(why)};
}

// HDR images state their transfer curve as code points; the profile tables only approximate it.
std::optional<Cicp> cicp_of(cmsHPROFILE profile) {
  unsigned char raw[12] = {};
  const auto tag = static_cast<cmsTagSignature>(0x63696370);
  if (!cmsIsTag(profile, tag) || cmsReadRawTag(profile, tag, raw, sizeof raw) < sizeof raw) return std::nullopt;
  const Cicp cicp{.primaries = raw[8], .transfer = raw[9], .matrix = raw[10], .full_range = raw[11] != 0};
  return cicp.is_hdr() ? std::optional(cicp) : std::nullopt;
}

IccProfile grey_profile(const std::shared_ptr<Lcms>& lcms) {
  if (!lcms->make_transform(TYPE_GRAY_FLT)) return unusable(*lcms, "its curve cannot be used");
  constexpr size_t kEntries = 65536;
  std::vector<float> in(kEntries), out(3 * kEntries), table(kEntries);
  for (size_t i = 0; i < kEntries; ++i) in[i] = float(i) / (kEntries - 1);
  cmsDoTransform(lcms->transform, in.data(), out.data(), kEntries);
  for (size_t i = 0; i < kEntries; ++i) {
    table[i] = out[3 * i + 1];  // keeps grey neutral: the channels differ by white point rounding
    if (!std::isfinite(table[i])) return unusable(*lcms, "its curve is damaged");
  }
  if (!(table.back() > table.front())) return unusable(*lcms, "its curve is damaged");
  return {.profile = std::make_shared<ColorProfile>(description(lcms->profile), std::vector{curve_of_table(std::move(table))},
                                                    Mat3d::identity()),
          .problem = {},
          .grey = true};
}

IccProfile matrix_profile(const std::shared_ptr<Lcms>& lcms) {
  std::vector<ColorProfile::Curve> curves;
  for (const cmsTagSignature tag : {cmsSigRedTRCTag, cmsSigGreenTRCTag, cmsSigBlueTRCTag}) {
    curves.push_back(curve_of(lcms, tag));
    if (!curves.back()) return unusable(*lcms, "one of its curves is missing or damaged");
  }
  Mat3d colorants;
  const cmsTagSignature tags[] = {cmsSigRedColorantTag, cmsSigGreenColorantTag, cmsSigBlueColorantTag};
  for (size_t c = 0; c < 3; ++c) {
    const auto* v = static_cast<const cmsCIEXYZ*>(cmsReadTag(lcms->profile, tags[c]));
    if (!v) return unusable(*lcms, "one of its primaries is missing or damaged");
    colorants.column(c) = {v->X, v->Y, v->Z};
  }
  const Mat3d m = rec709_from_xyz_d50() * colorants;
  constexpr double kLeast = 1e-3, kDimmest = 0.5, kBrightest = 2;
  const Vec3d white = m * Vec3d{1, 1, 1};
  for (size_t c = 0; c < 3; ++c)
    if (!(white[c] > kDimmest && white[c] < kBrightest)) return unusable(*lcms, "its primaries do not add up to white");
  if (!(std::abs(determinant(m)) > kLeast)) return unusable(*lcms, "its primaries lie on a line");
  bool linear = true;
  for (double v : {0.1, 0.5, 0.9})
    for (const auto& f : curves) linear = linear && std::abs(f(v) - v) < 1e-5;
  if (linear) curves.clear();
  const auto profile = std::make_shared<ColorProfile>(description(lcms->profile), curves, m);
  return profile->is_finite() ? IccProfile{.profile = profile, .problem = {}} : unusable(*lcms, "one of its curves is damaged");
}

// True if a table matches sRGB within 1.5 8-bit steps: such photos use the exact sRGB decoding.
bool is_srgb_table(cmsHTRANSFORM transform) {
  constexpr size_t kSteps = 9;
  constexpr double kSame = 1.5 / 255;
  std::vector<float> in;
  for (size_t i = 0; i < kSteps * kSteps * kSteps; ++i)
    for (size_t c = i, k = 0; k < 3; ++k, c /= kSteps) in.push_back(float(c % kSteps) / (kSteps - 1));
  std::vector<float> out(in.size());
  cmsDoTransform(transform, in.data(), out.data(), static_cast<cmsUInt32Number>(in.size() / 3));
  for (size_t i = 0; i < in.size(); ++i)
    if (!(std::abs(srgb_from_linear(double(out[i])) - double(in[i])) < kSame)) return false;
  return true;
}

IccProfile table_profile(const std::shared_ptr<Lcms>& lcms) {
  if (!lcms->make_transform(TYPE_RGB_FLT)) return unusable(*lcms, "its tables cannot be used");
  const float ends[6] = {0, 0, 0, 1, 1, 1};
  float seen[6] = {};
  cmsDoTransform(lcms->transform, ends, seen, 2);
  for (size_t c = 0; c < 3; ++c)
    if (!(std::isfinite(seen[c]) && seen[c + 3] > seen[c])) return unusable(*lcms, "its tables are damaged");
  if (is_srgb_table(lcms->transform)) return {.profile = srgb_profile(), .problem = {}};
  return {.profile = std::make_shared<ColorProfile>(description(lcms->profile),
                                                    [lcms](const float* in, float* out, unsigned pixels) {
                                                      cmsDoTransform(lcms->transform, in, out, pixels);
                                                      for (size_t i = 0; i < 3 * size_t(pixels); ++i)
                                                        if (!std::isfinite(out[i])) out[i] = 0;
                                                    }),
          .problem = {}};
}

IccProfile read_icc(std::string_view bytes) {
  const auto lcms = std::make_shared<Lcms>();
  lcms->profile = cmsOpenProfileFromMemTHR(lcms->context->handle, bytes.data(), static_cast<cmsUInt32Number>(bytes.size()));
  if (!lcms->profile) return unusable(*lcms, fmt::format("its {} bytes are no ICC profile", bytes.size()));
  const cmsColorSpaceSignature space = cmsGetColorSpace(lcms->profile);
  if (space == cmsSigCmykData)
    return {.profile = nullptr, .problem = fmt::format("a profile of print, '{}'", description(lcms->profile)), .cmyk = true};
  const cmsProfileClassSignature kind = cmsGetDeviceClass(lcms->profile);
  if (kind != cmsSigInputClass && kind != cmsSigDisplayClass && kind != cmsSigOutputClass && kind != cmsSigColorSpaceClass)
    return unusable(*lcms, fmt::format("it is of the class '{}', which describes no picture", four_letters(kind)));
  if (space == cmsSigGrayData) return grey_profile(lcms);
  if (space != cmsSigRgbData)
    return unusable(*lcms, fmt::format("it is for pictures of the colour space '{}'", four_letters(space)));
  if (const auto cicp = cicp_of(lcms->profile))
    if (const ColorProfilePtr profile = cicp_profile(*cicp)) return {.profile = profile, .problem = {}};
  // Tables of other intents also count: Little CMS falls back to them.
  for (const cmsTagSignature table : {cmsSigAToB1Tag, cmsSigAToB0Tag, cmsSigDToB1Tag, cmsSigDToB0Tag})
    if (cmsIsTag(lcms->profile, table)) return table_profile(lcms);
  return matrix_profile(lcms);
}

}  // namespace

IccProfile icc_profile(std::string_view bytes) {
  constexpr size_t kLargest = size_t(32) << 20, kSmallest = 128, kKept = 64;
  if (bytes.size() < kSmallest || bytes.size() > kLargest)
    return {.profile = nullptr, .problem = fmt::format("its {} bytes are no ICC profile", bytes.size())};
  static std::mutex reading;
  static std::map<std::string, IccProfile> known;
  const std::string digest = digest_bytes(bytes).hex();
  const std::lock_guard lock(reading);
  if (const auto found = known.find(digest); found != known.end()) return found->second;
  if (known.size() >= kKept) known.clear();
  return known[digest] = read_icc(bytes);
}

}  // namespace vitrine
