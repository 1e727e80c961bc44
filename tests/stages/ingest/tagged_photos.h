// ICC profiles made with Little CMS, and photos that carry them: JPEG segments, PNG chunks, TIFF tags.
#pragma once

#include <lcms2.h>
#include <zlib.h>

#include <cmath>
#include <functional>
#include <memory>

#include "core/scene/image/color_profile.h"
#include "tests/support/exr_chromaticities.h"
#include "tests/support/tiny_photos.h"

namespace vitrine::test {

using Profile = std::shared_ptr<void>;
inline Profile owned(cmsHPROFILE p) {
  return {p, [](void* h) { cmsCloseProfile(h); }};
}

inline cmsToneCurve* srgb_tone() {
  const double parameters[] = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
  return cmsBuildParametricToneCurve(nullptr, 4, parameters);
}

inline Profile rgb_profile(const Chromaticities& c, cmsToneCurve* curve, const char* name) {
  const cmsCIExyY white{c.white_x, c.white_y, 1};
  const cmsCIExyYTRIPLE primaries{{c.red_x, c.red_y, 1}, {c.green_x, c.green_y, 1}, {c.blue_x, c.blue_y, 1}};
  cmsToneCurve* const curves[] = {curve, curve, curve};
  const Profile p = owned(cmsCreateRGBProfile(&white, &primaries, curves));
  cmsFreeToneCurve(curve);
  cmsMLU* const text = cmsMLUalloc(nullptr, 1);
  cmsMLUsetASCII(text, "en", "US", name);
  cmsWriteTag(p.get(), cmsSigProfileDescriptionTag, text);
  cmsMLUfree(text);
  return p;
}

inline Profile display_p3() { return rgb_profile(kDisplayP3, srgb_tone(), "Display P3"); }
inline Profile adobe_rgb() { return rgb_profile(kAdobeRgb, cmsBuildGamma(nullptr, 563.0 / 256), "Adobe RGB (1998)"); }
inline Profile prophoto() { return rgb_profile(kProPhoto, cmsBuildGamma(nullptr, 1.8), "ProPhoto RGB"); }
inline Profile linear_rec709() { return rgb_profile(kRec709, cmsBuildGamma(nullptr, 1.0), "linear"); }

// The same space as a table of steps^3 Lab colours (version 2, lut16).
inline Profile table_profile(const Profile& space, unsigned steps) {
  const Profile lab = owned(cmsCreateLab4Profile(nullptr));
  const std::shared_ptr<void> to_lab(
      cmsCreateTransform(space.get(), TYPE_RGB_16, lab.get(), TYPE_LabV2_16, INTENT_RELATIVE_COLORIMETRIC, cmsFLAGS_NOOPTIMIZE),
      [](void* t) { cmsDeleteTransform(t); });
  cmsStage* const table = cmsStageAllocCLut16bit(nullptr, steps, 3, 3, nullptr);
  cmsStageSampleCLut16bit(
      table,
      [](const cmsUInt16Number* in, cmsUInt16Number* out, void* transform) -> cmsInt32Number {
        cmsDoTransform(transform, in, out, 1);
        return 1;
      },
      to_lab.get(), 0);
  cmsPipeline* const pipeline = cmsPipelineAlloc(nullptr, 3, 3);
  cmsPipelineInsertStage(pipeline, cmsAT_END, table);
  const Profile scanner = owned(cmsCreateProfilePlaceholder(nullptr));
  cmsSetProfileVersion(scanner.get(), 2.1);
  cmsSetDeviceClass(scanner.get(), cmsSigInputClass);
  cmsSetColorSpace(scanner.get(), cmsSigRgbData);
  cmsSetPCS(scanner.get(), cmsSigLabData);
  cmsWriteTag(scanner.get(), cmsSigMediaWhitePointTag, cmsD50_XYZ());
  cmsWriteTag(scanner.get(), cmsSigAToB0Tag, pipeline);
  cmsPipelineFree(pipeline);
  return scanner;
}

inline std::string icc_bytes(const Profile& profile) {
  cmsUInt32Number size = 0;
  cmsSaveProfileToMem(profile.get(), nullptr, &size);
  std::string bytes(size, '\0');
  cmsSaveProfileToMem(profile.get(), bytes.data(), &size);
  return bytes;
}

// Pixels of three floats from one space to another as Little CMS sees it: relative colorimetric, not clipped.
inline ImageF converted(const ImageF& image, const Profile& from, const Profile& to) {
  ImageF out(image.width(), image.height(), 3);
  const std::shared_ptr<void> transform(cmsCreateTransform(from.get(), TYPE_RGB_FLT, to.get(), TYPE_RGB_FLT,
                                                           INTENT_RELATIVE_COLORIMETRIC, cmsFLAGS_NOCACHE | cmsFLAGS_NOOPTIMIZE),
                                        [](void* t) { cmsDeleteTransform(t); });
  cmsDoTransform(transform.get(), image.data().data(), out.data().data(), static_cast<cmsUInt32Number>(image.pixel_count()));
  return out;
}

template <class T>
Image<T> quantised(const ImageF& image, double largest) {
  Image<T> out(image.width(), image.height(), image.channels());
  for (size_t i = 0; i < out.data().size(); ++i)
    out.data()[i] = static_cast<T>(std::lround(std::clamp(double(image.data()[i]), 0.0, 1.0) * largest));
  return out;
}
inline Image8 in_8_bits(const ImageF& image) { return quantised<uint8_t>(image, 255); }
inline Image16 in_16_bits(const ImageF& image) { return quantised<uint16_t>(image, 65535); }

// `order`: numbers of the parts as they come in the file, from 1; empty: all in order.
inline void add_icc_to_jpeg(const fs::path& jpeg, const std::string& icc, size_t parts = 1, std::vector<size_t> order = {}) {
  for (size_t i = 1; order.size() < parts && i <= parts; ++i) order.push_back(i);
  const std::string bytes = read_file(jpeg);
  const size_t each = (icc.size() + parts - 1) / parts;
  Fields out(true);
  for (size_t number : order) {
    const std::string part = icc.substr((number - 1) * each, each);
    out.raw("\xff\xe2");
    out.u16(static_cast<unsigned>(part.size() + 16));
    out.raw(std::string("ICC_PROFILE\0", 12) + char(number) + char(parts));
    out.raw(part);
  }
  write_file(jpeg, bytes.substr(0, 2) + out.bytes + bytes.substr(2));
}

inline std::string png_chunk(const std::string& type, const std::string& data) {
  Fields out(true);
  out.u32(static_cast<unsigned>(data.size()));
  out.raw(type + data);
  const std::string checked = type + data;
  out.u32(static_cast<unsigned>(crc32(0, reinterpret_cast<const Bytef*>(checked.data()), static_cast<uInt>(checked.size()))));
  return out.bytes;
}
inline std::string icc_chunk(const std::string& icc) {
  std::string packed(compressBound(icc.size()), '\0');
  uLongf size = packed.size();
  compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(icc.data()), icc.size());
  packed.resize(size);
  return png_chunk("iCCP", std::string("profile\0\0", 9) + packed);
}
inline std::string numbers_chunk(const std::string& type, const std::vector<unsigned>& numbers) {
  Fields data(true);
  for (unsigned n : numbers) data.u32(n);
  return png_chunk(type, data.bytes);
}
// Behind IHDR.
inline void add_to_png(const fs::path& png, const std::string& chunks) {
  const std::string bytes = read_file(png);
  constexpr size_t kHead = 8 + 25;
  write_file(png, bytes.substr(0, kHead) + chunks + bytes.substr(kHead));
}

}  // namespace vitrine::test
