// Directory entries of a TIFF (classic or BigTIFF) according to TIFF 6.0 and the BigTIFF design. For tiff_*.cpp only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string_view>

namespace vitrine {

inline constexpr size_t kMaxTiffEntries = 4096;

class TiffBytes {
 public:
  TiffBytes(std::string_view bytes, bool big_endian) : bytes_(bytes), big_endian_(big_endian) {}
  bool holds(uint64_t at, uint64_t n) const { return at <= bytes_.size() && n <= bytes_.size() - at; }
  // 0 beyond the end.
  uint64_t number(uint64_t at, size_t n) const {
    if (!holds(at, n)) return 0;
    uint64_t v = 0;
    for (size_t i = 0; i < n; ++i) v = v << 8 | static_cast<unsigned char>(bytes_[at + (big_endian_ ? i : n - 1 - i)]);
    return v;
  }
  std::string_view text(uint64_t at, uint64_t n) const { return holds(at, n) ? bytes_.substr(at, n) : std::string_view(); }

 private:
  std::string_view bytes_;
  bool big_endian_;
};

// Bytes per value of this type; 0 for invalid types.
inline size_t tiff_type_size(uint64_t type) {
  constexpr size_t kSizes[] = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8};
  return type < std::size(kSizes) ? kSizes[type] : 0;
}
// BYTE, SHORT, LONG, IFD, LONG8, IFD8.
inline bool is_tiff_whole_number(uint64_t type) {
  return type == 1 || type == 3 || type == 4 || type == 13 || type == 16 || type == 18;
}

struct TiffEntry {
  unsigned tag = 0, type = 0;
  size_t size = 0;      // bytes per value
  uint64_t count = 0;   // number of values
  uint64_t values = 0;  // their offset in the file
};

// One directory: offset and entries.
class TiffDirectory {
 public:
  TiffDirectory(const TiffBytes& in, bool big, uint64_t at) : in_(in), big_(big), at_(at) {
    entries_ = in.number(at, big ? 8 : 2);
    whole_ = entries_ > 0 && entries_ <= kMaxTiffEntries && in.holds(at, head() + entries_ * entry_size() + offset_size());
    if (!whole_) entries_ = 0;
  }
  bool whole() const { return whole_; }
  uint64_t next() const { return whole_ ? in_.number(at_ + head() + entries_ * entry_size(), offset_size()) : 0; }

  template <class F>
  void each(F&& visit) const {
    for (uint64_t i = 0; i < entries_; ++i) {
      const uint64_t entry = at_ + head() + i * entry_size();
      TiffEntry e{.tag = static_cast<unsigned>(in_.number(entry, 2)), .type = static_cast<unsigned>(in_.number(entry + 2, 2))};
      e.size = tiff_type_size(e.type);
      e.count = in_.number(entry + 4, offset_size());
      const uint64_t inline_at = entry + 4 + offset_size();
      e.values = e.size > 0 && e.count > offset_size() / e.size ? in_.number(inline_at, offset_size()) : inline_at;
      visit(e);
    }
  }

 private:
  uint64_t head() const { return big_ ? 8 : 2; }
  uint64_t entry_size() const { return big_ ? 20 : 12; }
  size_t offset_size() const { return big_ ? 8 : 4; }
  const TiffBytes& in_;
  bool big_, whole_ = false;
  uint64_t at_, entries_ = 0;
};

}  // namespace vitrine
