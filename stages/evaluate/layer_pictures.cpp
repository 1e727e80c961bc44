#include "stages/evaluate/layer_pictures.h"

#include <algorithm>
#include <array>

#include "core/base/file.h"
#include "core/math/color.h"

namespace vitrine {

namespace {

struct CellRow {
  std::string_view layer, title;
  bool radiance;
};
constexpr std::array<CellRow, 9> kCells{{{"diffuse", "DIFFUSE", true},
                                         {"reflection", "REFLECTION", true},
                                         {"transmission", "TRANSMISSION", true},
                                         {"reflected", "REFLECTED", true},
                                         {"transmitted", "TRANSMITTED", true},
                                         {"fresnel", "FRESNEL", false},
                                         {"specular_weight", "K-S", false},
                                         {"transmission_weight", "TAU", false},
                                         {"roughness", "ROUGHNESS", false}}};

Image8 radiance_picture(const ImageF& linear, const Vec3d& gain) {
  ImageF srgb = linear;
  for (size_t i = 0; i < srgb.data().size(); ++i)
    srgb.data()[i] = srgb_from_linear(std::clamp(float(gain[i % 3]) * srgb.data()[i], 0.f, 1.f));
  return image8(srgb);
}

Image8 weight_picture(const ImageF& weight) {
  ImageF grey(weight.width(), weight.height(), 3);
  const size_t channels = size_t(weight.channels());
  for (size_t i = 0; i < grey.pixel_count(); ++i)
    for (size_t c = 0; c < 3; ++c) grey.data()[3 * i + c] = weight.data()[channels * i + std::min(c, channels - 1)];
  return image8(grey);
}

}  // namespace

std::vector<SheetCell> layer_cells(const ViewPicture& picture, const Vec3d& gain) {
  std::vector<SheetCell> cells;
  for (const CellRow& cell : kCells)
    if (const ImageF* map = picture.layer(cell.layer))
      cells.push_back({std::string(cell.title), cell.radiance ? radiance_picture(*map, gain) : weight_picture(*map)});
  return cells;
}

void write_layers(const std::filesystem::path& eval_folder, const View& view, const ViewPicture& picture) {
  for (const PictureLayer& layer : picture.layers) {
    const std::filesystem::path path = eval_folder / "layers" / layer.name / (view.stem() + ".exr");
    make_folders(path.parent_path());
    write_exr(path, layer.map);
  }
}

}  // namespace vitrine
