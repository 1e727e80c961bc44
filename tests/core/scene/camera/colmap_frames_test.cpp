// Rigs and frames of COLMAP 3.12 and later, written here by their layout (COLMAP: doc/format.rst).
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/scene/camera/colmap_model.h"
#include "tests/core/scene/camera/tiny_model.h"

namespace vitrine {
namespace {

struct Pose {
  Quatd rotation = {1, 0, 0, 0};
  Vec3d translation = {};
  Rigid rigid() const { return {rotation_matrix(normalized(rotation)), translation}; }
};

constexpr uint32_t kReference = 2, kSecond = 5, kRig = 7;  // cameras and the rig

Pose second_from_rig() { return {normalized(Quatd{1, 0.1, -0.2, 0.05}), {-0.3, 0.02, 0.01}}; }
Pose rig_from_world(int frame) { return {normalized(Quatd{1, 0.2 * frame, -0.1, 0.3 - 0.1 * frame}), {0.4 * frame, -0.2, 3}}; }

// Two cameras, three frames: images 10, 20, 30 of the reference, 11, 21, 31 of the second camera.
ColmapModel rig_model() {
  ColmapModel m;
  m.cameras = {colmap_pinhole(kReference, {64, 48, 60, 60, 32, 24}), colmap_pinhole(kSecond, {64, 48, 55, 55, 32, 24})};
  for (int frame = 0; frame < 3; ++frame)
    for (const bool second : {false, true}) {
      Rigid pose = rig_from_world(frame).rigid();
      if (second) pose = second_from_rig().rigid() * pose;
      const uint32_t id = 10 * (frame + 1) + second;
      m.images.push_back({id,
                          quaternion(pose.rotation),
                          pose.translation,
                          second ? kSecond : kReference,
                          fmt::format("{}/{}.jpg", second ? "right" : "left", frame),
                          {}});
    }
  return m;
}

enum class Second { Posed, Unknown, Absent };

// Rigs and frames of rig_model() in either format. An IMU belongs to the rig and to each frame.
class RigFiles {
 public:
  explicit RigFiles(ColmapFormat format, Second second = Second::Posed) : binary_(format == ColmapFormat::Binary) {
    begin(1);
    u32(kRig), u32(second == Second::Absent ? 2 : 3);
    sensor(true, kReference);
    if (second != Second::Absent) {
      sensor(true, kSecond), flag(second == Second::Posed);
      if (second == Second::Posed) pose(second_from_rig());
    }
    sensor(false, 1), flag(false);
    rigs = end();
    begin(3);
    for (int frame = 0; frame < 3; ++frame) {
      u32(uint32_t(100 + frame)), u32(kRig), pose(rig_from_world(frame)), u32(3);
      for (const uint32_t second_camera : {0u, 1u}) {
        sensor(true, second_camera ? kSecond : kReference);
        u64(uint64_t(10 * (frame + 1)) + second_camera);
      }
      sensor(false, 1), u64(uint64_t(900 + frame));
      line();
    }
    frames = end();
  }
  void write(const fs::path& folder) const {
    write_file(folder / (binary_ ? "rigs.bin" : "rigs.txt"), rigs);
    write_file(folder / (binary_ ? "frames.bin" : "frames.txt"), frames);
  }
  std::string rigs, frames;

 private:
  template <class T>
  void value(const T& v) {
    if (binary_)
      out_.append(reinterpret_cast<const char*>(&v), sizeof v);
    else
      out_ += fmt::format("{} ", v);
  }
  void begin(uint64_t count) {
    out_.clear();
    if (binary_)
      value(count);
    else
      out_ += "# a comment\n";
  }
  std::string end() {
    line();
    return out_;
  }
  void line() {
    if (!binary_) out_ += "\n";
  }
  void u32(uint32_t v) { value(v); }
  void u64(uint64_t v) { value(v); }
  void flag(bool v) { binary_ ? out_ += char(v) : out_ += v ? "1 " : "0 "; }
  void sensor(bool camera, uint32_t id) {
    if (binary_)
      value<int32_t>(camera ? 0 : 1);
    else
      out_ += camera ? "CAMERA " : "IMU ";
    u32(id);
  }
  void pose(const Pose& p) {
    for (const double v :
         {p.rotation.w, p.rotation.x, p.rotation.y, p.rotation.z, p.translation.x, p.translation.y, p.translation.z})
      value(v);
  }

  bool binary_;
  std::string out_;
};

void expect_poses(const ColmapModel& got, const ColmapModel& wanted) {
  ASSERT_EQ(got.images.size(), wanted.images.size());
  for (size_t i = 0; i < got.images.size(); ++i) {
    const Rigid a = got.images[i].cam_from_world(), b = wanted.images[i].cam_from_world();
    for (size_t r = 0; r < 3; ++r) {
      EXPECT_NEAR(a.translation[r], b.translation[r], 1e-12) << got.images[i].name;
      for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(a.rotation(r, c), b.rotation(r, c), 1e-12) << got.images[i].name;
    }
  }
}

std::string why_not(const fs::path& folder, ColmapFormat format) {
  try {
    read_colmap_model(folder, format);
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    return e.detail().where + ": " + e.detail().why;
  }
  return {};
}

TEST(ColmapFrames, GiveImagesWithoutPosesThose) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::pair<Quatd, Vec3d> absent[] = {
      {{0, 0, 0, 0}, {0, 0, 0}}, {{nan, nan, nan, nan}, {nan, nan, nan}}, {{1, 0, 0, 0}, {0, 0, 0}}};
  for (const ColmapFormat format : {ColmapFormat::Binary, ColmapFormat::Text})
    for (const auto& [rotation, translation] : absent) {
      const TemporaryFolder folder;
      ColmapModel m = rig_model();
      for (ColmapImage& image : m.images) image.rotation = rotation, image.translation = translation;
      write_colmap_model(folder.path(), m, format);
      RigFiles(format).write(folder.path());
      expect_poses(read_colmap_model(folder.path(), format), rig_model());
    }
}

TEST(ColmapFrames, LeaveImagesTheirPoses) {
  for (const ColmapFormat format : {ColmapFormat::Binary, ColmapFormat::Text}) {
    const TemporaryFolder folder;
    ColmapModel m = rig_model();
    write_colmap_model(folder.path(), m, format);
    RigFiles(format).write(folder.path());
    EXPECT_EQ(read_colmap_model(folder.path(), format), m);
    m.images[0].translation.x += 1;  // contradicts the frame: a warning
    m.images[4].rotation = {0, 0, 0, 0};
    write_colmap_model(folder.path(), m, format);
    const ColmapModel read = read_colmap_model(folder.path(), format);
    EXPECT_EQ(read.images[0], m.images[0]);
    m = rig_model();
    m.images[0].translation.x += 1;
    expect_poses(read, m);
  }
}

TEST(ColmapFrames, WithoutARigPoseTheirOnlyCamera) {
  const TemporaryFolder folder;
  ColmapModel m = rig_model();
  std::erase_if(m.images, [](const ColmapImage& image) { return image.camera_id == kSecond; });
  const ColmapModel wanted = m;
  for (ColmapImage& image : m.images) image.rotation = {0, 0, 0, 0};
  write_colmap_model(folder.path(), m, ColmapFormat::Text);
  std::string frames;
  for (int frame = 0; frame < 3; ++frame) {
    const Pose p = rig_from_world(frame);
    frames += fmt::format("{} {} {} {} {} {} {} {} {} 1 CAMERA {} {}\n", frame, frame, p.rotation.w, p.rotation.x, p.rotation.y,
                          p.rotation.z, p.translation.x, p.translation.y, p.translation.z, kReference, 10 * (frame + 1));
  }
  write_file(folder.path() / "frames.txt", frames);
  expect_poses(read_colmap_model(folder.path()), wanted);
}

TEST(ColmapFrames, ThatLackAPoseAreNamed) {
  for (const ColmapFormat format : {ColmapFormat::Binary, ColmapFormat::Text}) {
    const TemporaryFolder folder;
    ColmapModel m = rig_model();
    for (ColmapImage& image : m.images) image.rotation = {0, 0, 0, 0};
    write_colmap_model(folder.path(), m, format);
    EXPECT_NE(why_not(folder.path(), format).find("the pose of image 10 is not a rigid motion"), std::string::npos);
    RigFiles(format, Second::Unknown).write(folder.path());
    EXPECT_NE(why_not(folder.path(), format).find("rig 7 has no pose of camera 5"), std::string::npos);
    RigFiles(format, Second::Absent).write(folder.path());
    EXPECT_NE(why_not(folder.path(), format).find("rig 7 has no camera 5"), std::string::npos);
    RigFiles(format).write(folder.path());
    m.images.back().id = 77;
    write_colmap_model(folder.path(), m, format);
    EXPECT_NE(why_not(folder.path(), format).find("image 77 ('right/2.jpg') has no pose, and no frame has it"),
              std::string::npos);
  }
}

TEST(ColmapFrames, OfDamagedFilesMatterToImagesWithoutPosesAlone) {
  for (const ColmapFormat format : {ColmapFormat::Binary, ColmapFormat::Text})
    for (const bool posed : {true, false}) {
      const TemporaryFolder folder;
      ColmapModel m = rig_model();
      if (!posed)
        for (ColmapImage& image : m.images) image.rotation = {0, 0, 0, 0};
      write_colmap_model(folder.path(), m, format);
      RigFiles files(format);
      files.write(folder.path());
      const bool binary = format == ColmapFormat::Binary;
      for (const bool of_rigs : {true, false}) {
        const std::string whole = of_rigs ? files.rigs : files.frames;
        const fs::path path = folder.path() / (std::string(of_rigs ? "rigs" : "frames") + (binary ? ".bin" : ".txt"));
        for (size_t length = 0; length + 8 < whole.size(); length += 5) {
          test::replace_file(path, whole.substr(0, length));
          const std::string why = why_not(folder.path(), format);
          if (posed) {
            EXPECT_EQ(why, "");
          } else if (binary) {
            EXPECT_NE(why.find(path.filename().string()), std::string::npos) << why << " cut at " << length;
          }
        }
        test::replace_file(path, whole);
      }
    }
}

TEST(ColmapCamera, OfAPanoramaIsReadAndRefusedAtUseWithAWayOut) {
  for (const ColmapFormat format : {ColmapFormat::Binary, ColmapFormat::Text}) {
    const TemporaryFolder folder;
    ColmapModel m = rig_model();
    for (ColmapCamera& camera : m.cameras) camera = {camera.id, 17, 128, 64, {128, 64}};
    write_colmap_model(folder.path(), m, format);
    const ColmapModel read = read_colmap_model(folder.path(), format);
    EXPECT_EQ(read, m);
    try {
      project(read.cameras[0], {0, 0});
      ADD_FAILURE() << "a panorama was projected as a pinhole camera";
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::Input);
      EXPECT_EQ(e.detail().code, "CAMERA_MODEL_PANORAMA");
      EXPECT_NE(e.detail().why.find("EQUIRECTANGULAR (128 x 64)"), std::string::npos);
      EXPECT_NE(e.detail().hint.find("pinhole views"), std::string::npos);
    }
    write_file(folder.path() / "cameras.txt", "2 SPHERE 128 64 1 64 32\n");
    EXPECT_NE(why_not(folder.path(), ColmapFormat::Text).find("360-degree panoramas"), std::string::npos);
  }
}

}  // namespace
}  // namespace vitrine
