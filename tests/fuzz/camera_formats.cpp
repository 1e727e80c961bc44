// Cameras from elsewhere: COLMAP models, transforms.json (also as a list of masks), Meshroom scenes, projection matrices. Read as
// the sfm stage reads what a user gives with --poses.
#include "core/scene/camera/colmap_files.h"
#include "core/intake/poses/given_poses.h"
#include "core/intake/masks/mask_files.h"
#include "core/scene/camera/view_set.h"
#include "tests/fuzz/entry.h"

namespace vitrine {

namespace {

const std::vector<Photo>& photos() {
  static const std::vector<Photo> three = [] {
    std::vector<Photo> p(3);
    for (size_t i = 0; i < p.size(); ++i) {
      p[i].name = p[i].source = fmt::format("images/{:02}.png", i);
      p[i].stem = fmt::format("images/{:02}", i);
      p[i].width = 40, p[i].height = 30, p[i].original_width = 80, p[i].original_height = 60;
    }
    return p;
  }();
  return three;
}

ColmapModel small_model() {
  ColmapModel model;
  model.cameras.push_back({1, 4, 80, 60, {70, 71, 40, 30, 0.01, -0.01, 0.001, 0}});  // OPENCV
  model.cameras.push_back(colmap_pinhole(2, {80, 60, 70, 70, 40, 30}));
  for (uint32_t i = 0; i < 3; ++i) {
    ColmapImage image{i + 1, {}, {0.1 * i, 0, 2}, i == 0 ? 1u : 2u, fmt::format("{:02}.png", i), {}};
    image.points = {{10.5, 12.5, 7}, {30, 20, kNoPoint3D}};
    model.images.push_back(image);
  }
  model.points.push_back({7, {0.1, 0.2, 0.3}, {200, 100, 50}, 0.5, {{1, 0}, {2, 0}, {3, 0}}});
  return model;
}

std::string joined(const ColmapModel& model, bool binary) {
  using namespace colmap;
  const std::string mark(kPartMark);
  return binary ? binary_of(model.cameras) + mark + binary_of(model.images) + mark + binary_of(model.points)
                : text_of(model.cameras) + mark + text_of(model.images) + mark + text_of(model.points);
}

void read_model(std::span<const uint8_t> bytes, const char* folder, const char* extension) {
  std::error_code ec;
  fs::create_directories(fuzz_folder() / folder, ec);
  const auto parts = parts_of(bytes, 3);
  const char* names[] = {"cameras", "images", "points3D"};
  for (size_t i = 0; i < 3; ++i) input_file(fmt::format("{}/{}.{}", folder, names[i], extension), parts[i]);
  refuses_or_reads([&] { read_given_poses(fuzz_folder() / folder, photos(), 0); });
}

}  // namespace

void fuzz_colmap_binary(std::span<const uint8_t> bytes) { read_model(bytes, "bin", "bin"); }
void fuzz_colmap_text(std::span<const uint8_t> bytes) { read_model(bytes, "txt", "txt"); }

void fuzz_transforms(std::span<const uint8_t> bytes) {
  const fs::path path = input_file("transforms.json", text_of(bytes));
  refuses_or_reads([&] { read_given_poses(path, photos(), 0); });
  refuses_or_reads([&] { read_transforms_json(path); });
  refuses_or_reads([&] {
    const MaskFolder masks(path);
    for (const Photo& photo : photos()) masks.find(MaskClass::Object, photo.name);
  });
  std::error_code ec;
  fs::create_directories(fuzz_folder() / "meshroom", ec);
  input_file("meshroom/scene.sfm", text_of(bytes));
  refuses_or_reads([&] { MaskFolder{fuzz_folder() / "meshroom"}; });
}

void fuzz_matrices(std::span<const uint8_t> bytes) {
  std::error_code ec;
  fs::create_directories(fuzz_folder() / "matrices/P", ec);
  const auto parts = parts_of(bytes, 3);
  for (size_t i = 0; i < 3; ++i) input_file(fmt::format("matrices/P/{:02}.txt", i), parts[i]);
  refuses_or_reads([&] { read_given_poses(fuzz_folder() / "matrices", photos(), 0); });
}

std::vector<std::string> colmap_binary_corpus() {
  ColmapModel bare = small_model();
  bare.points.clear();
  for (ColmapImage& image : bare.images) image.points.clear();
  return {joined(small_model(), true), joined(bare, true)};
}

std::vector<std::string> colmap_text_corpus() { return {joined(small_model(), false)}; }

std::vector<std::string> transforms_corpus() {
  std::vector<View> views;
  for (const Photo& photo : photos()) views.push_back({photo.name, {80, 60, 70, 70, 40, 30}, {}, {1, 1, 1}});
  write_transforms_json(fuzz_folder() / "made.json", views, "");
  return {read_file(fuzz_folder() / "made.json"),
          R"({"camera_angle_x": 0.8, "w": 80, "h": 60, "k1": 0.01, "applied_scale": 0.5, "frames": [
{"file_path": "./images/00", "mask_path": "masks/00.png", "transform_matrix": [[1,0,0,0.5],[0,1,0,0],[0,0,1,2],[0,0,0,1]]},
{"file_path": "./images/01", "fl_x": 71, "transform_matrix": [[0,-1,0,0.5],[1,0,0,0],[0,0,1,2],[0,0,0,1]]}]})",
          R"({"views": [{"viewId": "1234", "path": "images/00.png"}, {"viewId": 7, "path": "images/01.png"}]})"};
}

std::vector<std::string> matrices_corpus() {
  const std::string mark(kPartMark);
  return {"70 0 40 80\n0 70 30 60\n0 0 1 2\n" + mark + "70 0 40 90\n0 70 30 60\n0 0 1 2\n" + mark +
          "-35.5 0 -20 -80\n0 -35.5 -15 -60\n0 0 -1 -2\n"};
}

}  // namespace vitrine
