// Where poses lie, and models that need repair.
#include "core/intake/poses/pose_files.h"

#include <gtest/gtest.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/intake/poses/colmap_repair.h"
#include "tests/core/scene/camera/tiny_model.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

using namespace test;

TEST(PoseFiles, AreFoundInTheLayoutsOfTheField) {
  for (const char* layout : {"sparse/0", "sparse", "colmap/sparse/0", "dense/sparse", "dense/0/sparse", "distorted/sparse/0",
                             "undistorted/sparse", "0", ".", "sparse/3", "sparse_txt", "colmap_out/dense/0/sparse"}) {
    const TemporaryFolder root;
    write_colmap_model(root.path() / layout, tiny_model(), ColmapFormat::Text);
    const std::vector<PoseFile> found = find_pose_files(root.path());
    ASSERT_EQ(found.size(), 1u) << layout;
    EXPECT_EQ(found[0].kind, PoseFile::Kind::Colmap);
    EXPECT_TRUE(fs::equivalent(found[0].path, root.path() / layout)) << found[0].path;
  }
}

TEST(PoseFiles, AreListedTheMostUsualFirst) {
  const TemporaryFolder root;
  for (const char* folder : {"sparse/1", "sparse/0", "distorted/sparse/0", "colmap/sparse/0"})
    write_colmap_model(root.path() / folder, tiny_model(), ColmapFormat::Text);
  for (const char* file : {"transforms_test.json", "transforms_train.json", "transforms.json"})
    write_file(root.path() / file, "{}");
  std::vector<std::string> found;
  for (const PoseFile& f : find_pose_files(root.path())) found.push_back(f.path.lexically_relative(root.path()).string());
  EXPECT_EQ(found, (std::vector<std::string>{"sparse/0", "colmap/sparse/0", "distorted/sparse/0", "sparse/1", "transforms.json",
                                             "transforms_train.json", "transforms_test.json"}));
}

TEST(PoseFiles, OfAnEarlierRunBelowTheFolderAreNotMeant) {
  const TemporaryFolder root;
  write_colmap_model(root.path() / "out/sparse/0", tiny_model(), ColmapFormat::Text);
  make_folders(root.path() / "out/linear");
  write_file(root.path() / "out/scene.json", "{}");
  EXPECT_EQ(error_of([&] { find_pose_files(root.path()); }).detail().code, "POSES_MISSING");
  EXPECT_EQ(find_pose_files(root.path() / "out").size(), 1u) << "given itself, it is";
}

TEST(PoseFiles, ThatLinksReachTwiceCountOnce) {
  const TemporaryFolder root;
  write_colmap_model(root.path() / "sparse/0", tiny_model(), ColmapFormat::Text);
  fs::create_directory_symlink(".", root.path() / "again");
  fs::create_directory_symlink("sparse", root.path() / "zz");
  EXPECT_EQ(find_pose_files(root.path()).size(), 1u);
}

TEST(PoseFiles, OneFileOfAModelStandsForTheModel) {
  const TemporaryFolder root;
  write_colmap_model(root.path(), tiny_model(), ColmapFormat::Text);
  for (const char* file : {"images.txt", "cameras.txt", "points3D.txt"}) {
    EXPECT_EQ(meant_poses(root.path() / file), root.path());
    EXPECT_EQ(find_pose_files(root.path() / file)[0].path, root.path());
  }
  fs::remove(root.path() / "cameras.txt");
  EXPECT_NE(error_of([&] { find_pose_files(root.path() / "images.txt"); }).detail().why.find("cameras.bin or .txt"),
            std::string::npos);
}

TEST(PoseFiles, OfOtherFormatsAreNamed) {
  const TemporaryFolder root;
  for (const auto& [file, what] : {std::pair{"database.db", "COLMAP's database"},
                                   {"bundle.out", "Bundler"},
                                   {"poses_bounds.npy", "LLFF"},
                                   {"scene.sfm", "Meshroom"},
                                   {"notes.rst", "no JSON"}}) {
    write_file(root.path() / file, "anything");
    const Error e = error_of([&] { find_pose_files(root.path() / file); });
    EXPECT_EQ(e.detail().code, "POSES_MISSING");
    EXPECT_NE(e.detail().why.find(what), std::string::npos) << e.what();
  }
}

TEST(PoseFiles, AreRecognisedByTheirContent) {
  const TemporaryFolder root;
  using Kind = PoseFile::Kind;
  for (const auto& [text, kind] : {std::pair{"{\"frames\": []}", Kind::Transforms},
                                   {"[{\"file_path\": \"a.jpg\"}]", Kind::Transforms},
                                   {"{\"frames\": [", Kind::Transforms},
                                   {"\n<?xml version=\"1.0\"?><!-- x --><!DOCTYPE document>\n<document>", Kind::Metashape},
                                   {"[{\"cameras\": {\"frames\": 1}, \"shots\": {}}, {\"x\": 1}]", Kind::OpenSfm},
                                   {"{\"cameras\": {}, \"shots\": {}}", Kind::OpenSfm},
                                   {"{\"sfm_data_version\": \"0.3\"}", Kind::OpenMvg}})
    for (const char* name : {"poses.json", "poses.txt"}) {
      write_file(root.path() / name, text);
      const std::vector<PoseFile> found = find_pose_files(root.path() / name);
      ASSERT_EQ(found.size(), 1u) << text;
      EXPECT_EQ(found[0].kind, kind) << text;
    }
  for (const auto& [text, what] :
       {std::pair{"{\"version\": [], \"views\": [], \"intrinsics\": [], \"poses\": []}", "Meshroom"},
        {"{\"t_00\": 1, \"t_01\": 0, \"t_10\": 0}", "Polycam"},
        {"[{\"id\": 0, \"img_name\": \"a\", \"position\": [], \"rotation\": []}]", "Gaussian splatting"},
        {"{\"images\": [], \"annotations\": []}", "COCO"},
        {"<BlocksExchange/>", "ContextCapture"},
        {"<annotations>", "CVAT"},
        {"{\"lens\": {\"frames\": 1}, \"depth\": 2}", "its keys are lens, depth"}}) {
    write_file(root.path() / "x.json", text);
    const Error e = error_of([&] { find_pose_files(root.path() / "x.json"); });
    EXPECT_EQ(e.detail().code, "POSES_MISSING");
    EXPECT_NE(e.detail().why.find(what), std::string::npos) << e.what();
  }
}

TEST(PoseFiles, OfOtherProgramsAreFoundInFolders) {
  const TemporaryFolder root;
  make_folders(root.path() / "opensfm");
  write_file(root.path() / "cameras.xml", "<document/>");
  write_file(root.path() / "labels.xml", "<annotations/>");
  write_file(root.path() / "sfm_data.json", "{\"sfm_data_version\": \"0.3\"}");
  write_file(root.path() / "opensfm/reconstruction.json", "[{\"cameras\": {}, \"shots\": {}}]");
  std::vector<std::string> found;
  for (const PoseFile& f : find_pose_files(root.path())) found.push_back(f.path.lexically_relative(root.path()).string());
  EXPECT_EQ(found, (std::vector<std::string>{"cameras.xml", "sfm_data.json", "opensfm/reconstruction.json"}));
  const TemporaryFolder other;
  write_file(other.path() / "cameras.sfm", "{}");
  EXPECT_NE(error_of([&] { find_pose_files(other.path()); }).detail().why.find("; cameras.sfm is a Meshroom scene"),
            std::string::npos);
}

TEST(ColmapRepair, DropsWhatLeadsNowhereAndCountsIt) {
  ColmapModel m = tiny_model();
  const size_t images = m.images.size();
  m.images.back().camera_id = 99;
  m.points[0].track.push_back({999, 0});
  m.points[0].track.push_back({m.images[0].id, 1u << 30});
  m.images[0].points.push_back({1, 2, 999999});
  m.images[0].points.push_back({1, 2, m.points[0].id});  // its track does not say so
  const ColmapRepairs repairs = drop_dangling_references(m);
  EXPECT_EQ(repairs.images_without_camera, 1u);
  EXPECT_EQ(repairs.images_gone, 1u);
  EXPECT_EQ(repairs.indices_gone, 1u);
  EXPECT_EQ(repairs.points_gone, 1u);
  EXPECT_EQ(repairs.disagreeing, 1u);
  EXPECT_NE(repairs.text().find("1 image names a camera that is not there"), std::string::npos) << repairs.text();
  EXPECT_EQ(m.images.size(), images - 1);
  check_colmap_model(m, "repaired");
  EXPECT_EQ(drop_dangling_references(m).count(), 0u);
}

TEST(ColmapRepair, LeavesASoundModelAlone) {
  ColmapModel m = tiny_model();
  EXPECT_EQ(drop_dangling_references(m).count(), 0u);
  EXPECT_EQ(m, tiny_model());
  m.points.clear();  // a model of poses alone is not damaged
  EXPECT_EQ(drop_dangling_references(m).count(), 0u);
  EXPECT_EQ(m.images[0].points[0].point3d_id, kNoPoint3D);
}

TEST(ColmapText, OfScriptsAndEditorsIsRead) {
  const TemporaryFolder folder;
  write_file(folder.path() / "cameras.txt", "\xef\xbb\xbf# cameras\n1 PINHOLE 320.0 240.0 +306.25 306.25 160 120\n");
  // No lines of 2D points at all, and no end of the last line.
  write_file(folder.path() / "images.txt",
             "\xef\xbb\xbf"
             "1 1 0 0 0 0 0 0 1 a b.jpg\n2 1 0 0 0 1 0 0 1 c.jpg\n3 1 0 0 0 1 0 0 1 d.jpg");
  ColmapModel m = read_colmap_model(folder.path());
  EXPECT_EQ(m.cameras.at(0).width, 320u);
  EXPECT_EQ(m.cameras.at(0).params[0], 306.25);
  ASSERT_EQ(m.images.size(), 3u);
  EXPECT_EQ(m.images[0].name, "a b.jpg");
  EXPECT_EQ(m.images[2].name, "d.jpg");
  EXPECT_TRUE(m.points.empty());
  // The points in the other format, and files of later versions beside it.
  write_colmap_model(folder.path() / "other", tiny_model(), ColmapFormat::Binary);
  write_colmap_model(folder.path() / "other", tiny_model(), ColmapFormat::Text);
  for (const char* gone : {"images.bin", "cameras.txt", "points3D.bin"}) fs::remove(folder.path() / "other" / gone);
  write_file(folder.path() / "other/rigs.bin", "x");
  EXPECT_EQ(read_colmap_model(folder.path() / "other"), tiny_model());
  // UTF-16 is named.
  write_file(folder.path() / "images.txt", std::string("\xff\xfe#\0", 4));
  const Error e = error_of([&] { read_colmap_model(folder.path()); });
  EXPECT_EQ(e.detail().code, "TEXT_ENCODING");
  EXPECT_NE(e.detail().why.find("UTF-16"), std::string::npos);
}

}  // namespace
}  // namespace vitrine
