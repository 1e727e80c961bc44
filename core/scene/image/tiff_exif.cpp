#include <string>
#include <vector>

#include "core/scene/image/tiff_directory.h"
#include "core/scene/image/tiff_pages.h"

namespace vitrine {

namespace {

constexpr unsigned kTagOfExif = 34665, kTypeLong = 4;
constexpr uint64_t kLargestField = 1024;  // maker notes and previews are dropped
constexpr size_t kHeaderBytes = 8, kEntryBytes = 12, kMostFields = 256;
constexpr unsigned kMaker = 271, kModel = 272, kOrientationTag = 274, kSoftware = 305, kTime = 306;

class TiffWriter {
 public:
  explicit TiffWriter(bool big_endian) : big_endian_(big_endian) {}
  void number(std::string& to, uint64_t v, size_t n) const {
    for (size_t i = 0; i < n; ++i) to += static_cast<char>(v >> 8 * (big_endian_ ? n - 1 - i : i));
  }

 private:
  bool big_endian_;
};

struct TiffCopiedField {
  unsigned tag, type;
  uint64_t count;
  std::string values;
};

// Fields accepted by `wanted`, of classic TIFF types and small enough.
template <class F>
std::vector<TiffCopiedField> fields_of(const TiffBytes& in, bool big, uint64_t at, F&& wanted) {
  std::vector<TiffCopiedField> fields;
  TiffDirectory(in, big, at).each([&](const TiffEntry& e) {
    if (e.size == 0 || e.type > 12 || e.count == 0 || e.count > kLargestField / e.size || fields.size() == kMostFields) return;
    const std::string_view values = in.text(e.values, e.count * e.size);
    if (!values.empty() && wanted(e.tag)) fields.push_back({e.tag, e.type, e.count, std::string(values)});
  });
  return fields;
}

size_t directory_bytes(const std::vector<TiffCopiedField>& fields) {
  size_t bytes = 2 + kEntryBytes * fields.size() + 4;
  for (const TiffCopiedField& f : fields) bytes += f.values.size() > 4 ? f.values.size() + f.values.size() % 2 : 0;
  return bytes;
}

// Serialises a directory for offset `at`, followed by its values.
std::string directory_of(const TiffWriter& w, const std::vector<TiffCopiedField>& fields, size_t at) {
  std::string out, values;
  const size_t values_at = at + 2 + kEntryBytes * fields.size() + 4;
  w.number(out, fields.size(), 2);
  for (const TiffCopiedField& f : fields) {
    w.number(out, f.tag, 2);
    w.number(out, f.type, 2);
    w.number(out, f.count, 4);
    if (f.values.size() <= 4) {
      out += f.values + std::string(4 - f.values.size(), '\0');
    } else {
      w.number(out, values_at + values.size(), 4);
      values += f.values + std::string(f.values.size() % 2, '\0');
    }
  }
  w.number(out, 0, 4);
  return out + values;
}

}  // namespace

std::string tiff_exif_block(std::string_view bytes) {
  const TiffPages pages = tiff_pages(bytes);
  if (pages.pages.empty()) return {};
  const TiffPage& page = pages.chosen().exif_directory != 0 ? pages.chosen() : pages.pages[0];
  const TiffBytes in(bytes, pages.big_endian);
  const TiffWriter writer(pages.big_endian);
  std::vector<TiffCopiedField> first = fields_of(in, pages.big, page.directory, [](unsigned tag) {
    return tag == kMaker || tag == kModel || tag == kOrientationTag || tag == kSoftware || tag == kTime;
  });
  std::vector<TiffCopiedField> exif;
  if (page.exif_directory != 0)
    exif = fields_of(in, pages.big, page.exif_directory, [](unsigned tag) { return tag != kTagOfExif; });
  std::string place(4, '\0');
  if (!exif.empty()) {
    first.push_back({kTagOfExif, kTypeLong, 1, place});
    place.clear();
    writer.number(place, kHeaderBytes + directory_bytes(first), 4);
    first.back().values = place;
  }
  std::string block("Exif\0\0", 6);
  block += pages.big_endian ? "MM" : "II";
  writer.number(block, 42, 2);
  writer.number(block, kHeaderBytes, 4);
  block += directory_of(writer, first, kHeaderBytes);
  if (!exif.empty()) block += directory_of(writer, exif, kHeaderBytes + directory_bytes(first));
  return block;
}

}  // namespace vitrine
