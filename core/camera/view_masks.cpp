#include "core/camera/view_masks.h"

#include "core/base/error.h"
#include "core/image/ldr.h"

namespace vitrine {

namespace fs = std::filesystem;

fs::path view_mask_path(const fs::path& artifact, MaskClass kind, const View& view) {
  return artifact / "masks" / name(kind) / (view.stem() + ".png");
}

std::optional<ImageF> read_view_mask(const fs::path& artifact, MaskClass kind, const View& view) {
  const fs::path path = view_mask_path(artifact, kind, view);
  std::error_code ec;
  if (!fs::exists(path, ec)) return std::nullopt;
  ImageF file = read_unchanged(path);
  const Intrinsics& k = view.intrinsics;
  if (file.width() != k.width || file.height() != k.height)
    throw Error(
        ErrorKind::Input, "a mask and its photo have different sizes",
        {.where = path.string(),
         .why = fmt::format("the mask has {} x {} pixels, the photo {} x {}", file.width(), file.height(), k.width, k.height),
         .hint = "run the masks stage again",
         .code = "MASK_SIZE"});
  if (file.channels() == 1) return file;
  // Painted over and saved in colour: grey is the same in every channel.
  ImageF grey(file.width(), file.height(), 1);
  for (size_t i = 0; i < grey.pixel_count(); ++i) grey.data()[i] = file.data()[i * size_t(file.channels())];
  return grey;
}

}  // namespace vitrine
