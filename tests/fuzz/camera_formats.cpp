// Cameras from elsewhere: COLMAP models, transforms.json (also as a list of masks), Metashape, OpenSfM, OpenMVG, Meshroom
// scenes, projection matrices. Read as
// the sfm stage reads what a user gives with --poses.
#include "core/scene/camera/colmap_files.h"
#include "core/intake/poses/given_poses.h"
#include "core/intake/poses/program_poses.h"
#include "core/intake/masks/mask_files.h"
#include "core/scene/camera/view_set.h"
#include "tests/core/intake/poses/program_files.h"
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

// A rig of both cameras with an IMU, and a frame with the images 1 and 2; another frame with image 3, without a rig in the file.
std::string rig_parts(bool binary) {
  const std::string mark(kPartMark);
  if (!binary)
    return mark + "1 3 CAMERA 1 CAMERA 2 1 1 0 0 0.1 -0.2 0 0 IMU 1 0\n" + mark +
           "1 1 1 0 0 0 0.1 0 2 3 CAMERA 1 1 CAMERA 2 2 IMU 1 5\n2 9 1 0 0 0 0.2 0 2 1 CAMERA 2 3\n";
  std::string out;
  const auto put = [&](auto v) { out.append(reinterpret_cast<const char*>(&v), sizeof v); };
  const auto pose = [&](double x) {
    for (const double v : {1.0, 0.0, 0.0, 0.1, x, 0.0, 2.0}) put(v);
  };
  const auto sensor = [&](int32_t type, uint32_t id) { put(type), put(id); };
  put(uint64_t{1}), put(1u), put(3u), sensor(0, 1);
  sensor(0, 2), put(uint8_t{1}), pose(-0.2);
  sensor(1, 1), put(uint8_t{0});
  out += mark;
  put(uint64_t{2});
  put(1u), put(1u), pose(0.1), put(3u);
  sensor(0, 1), put(uint64_t{1}), sensor(0, 2), put(uint64_t{2}), sensor(1, 1), put(uint64_t{5});
  put(2u), put(9u), pose(0.2), put(1u), sensor(0, 2), put(uint64_t{3});
  return mark + out;
}

// The poses of the images are in the frames.
std::string joined_with_rigs(bool binary) {
  ColmapModel model = small_model();
  for (ColmapImage& image : model.images) image.rotation = {0, 0, 0, 0};
  return joined(model, binary) + rig_parts(binary);
}

void read_model(std::span<const uint8_t> bytes, const char* folder, const char* extension) {
  std::error_code ec;
  fs::create_directories(fuzz_folder() / folder, ec);
  const auto parts = parts_of(bytes, 5);
  const char* names[] = {"cameras", "images", "points3D", "rigs", "frames"};
  for (size_t i = 0; i < 5; ++i) {
    const std::string name = fmt::format("{}/{}.{}", folder, names[i], extension);
    if (i < 3 || !parts[i].empty())
      input_file(name, parts[i]);
    else
      fs::remove(fuzz_folder() / name, ec);
  }
  refuses_or_reads([&] { read_given_poses(fuzz_folder() / folder, photos(), 0); });
}

// By content, as with --poses, and by the reader itself, whatever the content is.
void read_program_poses(std::span<const uint8_t> bytes, const char* name, ProgramPoses (*read)(const fs::path&)) {
  const fs::path path = input_file(name, text_of(bytes));
  refuses_or_reads([&] { read_given_poses(path, photos(), 0); });
  refuses_or_reads([&] { read(path); });
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

void fuzz_metashape(std::span<const uint8_t> bytes) { read_program_poses(bytes, "cameras.xml", read_metashape); }
void fuzz_opensfm(std::span<const uint8_t> bytes) { read_program_poses(bytes, "reconstruction.json", read_opensfm); }
void fuzz_openmvg(std::span<const uint8_t> bytes) { read_program_poses(bytes, "sfm_data.json", read_openmvg); }

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
  return {joined(small_model(), true), joined(bare, true), joined_with_rigs(true)};
}

std::vector<std::string> colmap_text_corpus() { return {joined(small_model(), false), joined_with_rigs(false)}; }

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

std::vector<std::string> metashape_corpus() {
  test::MetashapeDesc chunk;
  chunk.component = false;
  return {test::metashape_xml(small_model()), test::metashape_xml(small_model(), chunk)};
}
std::vector<std::string> opensfm_corpus() {
  return {test::opensfm_json(small_model()), test::opensfm_json(small_model(), "perspective")};
}
std::vector<std::string> openmvg_corpus() {
  return {test::openmvg_json(small_model()), test::openmvg_json(small_model(), "pinhole_radial_k3", false)};
}

std::vector<std::string> matrices_corpus() {
  const std::string mark(kPartMark);
  return {"70 0 40 80\n0 70 30 60\n0 0 1 2\n" + mark + "70 0 40 90\n0 70 30 60\n0 0 1 2\n" + mark +
          "-35.5 0 -20 -80\n0 -35.5 -15 -60\n0 0 -1 -2\n"};
}

}  // namespace vitrine
