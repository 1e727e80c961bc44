#include "core/scene/image/heif_file.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "core/scene/image/camera_codecs.h"
#include "core/scene/image/segments.h"

namespace vitrine {

namespace {

constexpr size_t kMostItems = 1 << 14, kMostExtents = 64, kLargestExif = size_t(1) << 20;
constexpr std::string_view kExifMagic("Exif\0\0", 6);

// A box: its type and payload. `version`: of those that have one; `body` is behind version and flags.
struct Box {
  std::string_view type, body;
  size_t at = 0;     // offset of the body in the file
  uint64_t end = 0;  // offset behind the box, as its header states it
};

// Consumes big-endian numbers; 0 beyond the end.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}
  uint64_t number(size_t n) {
    const uint64_t v = number_at(bytes_, at_, n, true);
    at_ = std::min(at_ + n, bytes_.size());
    return v;
  }
  bool more() const { return at_ < bytes_.size(); }
  std::string_view rest() const { return bytes_.substr(at_); }

 private:
  std::string_view bytes_;
  size_t at_ = 0;
};

// Calls `visit` for each box of `bytes`, which begin at offset `at` of the file.
template <class F>
void each_box(std::string_view bytes, size_t at, F&& visit) {
  for (size_t i = 0; i + 8 <= bytes.size();) {
    uint64_t size = number_at(bytes, i, 4, true);
    size_t head = 8;
    if (size == 1) size = number_at(bytes, i + 8, 8, true), head = 16;
    if (size == 0) size = bytes.size() - i;  // to the end
    if (size < head || i + head > bytes.size()) return;
    const size_t held = size_t(std::min<uint64_t>(size, bytes.size() - i));
    visit(Box{bytes.substr(i + 4, 4), bytes.substr(i + head, held - head), at + i + head, at + i + size});
    if (size > bytes.size() - i) return;
    i += size_t(size);
  }
}

// Version and flags of a full box; `box` becomes what is behind them.
unsigned version_of(Box& box) {
  const auto version = unsigned(number_at(box.body, 0, 1, true));
  const size_t head = std::min<size_t>(4, box.body.size());
  box.body.remove_prefix(head);
  box.at += head;
  return version;
}

struct Extent {
  uint64_t at = 0, size = 0;
};
struct Item {
  std::string_view type;
  bool in_meta_box = false;  // extents are relative to the box 'idat'
  std::vector<Extent> extents;
  std::vector<size_t> properties;  // indices into Items::properties, in the order of application
};
struct Reference {
  std::string_view type;
  size_t type_at = 0;
  uint64_t from = 0;
  std::vector<uint64_t> to;
};

struct Items {
  uint64_t primary = 0;
  std::map<uint64_t, Item> items;
  std::vector<Box> properties;
  std::vector<Reference> references;
  Box meta_data;  // 'idat'

  const Item* find(uint64_t id) const {
    const auto found = items.find(id);
    return found == items.end() ? nullptr : &found->second;
  }
};

void read_types(Items& out, Box box) {
  const size_t head = version_of(box) == 0 ? 2 : 4;
  if (box.body.size() < head) return;
  each_box(box.body.substr(head), box.at + head, [&](Box entry) {
    if (entry.type != "infe" || out.items.size() >= kMostItems) return;
    const unsigned version = version_of(entry);
    if (version < 2) return;
    ByteReader in(entry.body);
    const uint64_t id = in.number(version == 2 ? 2 : 4);
    in.number(2);  // protection
    out.items[id].type = in.rest().substr(0, 4);
  });
}

void read_places(Items& out, Box box) {
  const unsigned version = version_of(box);
  ByteReader in(box.body);
  const uint64_t sizes = in.number(2);
  const size_t offset_size = sizes >> 12 & 15, length_size = sizes >> 8 & 15, base_size = sizes >> 4 & 15,
               index_size = version == 0 ? 0 : sizes & 15;
  const uint64_t count = in.number(version < 2 ? 2 : 4);
  for (uint64_t i = 0; i < count && in.more() && i < kMostItems; ++i) {
    const uint64_t id = in.number(version < 2 ? 2 : 4);
    const uint64_t method = version == 0 ? 0 : in.number(2) & 15;
    in.number(2);  // data reference: this file
    const uint64_t base = in.number(base_size), extents = in.number(2);
    const auto item = out.items.find(id);
    for (uint64_t e = 0; e < extents && in.more(); ++e) {
      in.number(index_size);
      const uint64_t at = in.number(offset_size), size = in.number(length_size);
      if (item == out.items.end() || item->second.extents.size() >= kMostExtents) continue;
      item->second.in_meta_box = method == 1;
      item->second.extents.push_back({base + at, size});
    }
  }
}

void read_references(Items& out, Box box) {
  const size_t id_size = version_of(box) == 0 ? 2 : 4;
  each_box(box.body, box.at, [&](const Box& b) {
    if (out.references.size() >= kMostItems) return;
    ByteReader in(b.body);
    Reference r{.type = b.type, .type_at = b.at - 4, .from = in.number(id_size), .to = {}};
    const uint64_t count = in.number(2);
    for (uint64_t i = 0; i < count && in.more(); ++i) r.to.push_back(in.number(id_size));
    out.references.push_back(std::move(r));
  });
}

void read_properties(Items& out, Box box) {
  std::vector<Box> associations;
  each_box(box.body, box.at, [&](const Box& b) {
    if (b.type == "ipco")
      each_box(b.body, b.at, [&](const Box& property) {
        if (out.properties.size() < kMostItems) out.properties.push_back(property);
      });
    if (b.type == "ipma") associations.push_back(b);
  });
  for (Box& b : associations) {
    const bool wide = (number_at(b.body, 3, 1, true) & 1) != 0;  // of the flags
    const unsigned version = version_of(b);
    ByteReader in(b.body);
    const uint64_t count = in.number(4);
    for (uint64_t i = 0; i < count && in.more(); ++i) {
      const auto item = out.items.find(in.number(version == 0 ? 2 : 4));
      const uint64_t n = in.number(1);
      for (uint64_t k = 0; k < n && in.more(); ++k) {
        const uint64_t index = in.number(wide ? 2 : 1) & (wide ? 0x7fff : 0x7f);  // from 1; the top bit: essential
        if (item != out.items.end() && index >= 1 && index <= out.properties.size())
          item->second.properties.push_back(size_t(index - 1));
      }
    }
  }
}

Items items_of(Box meta) {
  version_of(meta);
  Items out;
  std::vector<Box> boxes;
  each_box(meta.body, meta.at, [&](const Box& b) { boxes.push_back(b); });
  const auto each = [&](std::string_view type, auto&& read) {
    for (const Box& b : boxes)
      if (b.type == type) read(b);
  };
  each("iinf", [&](const Box& b) { read_types(out, b); });  // first: the others refer to the items
  each("pitm", [&](Box b) { out.primary = version_of(b) == 0 ? number_at(b.body, 0, 2, true) : number_at(b.body, 0, 4, true); });
  each("iloc", [&](const Box& b) { read_places(out, b); });
  each("iref", [&](const Box& b) { read_references(out, b); });
  each("iprp", [&](const Box& b) { read_properties(out, b); });
  each("idat", [&](const Box& b) { out.meta_data = b; });
  return out;
}

// Size, turn, bits and colours of the primary picture.
void take_properties(const Items& items, const Item& item, HeifFile& file) {
  for (const size_t index : item.properties) {
    Box p = items.properties[index];
    if (p.type == "ispe") {
      version_of(p);
      file.width = number_at(p.body, 0, 4, true);
      file.height = number_at(p.body, 4, 4, true);
    } else if (p.type == "clap") {  // fractions: width, height, offsets
      const auto part = [&](size_t at) {
        const uint64_t n = number_at(p.body, at, 4, true), d = number_at(p.body, at + 4, 4, true);
        return d > 0 ? n / d : 0;
      };
      if (part(0) > 0 && part(0) <= file.width && part(8) > 0 && part(8) <= file.height)
        file.width = part(0), file.height = part(8);
    } else if (p.type == "irot") {
      if (number_at(p.body, 0, 1, true) & 1) std::swap(file.width, file.height);
    } else if (p.type == "pixi") {
      version_of(p);
      file.bits = std::max(unsigned(number_at(p.body, 1, 1, true)), 1u);
    } else if (p.type == "colr" && p.body.starts_with("nclx")) {
      file.nclx = Cicp{.primaries = unsigned(number_at(p.body, 4, 2, true)),
                       .transfer = unsigned(number_at(p.body, 6, 2, true)),
                       .matrix = 0,
                       .full_range = true};
    } else if (p.type == "colr" && (p.body.starts_with("prof") || p.body.starts_with("rICC"))) {
      file.icc = p.body.substr(4);
    }
  }
}

bool is_alpha(const Items& items, uint64_t id) {
  const Item* const item = items.find(id);
  return item && std::any_of(item->properties.begin(), item->properties.end(), [&](size_t index) {
           Box p = items.properties[index];
           if (p.type != "auxC") return false;
           version_of(p);
           const std::string_view urn = p.body.substr(0, p.body.find('\0'));
           return urn == "urn:mpeg:mpegB:cicp:systems:auxiliary:alpha" || urn == "urn:mpeg:hevc:2015:auxid:1" ||
                  urn == "urn:mpeg:avc:2015:auxid:1";
         });
}

// The bytes of an item; empty if a part of them is missing.
std::string item_bytes(std::string_view file, const Items& items, const Item& item, size_t most) {
  const std::string_view from = item.in_meta_box ? items.meta_data.body : file;
  std::string out;
  for (const Extent& e : item.extents) {
    if (e.at > from.size() || e.size > from.size() - e.at || e.size > most - out.size()) return {};
    out += from.substr(e.at, e.size);
  }
  return out;
}

// Metadata of the primary picture. Its first four bytes are the offset of the TIFF structure behind them.
std::string exif_of(std::string_view bytes, const Items& items) {
  for (const Reference& r : items.references) {
    const Item* const item = items.find(r.from);
    if (r.type != "cdsc" || !item || item->type != "Exif") continue;
    if (std::find(r.to.begin(), r.to.end(), items.primary) == r.to.end()) continue;
    const std::string data = item_bytes(bytes, items, *item, kLargestExif);
    const uint64_t offset = number_at(data, 0, 4, true);
    if (data.size() > 4 && offset < data.size() - 4) return std::string(kExifMagic).append(data.substr(4 + offset));
  }
  return {};
}

}  // namespace

HeifFile heif_file(std::string_view bytes) {
  HeifFile file;
  std::optional<Box> meta;
  each_box(bytes, 0, [&](const Box& b) {
    file.needed_bytes = std::max(file.needed_bytes, b.end);
    if (b.type == "meta" && !meta) meta = b;
  });
  if (!meta) return file;
  const Items items = items_of(*meta);
  const Item* const primary = items.find(items.primary);
  if (!primary) return file;
  file.coding = primary->type;
  // Tiles of a grid have what the grid leaves out.
  for (const Reference& r : items.references) {
    if (r.type == "auxl") {
      file.alpha = file.alpha || (is_alpha(items, r.from) && std::find(r.to.begin(), r.to.end(), items.primary) != r.to.end());
      if (r.to.size() > 1) file.shared_auxiliaries.push_back(r.type_at);
    }
    if (r.type != "dimg" || r.from != items.primary || r.to.empty()) continue;
    if (const Item* const tile = items.find(r.to[0])) take_properties(items, *tile, file);
  }
  const bool tiled = file.width > 0;
  if (tiled) file.width = file.height = 0;
  take_properties(items, *primary, file);
  for (const auto& entry : items.items)
    for (const Extent& e : entry.second.extents)
      if (!entry.second.in_meta_box && e.size <= UINT64_MAX - e.at)
        file.needed_bytes = std::max(file.needed_bytes, e.at + e.size);
  file.exif = exif_of(bytes, items);
  return file;
}

std::string heif_refusal(const HeifFile& file, std::string_view bytes, std::string_view kind) {
  if (file.needed_bytes > bytes.size())
    return fmt::format("it is {} of which {} of {} bytes are there: the copy was cut short; copy it again", kind, bytes.size(),
                       file.needed_bytes);
  if (file.coding.empty()) return fmt::format("it is {} without a picture: the copy was cut short; copy it again", kind);
  if (file.width == 0 || file.height == 0) return fmt::format("it is {} that does not state its size: it is damaged", kind);
  return {};
}

std::string decoded_heif(std::string_view bytes, std::string_view kind, Image8& out8, Image16& out16) {
  const HeifFile file = heif_file(bytes);
  if (std::string why = heif_refusal(file, bytes, kind); !why.empty()) return why;
  std::string why = camera_codecs().heif(bytes, file.alpha, out8, out16);
  if (why.empty()) return {};
  if (!file.shared_auxiliaries.empty() &&
      camera_codecs().heif(without_shared_auxiliaries(bytes, file), false, out8, out16).empty())
    return {};
  return fmt::format(
      "it is {}: {}. Any of these helps: set the phone to \"Most Compatible\" (Settings, Camera, Formats); share the photos as "
      "JPEG "
      "from the phone; convert them to JPEG or TIFF (heif-convert, magick); build with a newer libheif (Debian 13 has 1.19)",
      kind, why);
}

std::string without_shared_auxiliaries(std::string_view bytes, const HeifFile& file) {
  std::string out(bytes);
  for (const size_t at : file.shared_auxiliaries)
    if (at + 4 <= out.size()) out.replace(at, 4, "xxxx");
  return out;
}

}  // namespace vitrine
