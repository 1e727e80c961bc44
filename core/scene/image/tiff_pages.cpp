#include "core/scene/image/tiff_pages.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "core/foundation/base/file.h"
#include "core/scene/image/tiff_directory.h"

namespace vitrine {

namespace {

constexpr size_t kMaxPages = 4096, kMaxValues = 1024;

enum TiffTag : unsigned {
  kNewSubfileType = 254,
  kSubfileType = 255,
  kWidth = 256,
  kHeight = 257,
  kBitsPerSample = 258,
  kCompression = 259,
  kPhotometric = 262,
  kMake = 271,
  kOrientation = 274,
  kSamplesPerPixel = 277,
  kPlanarConfiguration = 284,
  kColourMap = 320,
  kSubDirectories = 330,
  kExtraSamples = 338,
  kSampleFormat = 339,
  kExifDirectory = 34665,
  kDngVersion = 50706,
};
enum TiffPhotometric : unsigned {
  kMinIsWhite = 0,
  kMinIsBlack = 1,
  kRgb = 2,
  kPalette = 3,
  kTransparencyMask = 4,
  kSeparated = 5,
  kYcbcr = 6,
  kCieLab = 8,
  kIccLab = 9,
  kItuLab = 10,
  kColourFilterArray = 32803,
  kLinearRaw = 34892,
  kLogL = 32844,
  kLogLuv = 32845,
};

struct TiffReadPage {
  TiffPage page;
  std::vector<uint64_t> sub_directories;
  bool dng = false, has_photometric = false;
  std::string make;
};

// Values from which several members of a page are derived.
struct TiffPageValues {
  uint64_t old_type = 0, new_type = 0;
  std::vector<uint64_t> bits, formats;
};

void take_entry(const TiffBytes& in, const TiffEntry& e, TiffReadPage& r, TiffPageValues& v) {
  TiffPage& p = r.page;
  const auto value = [&](uint64_t i) { return in.number(e.values + i * e.size, e.size); };
  const auto list = [&] {
    std::vector<uint64_t> all;
    for (uint64_t i = 0; i < std::min<uint64_t>(e.count, kMaxValues); ++i) all.push_back(value(i));
    return all;
  };
  if (e.tag == kDngVersion) r.dng = true;

  if (e.tag == kMake && e.type == 2) r.make = lowered(in.text(e.values, std::min<uint64_t>(e.count, 64)));
  if (!is_tiff_whole_number(e.type) || e.count == 0) return;
  const auto one = [&] { return static_cast<unsigned>(value(0)); };
  switch (e.tag) {
    case kNewSubfileType:
      v.new_type = value(0);
      break;
    case kSubfileType:
      v.old_type = value(0);
      break;
    case kWidth:
      p.width = value(0);
      break;
    case kHeight:
      p.height = value(0);
      break;
    case kBitsPerSample:
      v.bits = list();
      break;
    case kSampleFormat:
      v.formats = list();
      break;
    case kCompression:
      p.compression = one();
      break;
    case kPhotometric:
      p.photometric = one(), r.has_photometric = true;
      break;
    case kOrientation:
      p.orientation = one();
      break;
    case kSamplesPerPixel:
      p.samples = one();
      break;
    case kPlanarConfiguration:
      p.planar = one() == 2;
      break;
    case kSubDirectories:
      r.sub_directories = list();
      break;
    case kExifDirectory:
      p.exif_directory = value(0);
      break;
    case kColourMap: {
      const std::vector<uint64_t> all = list();
      p.palette.assign(all.begin(), all.end());
      break;
    }
    case kExtraSamples: {
      const std::vector<uint64_t> all = list();
      p.extra.emplace(all.begin(), all.end());
      break;
    }
    default:
      break;
  }
}

TiffReadPage tiff_page_of(const TiffBytes& in, const TiffDirectory& directory, uint64_t at) {
  TiffReadPage r;
  TiffPage& p = r.page;
  p.directory = at;
  TiffPageValues values;
  directory.each([&](const TiffEntry& e) { take_entry(in, e, r, values); });
  const auto first = [](const std::vector<uint64_t>& list, unsigned otherwise) {
    return list.empty() ? otherwise : static_cast<unsigned>(list[0]);
  };
  const auto equal = [](const std::vector<uint64_t>& list) {
    return std::all_of(list.begin(), list.end(), [&](uint64_t v) { return v == list[0]; });
  };
  p.bits = first(values.bits, 1);
  p.sample_format = first(values.formats, 1);
  p.equal_samples = equal(values.bits) && equal(values.formats);
  if (p.orientation < 1 || p.orientation > 8) p.orientation = 1;
  p.reduced = (values.new_type & 1) != 0 || values.old_type == 2;
  p.mask = (values.new_type & 4) != 0;
  if (!r.has_photometric)
    p.photometric = p.samples >= 3 ? kRgb : p.compression >= 2 && p.compression <= 4 ? kMinIsWhite : kMinIsBlack;
  return r;
}

// Camera-specific compressions and photometric interpretations of raw sensor data.
bool is_sensor(const TiffPage& p) {
  return p.photometric == kColourFilterArray || p.photometric == kLinearRaw || p.compression == 34713 /* NEF */ ||
         p.compression == 32767 /* ARW */ || p.compression == 32769 || p.compression == 65000 || p.compression == 65535;
}

std::string raw_name(const std::string& make, bool dng, std::string_view bytes) {
  if (dng) return "DNG";
  if (bytes.size() > 10 && bytes.substr(8, 2) == "CR") return "CR2";
  for (const auto& [maker, kind] :
       {std::pair{"nikon", "NEF"}, {"sony", "ARW"}, {"pentax", "PEF"}, {"canon", "CR2"}, {"samsung", "SRW"}})
    if (make.starts_with(maker)) return kind;
  return "raw";
}

bool better(const TiffPage& a, const TiffPage& b) {  // true if a is preferred to b, which precedes it
  if (a.mask != b.mask) return b.mask;
  if (a.reduced != b.reduced) return b.reduced;
  return a.width * a.height > b.width * b.height;
}

}  // namespace

bool is_tiff(std::string_view b) {
  const std::string_view start = b.substr(0, 4);
  return start == std::string_view("II*\0", 4) || start == std::string_view("MM\0*", 4) ||
         start == std::string_view("II+\0", 4) || start == std::string_view("MM\0+", 4);
}

TiffPages tiff_pages(std::string_view bytes) {
  TiffPages out;
  if (!is_tiff(bytes)) return out;
  out.big_endian = bytes[0] == 'M';
  const TiffBytes in(bytes, out.big_endian);
  out.big = in.number(2, 2) == 43;
  std::set<uint64_t> seen;
  bool dng = false, sensor = bytes.size() > 10 && bytes.substr(8, 2) == "CR" && !out.big;
  std::string make;
  // Adds the page at `at`; returns its sub-directories and the offset of the next page (0 = last).
  const auto add = [&](uint64_t at, bool sub) -> std::pair<std::vector<uint64_t>, uint64_t> {
    const TiffDirectory directory(in, out.big, at);
    if (!directory.whole() || out.pages.size() == kMaxPages || !seen.insert(at).second) {
      out.damaged = true;
      return {};
    }
    TiffReadPage r = tiff_page_of(in, directory, at);
    r.page.sub_directory = sub;
    dng |= r.dng;
    sensor |= is_sensor(r.page);
    if (make.empty()) make = r.make;
    out.pages.push_back(r.page);
    return {r.sub_directories, directory.next()};
  };
  for (uint64_t at = in.number(out.big ? 8 : 4, out.big ? 8 : 4); at != 0;) {
    const auto [below, next] = add(at, false);
    for (const uint64_t sub : below) add(sub, true);
    at = next;
  }
  for (size_t i = 1; i < out.pages.size(); ++i)
    if (better(out.pages[i], out.pages[out.picture])) out.picture = i;
  if (dng || sensor) out.raw = raw_name(make, dng, bytes);
  return out;
}

TiffChannels tiff_channels(const TiffPage& p) {
  TiffChannels c;
  c.colours = p.photometric == kRgb || p.photometric == kYcbcr ? 3 : 1;
  if (p.samples <= c.colours) return c;
  const unsigned further = p.samples - c.colours;
  // Old RGBA writers omit the tag; a fourth channel declared as unspecified is not used as alpha.
  if (!p.extra) {
    if (c.colours == 3 && further == 1) c.alpha = 3;
  } else {
    for (unsigned i = 0; i < further && i < p.extra->size() && !c.alpha; ++i)
      if ((*p.extra)[i] == 1 || (*p.extra)[i] == 2) c.alpha = c.colours + i, c.premultiplied = (*p.extra)[i] == 1;
  }
  c.dropped = further - (c.alpha ? 1 : 0);
  return c;
}

std::string tiff_refusal(const TiffPages& t) {
  constexpr const char* kExport = "export it as RGB, 8 or 16 bit";
  if (t.pages.empty()) return "the TIFF has no directory at the offset in its header: the file is truncated or damaged";
  if (!t.raw.empty())
    return fmt::format("it is a raw photo{}: develop it and export a 16-bit TIFF or a JPEG",
                       t.raw == "raw" ? "" : fmt::format(" ({})", t.raw));
  const TiffPage& p = t.chosen();
  if (t.damaged && p.reduced)
    return "only a thumbnail of the TIFF is left: the directory of its picture lies outside of the file";
  if (p.compression == 6) return fmt::format("the TIFF is compressed by the old kind of JPEG, which is not read: {}", kExport);
  if (p.width == 0 || p.height == 0) return "the size of the TIFF is missing: it is damaged";
  switch (p.photometric) {
    case kMinIsWhite:
    case kMinIsBlack:
    case kRgb:
    case kPalette:
    case kTransparencyMask:
    case kYcbcr:
      break;
    case kSeparated:
      return fmt::format("the TIFF is CMYK (densities of inks): {}", kExport);
    case kCieLab:
    case kIccLab:
    case kItuLab:
      return fmt::format("the TIFF is in Lab colours: {}", kExport);
    case kLogL:
    case kLogLuv:
      return "the TIFF is LogLuv (high dynamic range): export it as OpenEXR or as a float TIFF of RGB";
    default:
      return fmt::format("the TIFF has colours of an unknown kind (photometric interpretation {}): {}", p.photometric, kExport);
  }
  const unsigned colours = tiff_channels(p).colours;
  if (p.samples < colours) return fmt::format("the TIFF is declared as RGB and has {} channels: it is damaged", p.samples);
  if (p.photometric == kPalette && p.samples != 1)
    return fmt::format("the TIFF has a palette and {} channels: {}", p.samples, kExport);
  if (!p.equal_samples) return fmt::format("the channels of the TIFF differ in bits or format: {}", kExport);
  const unsigned bits = p.bits;
  switch (p.sample_format) {
    case 1:
    case 4:
      if (!((bits >= 1 && bits <= 16) || bits == 32)) return fmt::format("the TIFF has {} bits per sample: {}", bits, kExport);
      if (p.photometric == kPalette && bits > 8) return fmt::format("the TIFF has a palette of {} bits: {}", bits, kExport);
      if (p.photometric == kPalette && p.palette.size() < size_t(3) << bits)
        return "the palette of the TIFF is missing or cut short";
      if (p.photometric == kYcbcr && bits != 8) return fmt::format("the TIFF is YCbCr of {} bits: {}", bits, kExport);
      return "";
    case 2:
      return fmt::format("the samples of the TIFF are signed whole numbers, with unknown black and white levels: {}", kExport);
    case 3:
      if (bits == 24) return "the TIFF has floating-point samples of 24 bits: export it with 16 or 32 bits";
      if (bits != 16 && bits != 32 && bits != 64)
        return fmt::format("the TIFF has floating-point samples of {} bits: it is damaged", bits);
      if (p.photometric == kMinIsWhite || p.photometric == kPalette || p.photometric == kYcbcr)
        return fmt::format("the TIFF has floating-point samples of another kind than grey and RGB: {}", kExport);
      return "";
    case 5:
    case 6:
      return fmt::format("the samples of the TIFF are complex numbers: {}", kExport);
    default:
      return fmt::format("the TIFF has samples of an unknown format ({}): {}", p.sample_format, kExport);
  }
}

std::vector<std::string> tiff_notes(const TiffPages& t) {
  std::vector<std::string> notes;
  if (t.pages.empty()) return notes;
  const TiffPage& p = t.chosen();
  size_t full = 0;  // number of pages that could also be the main page
  for (const TiffPage& other : t.pages)
    full += !other.reduced && !other.mask && !other.sub_directory && other.width * other.height == p.width * p.height;
  if (full > 1 && !p.reduced)
    notes.push_back(fmt::format("a TIFF of {} pages of equal size: the first is read", full));
  else if (t.picture != 0)
    notes.emplace_back("a TIFF whose first page is not its largest: the largest is read");
  const TiffChannels c = tiff_channels(p);
  if (c.premultiplied) notes.emplace_back("a TIFF whose colours are multiplied by its alpha: they are divided by it");
  if (c.dropped > 0)
    notes.push_back(fmt::format("a TIFF of {} channels: {} of unknown meaning {} left out", p.samples, c.dropped,
                                c.dropped == 1 ? "is" : "are"));
  if (t.damaged) notes.emplace_back("a TIFF with damaged further pages: they are left out");
  return notes;
}

}  // namespace vitrine
