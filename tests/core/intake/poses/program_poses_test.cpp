// Poses of Metashape, OpenSfM and OpenMVG: written from known cameras, read back, and refused with the place of the mistake.
#include "core/intake/poses/program_poses.h"

#include <gtest/gtest.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/intake/poses/given_poses.h"
#include "tests/core/intake/poses/program_files.h"
#include "tests/core/intake/poses/synthetic_model.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

using namespace test;

ColmapCamera lens(std::vector<double> params, uint32_t id = 1) {
  params.resize(12);
  return {id, colmap_camera_type("FULL_OPENCV")->id, 640, 480, std::move(params)};
}
const std::vector<double> kSquarePixels{600, 600, 325, 236, -0.08, 0.02, 0.0007, -0.0004, 0.003};
const std::vector<double> kOtherPixels{603, 600, 325, 236, -0.08, 0.02, 0.0007, -0.0004, 0.003};

ColmapModel truth_of(const std::vector<double>& params) {
  return synthetic_model(ring(6, 3, 1, {0, 0, 1}, 0.2), cloud(40, 1), lens(params));
}

std::vector<Photo> photos_of_truth(const ColmapModel& model) {
  std::vector<Photo> photos;
  for (const ColmapImage& image : model.images) {
    Photo p;
    p.name = p.source = image.name;
    p.stem = fs::path(image.name).stem().string();
    p.width = p.original_width = 640, p.height = p.original_height = 480;
    photos.push_back(p);
  }
  return photos;
}

class ProgramPosesTest : public testing::Test {
 protected:
  fs::path file(const std::string& text, const char* name = "poses") const {
    write_file(folder.path() / name, text);
    return folder.path() / name;
  }
  // Every point of the truth has the same pixel in the cameras read. `origin`: of the world read, in that of the truth.
  void expect_truth(const ColmapModel& read, const ColmapModel& truth, const Vec3d& origin = {}) const {
    ASSERT_EQ(read.images.size(), truth.images.size());
    for (size_t i = 0; i < truth.images.size(); ++i) {
      const ColmapImage &a = read.images[i], &b = truth.images[i];
      EXPECT_EQ(a.name, b.name);
      const Rigid pose = a.cam_from_world(), exact = b.cam_from_world();
      for (size_t r = 0; r < 3; ++r)
        for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(pose.rotation(r, c), exact.rotation(r, c), 1e-12);
      EXPECT_LT(length(inverse(pose).translation - (inverse(exact).translation - origin)), 1e-8);
      for (const ColmapPoint3D& point : truth.points) {
        const Vec3d p = pose * (point.position - origin), q = exact * point.position;
        const Vec2d found = project(*read.find_camera(a.camera_id), {p.x / p.z, p.y / p.z});
        const Vec2d expected = project(*truth.find_camera(b.camera_id), {q.x / q.z, q.y / q.z});
        EXPECT_NEAR(found.x, expected.x, 1e-5);
        EXPECT_NEAR(found.y, expected.y, 1e-5);
      }
    }
  }
  ColmapModel given(const ColmapModel& truth) const {
    return read_given_poses(folder.path() / "poses", photos_of_truth(truth), 0);
  }
  TemporaryFolder folder;
};

TEST_F(ProgramPosesTest, OfMetashapeAreThoseOfItsCamerasWhateverTheTransform) {
  const ColmapModel truth = truth_of(kOtherPixels);
  const Rigid turn = ring(1, 2, 1, {0.6, 0.48, -0.64}, 0.3)[0];
  for (const bool component : {true, false}) {
    const MetashapeDesc desc{{12.5, turn.rotation, {-2499.5, -4256.5, 4029.25}}, component, "", ""};
    file(metashape_xml(truth, desc));
    expect_truth(given(truth), truth, desc.world_from_component.translation);
  }
}

// The manual's formula, term by term.
TEST_F(ProgramPosesTest, TheLensOfMetashapeIsConverted) {
  const double f = 600, b1 = 3, cx = 5, cy = -4, k1 = -0.08, k2 = 0.02, k3 = 0.003, p1 = -0.0004, p2 = 0.0007;
  file(metashape_xml(truth_of(kOtherPixels)));
  const ProgramPoses read = read_metashape(folder.path() / "poses");
  ASSERT_EQ(read.model.cameras.size(), 1u);
  for (const Vec2d d : {Vec2d{0.3, -0.2}, {-0.45, 0.1}, {0.05, 0.35}}) {
    const double x = d.x, y = d.y, r2 = x * x + y * y, radial = 1 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2;
    const double xd = x * radial + p1 * (r2 + 2 * x * x) + 2 * p2 * x * y;
    const double yd = y * radial + p2 * (r2 + 2 * y * y) + 2 * p1 * x * y;
    const Vec2d pixel = project(read.model.cameras[0], d);
    EXPECT_NEAR(pixel.x, 320 + cx + xd * (f + b1), 1e-9);
    EXPECT_NEAR(pixel.y, 240 + cy + yd * f, 1e-9);
  }
}

// Terms that the cameras of COLMAP lack are left out where no pixel moves by 0.2.
TEST_F(ProgramPosesTest, OfMetashapeTermsWithoutEffectAreLeftOut) {
  const auto lens_with = [&](const std::string& terms) {
    MetashapeDesc desc;
    desc.more_sensor = terms;
    file(metashape_xml(truth_of(kOtherPixels), desc));
    return read_metashape(folder.path() / "poses").model.cameras.at(0);
  };
  const ColmapCamera without = lens_with("");
  for (const char* terms : {"<k4>0</k4><p3>0</p3><p4>0</p4>", "<k4>-0.004</k4>", "<p3>0.5</p3><p4>-0.5</p4>"})
    EXPECT_EQ(lens_with(terms).params, without.params) << terms;
  for (const char* terms : {"<k4>0.05</k4>", "<p3>20</p3>", "<p4>-60</p4>"})
    EXPECT_NE(error_of([&] { lens_with(terms); }).detail().why.find("move pixels by up to"), std::string::npos) << terms;
  // At the corner (0, 480), where the distance from the principal point is largest: f |d| k4 r^8, d undistorted.
  const Vec2d corner = unproject(without, {0, 480}).value();
  const double r2 = corner.x * corner.x + corner.y * corner.y, moved = 600 * 0.05 * std::pow(r2, 4.5);
  EXPECT_NE(error_of([&] { lens_with("<k4>0.05</k4>"); }).detail().why.find(fmt::format("by up to {:.2g},", moved)),
            std::string::npos)
      << moved;
}

TEST_F(ProgramPosesTest, OfMetashapeComponentsThatAreNotAlignedOnlyTheLargestIsRead) {
  const ColmapModel truth = truth_of(kSquarePixels);
  ColmapImage stranger = truth.images[0];
  stranger.id = 50, stranger.name = "stranger.jpg";
  MetashapeDesc desc;
  desc.more_cameras = metashape_camera(stranger, {}, 1);
  file(metashape_xml(truth, desc));
  const ProgramPoses read = read_metashape(folder.path() / "poses");
  expect_truth(read.model, truth);
  ASSERT_EQ(read.notes.size(), 2u);
  EXPECT_EQ(
      read.notes[0].text,
      "the cameras are in 2 components that are not aligned with each other: the 6 cameras of component '0' are read, 1 are "
      "left out");
  EXPECT_EQ(read.notes[1].text, "1 of 8 cameras of the file are not aligned");
}

TEST_F(ProgramPosesTest, MistakesInMetashapeFilesHaveAPlace) {
  const ColmapModel truth = truth_of(kSquarePixels);
  const auto refusal = [&](const std::string& from, const std::string& to) {
    std::string text = metashape_xml(truth);
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    file(text);
    return error_of([&] { read_metashape(folder.path() / "poses"); });
  };
  const Error cut = refusal("</chunk>", "");
  EXPECT_EQ(cut.kind(), ErrorKind::Input);
  EXPECT_NE(cut.detail().why.find("it is no XML"), std::string::npos) << cut.what();
  const std::string place = (folder.path() / "poses").string();
  const Error fisheye = refusal("type=\"frame\" class=\"adjusted\"", "type=\"fisheye\" class=\"adjusted\"");
  EXPECT_EQ(fisheye.detail().where, place + ":8:10");
  EXPECT_NE(fisheye.detail().why.find("the camera type is 'fisheye'"), std::string::npos) << fisheye.what();
  EXPECT_NE(refusal("<b1>", "<b2>0</b2><k4>0.1</k4><b1>").detail().why.find("<k4>, <p3> and <p4> move pixels by up to"),
            std::string::npos);
  EXPECT_NE(refusal("<b1>", "<b2>3</b2><b1>").detail().why.find("sheared"), std::string::npos);
  EXPECT_NE(refusal("sensor_id=\"1\" component_id", "sensor_id=\"7\" component_id").detail().why.find("no sensor '7'"),
            std::string::npos);
  const Error words = refusal("<f>600", "<f>600 mm ");
  EXPECT_EQ(words.detail().where, place + ":10:12");
  EXPECT_NE(words.detail().why.find("<f>: expected a number"), std::string::npos) << words.what();
  EXPECT_NE(refusal("<scale locked=\"true\">1", "<scale locked=\"true\">-1").detail().why.find("not positive"),
            std::string::npos);
  file("<document><chunk><sensors/><cameras/></chunk></document>");
  EXPECT_NE(error_of([&] { read_metashape(folder.path() / "poses"); }).detail().why.find("align the photos"), std::string::npos);
}

TEST_F(ProgramPosesTest, OfOpenSfmAreThoseOfItsShots) {
  for (const auto& [type, params] : {std::pair{"brown", kOtherPixels}, {"perspective", {600, 600, 320, 240, -0.08, 0.02}}}) {
    const ColmapModel truth = truth_of(params);
    file(opensfm_json(truth, type));
    expect_truth(given(truth), truth);
  }
  // Pictures taller than wide, and no lens.
  ColmapModel tall = truth_of({600, 600, 240, 320});
  std::swap(tall.cameras[0].width, tall.cameras[0].height);
  file(opensfm_json(tall));
  const ProgramPoses read = read_opensfm(folder.path() / "poses");
  EXPECT_EQ(colmap_camera_type(read.model.cameras.at(0).model_id)->name, "PINHOLE");
  expect_truth(read.model, tall);
}

TEST_F(ProgramPosesTest, OfSeveralReconstructionsTheLargestIsRead) {
  const ColmapModel truth = truth_of(kSquarePixels);
  ColmapModel small = truth;
  small.images.resize(2);
  std::string one = opensfm_json(small), two = opensfm_json(truth);
  one.resize(one.rfind(']')), two.erase(0, two.find('[') + 1);
  file(one + "," + two);
  const ProgramPoses read = read_opensfm(folder.path() / "poses");
  expect_truth(read.model, truth);
  ASSERT_EQ(read.notes.size(), 1u);
  EXPECT_EQ(read.notes[0].text, "the file holds 2 reconstructions that are not joined, of 2, 6 shots: the largest is read");
}

TEST_F(ProgramPosesTest, OtherLensesOfOpenSfmAreRefused) {
  std::string text = opensfm_json(truth_of(kSquarePixels));
  text.replace(text.find("\"brown\""), 7, "\"fisheye\"");
  file(text);
  const Error e = error_of([&] { read_opensfm(folder.path() / "poses"); });
  EXPECT_EQ(e.detail().where, (folder.path() / "poses").string() + ":4:39");
  EXPECT_NE(e.detail().why.find("the camera is 'fisheye'"), std::string::npos) << e.what();
}

TEST_F(ProgramPosesTest, OfOpenMvgAreThoseOfItsViews) {
  const std::vector<std::pair<const char*, std::vector<double>>> kinds{
      {"pinhole", {600, 600, 325, 236}},
      {"pinhole_radial_k1", {600, 600, 325, 236, -0.08}},
      {"pinhole_radial_k3", {600, 600, 325, 236, -0.08, 0.02, 0, 0, 0.003}},
      {"pinhole_brown_t2", kSquarePixels}};
  for (const auto& [type, params] : kinds)
    for (const bool nested : {false, true}) {
      ColmapModel truth = truth_of(params);
      truth.cameras.push_back(lens({610, 610, 320, 240}, 2));  // of the same type
      truth.images[4].camera_id = 2;
      file(openmvg_json(truth, type, nested));
      expect_truth(given(truth), truth);
    }
}

TEST_F(ProgramPosesTest, ViewsOfOpenMvgWithoutAPoseAreCounted) {
  ColmapModel truth = truth_of(kSquarePixels);
  std::string text = openmvg_json(truth);
  const std::string last = "\"id_pose\": 6";
  text.replace(text.find(last), last.size(), "\"id_pose\": 99");
  file(text);
  const ProgramPoses read = read_openmvg(folder.path() / "poses");
  truth.images.pop_back();
  expect_truth(read.model, truth);
  ASSERT_EQ(read.notes.size(), 1u);
  EXPECT_EQ(read.notes[0].text, "1 of 6 views of the file have no pose");
}

TEST_F(ProgramPosesTest, MistakesInOpenMvgFilesHaveAPlace) {
  const ColmapModel truth = truth_of(kSquarePixels);
  const auto why = [&](const std::string& from, const std::string& to) {
    std::string text = openmvg_json(truth);
    text.replace(text.find(from), from.size(), to);
    file(text);
    const Error e = error_of([&] { read_openmvg(folder.path() / "poses"); });
    EXPECT_NE(e.detail().where.find("poses:"), std::string::npos) << e.what();
    return e.detail().why;
  };
  EXPECT_NE(why("pinhole_brown_t2", "fisheye").find("the camera is 'fisheye'"), std::string::npos);
  EXPECT_NE(why("\"focal_length\": 600", "\"focal_length\": -600").find("not positive"), std::string::npos);
  EXPECT_NE(why("\"id_intrinsic\": 1", "\"id_intrinsic\": 5").find("no intrinsics with this key"), std::string::npos);
  EXPECT_NE(why("2147483649, \"polymorphic_name\": \"pinhole_brown_t2\"", "1").find("no value before it"), std::string::npos);
  EXPECT_NE(why("\"rotation\":", "\"rotation\": [[3, 0, 0], [0, 3, 0], [0, 0, 3]], \"old\":").find("not a rotation"),
            std::string::npos);
}

}  // namespace
}  // namespace vitrine
