#include "core/scene/image/picture_file.h"

#include <fmt/format.h>

#include "core/scene/image/codecs.h"
#include "core/scene/image/file_kind.h"
#include "core/scene/image/heif_file.h"
#include "core/scene/image/segments.h"
#include "core/scene/image/tiff_pages.h"

namespace vitrine {

namespace {

bool decodes_whole(std::string_view bytes) {
  Image8 small;
  return codecs().jpeg(bytes, 0, 8, small).empty();
}

}  // namespace

PictureFile examine_picture(std::string_view bytes, std::string_view extension) {
  PictureFile file;
  if (bytes.empty()) {
    file.refusal = "the file is empty";
    return file;
  }
  file.probe = probe_photo(bytes);
  if (file.probe.format == PhotoFormat::Png && bytes.size() > 16 && bytes.substr(12, 4) == "CgBI") {
    file.refusal = "it is a PNG in the form of iPhone apps (CgBI), which only Apple reads: convert it to a usual PNG";
    return file;
  }
  if (file.refusal = implausible_size(file.probe, bytes.size()); !file.refusal.empty()) return file;
  switch (file.probe.format) {
    case PhotoFormat::Unknown:
      file.refusal = foreign_content(bytes, extension);
      return file;
    case PhotoFormat::Jpeg: {
      const JpegStructure structure = jpeg_structure(bytes);
      file.refusal = structure.refusal.empty() ? structure.damage : structure.refusal;
      if (structure.refusal.empty() && structure.end_missing && decodes_whole(bytes)) {
        file.refusal.clear();
        file.notes.emplace_back("a JPEG without its end marker, whose rows are all there: it is read");
      }
      if (const std::string trailer = jpeg_trailer(bytes, structure.end); file.refusal.empty() && !trailer.empty())
        file.aside = fmt::format("a JPEG with {} behind the picture: only the picture is read", trailer);
      break;
    }
    case PhotoFormat::Tiff: {
      const TiffPages pages = tiff_pages(bytes);
      file.refusal = tiff_refusal(pages);
      if (file.refusal.empty()) file.notes = tiff_notes(pages);
      break;
    }
    case PhotoFormat::Png:
      file.refusal = missing_end(bytes);
      break;
    case PhotoFormat::Heif:
      file.refusal = heif_refusal(heif_file(bytes), bytes, file_kind(bytes).name);
      break;
    case PhotoFormat::Raw:  // checked by their readers
    case PhotoFormat::Exr:
      break;
  }
  return file;
}

}  // namespace vitrine
