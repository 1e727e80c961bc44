// Given poses: which file is read, which photo each of its names means, and what is said about the rest.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/intake/masks/mask_files.h"
#include "core/intake/poses/given_poses.h"
#include "core/scene/image/ldr.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

Photo photo(const std::string& source, int width = 40, int height = 30) {
  Photo p;
  p.name = p.source = source;
  p.stem = fs::path(source).replace_extension().string();
  p.width = p.original_width = width, p.height = p.original_height = height;
  return p;
}

std::string pose_of(double x) { return fmt::format("[[1,0,0,{}],[0,1,0,0],[0,0,1,2],[0,0,0,1]]", x); }

class GivenNames : public testing::Test {
 protected:
  // A transforms.json with these names; the n-th camera stands at x = n.
  fs::path transforms(const std::vector<std::string>& names, const std::string& top = R"("fl_x": 30, "w": 40, "h": 30, )",
                      const std::string& file = "transforms.json") const {
    std::string text;
    for (size_t i = 0; i < names.size(); ++i)
      text += fmt::format("{}{{\"file_path\": {}, \"transform_matrix\": {}}}", i == 0 ? "" : ",\n", nlohmann_quoted(names[i]),
                          pose_of(double(i)));
    make_folders((folder.path() / file).parent_path());
    write_file(folder.path() / file, "{" + top + "\"frames\": [" + text + "]}");
    return folder.path() / file;
  }
  static std::string nlohmann_quoted(const std::string& name) {
    std::string out = "\"";
    for (char c : name) out += c == '\\' ? std::string("\\\\") : std::string(1, c);
    return out + "\"";
  }
  // COLMAP text; the n-th camera stands at x = n, of the given names.
  fs::path colmap(const fs::path& where, const std::vector<std::string>& names, int width = 40, int height = 30) const {
    make_folders(folder.path() / where);
    std::string images;
    for (size_t i = 0; i < names.size(); ++i) images += fmt::format("{} 1 0 0 0 {} 0 2 1 {}\n\n", i + 1, -double(i), names[i]);
    write_file(folder.path() / where / "images.txt", images);
    write_file(folder.path() / where / "cameras.txt",
               fmt::format("1 PINHOLE {} {} 30 30 {} {}\n", width, height, width / 2.0, height / 2.0));
    write_file(folder.path() / where / "points3D.txt", "");
    return folder.path() / where;
  }
  static std::string code(const GivenPoses& given, const std::string& wanted) {
    for (const Note& n : given.notes)
      if (n.code == wanted) return n.text;
    return "";
  }
  static std::vector<std::string> names(const GivenPoses& given) {
    std::vector<std::string> out;
    for (const ColmapImage& i : given.model.images) out.push_back(i.name);
    return out;
  }
  TemporaryFolder folder;
};

using Names = std::vector<std::string>;

TEST_F(GivenNames, AWholeDataSetMeansThePhotosThatItsPathsName) {
  std::vector<Photo> photos;
  for (const char* set : {"images", "images_2", "images_4"})
    for (const char* file : {"a.jpg", "b.jpg", "c.jpg"}) {
      const int scale = set[6] == 0 ? 1 : set[7] - '0';
      photos.push_back(photo(fmt::format("{}/{}", set, file), 40 / scale, 32 / scale));
    }
  const GivenPoses given =
      given_poses(transforms({"images/a.jpg", "images/b.jpg", "images/c.jpg"}, R"("fl_x": 30, "w": 40, "h": 32, )"), photos, 0);
  EXPECT_EQ(names(given), (Names{"images/a.jpg", "images/b.jpg", "images/c.jpg"}));
  EXPECT_EQ(given.other_versions, (std::vector<size_t>{3, 4, 5, 6, 7, 8}));
  EXPECT_NE(code(given, "POSES_OTHER_VERSIONS").find("6 photos are left out, for example images_2/a.jpg"), std::string::npos);
  // Names below images/, as COLMAP and 3D Gaussian splatting have them: the folder beside the model decides.
  for (const char* file : {"images/a.jpg", "images/b.jpg", "input/a.jpg", "input/b.jpg"}) {
    make_folders((folder.path() / file).parent_path());
    write_file(folder.path() / file, "x");
  }
  photos.push_back(photo("input/a.jpg")), photos.push_back(photo("input/b.jpg"));
  const GivenPoses bare = given_poses(colmap("sparse/0", {"a.jpg", "b.jpg"}, 40, 32), photos, 0);
  EXPECT_EQ(names(bare), (Names{"images/a.jpg", "images/b.jpg"}));
  EXPECT_EQ(names(given_poses(colmap("distorted/sparse/0", {"a.jpg", "b.jpg"}), photos, 0)),
            (Names{"input/a.jpg", "input/b.jpg"}));
}

TEST_F(GivenNames, WhatMatchesNothingShowsANameOfEachSide) {
  const Error e = error_of([&] { given_poses(transforms({"photos\\x.jpg", "photos\\y.jpg"}), std::vector{photo("a.jpg")}, 0); });
  EXPECT_EQ(e.detail().code, "POSES_DO_NOT_MATCH");
  EXPECT_NE(e.detail().why.find("the poses name 'photos\\x.jpg', the photos are called 'a.jpg'"), std::string::npos) << e.what();
  const Error two = error_of([&] {
    given_poses(transforms({"0.jpg", "1.jpg"}),
                std::vector{photo("front/0.jpg"), photo("front/1.jpg"), photo("back/0.jpg"), photo("back/1.jpg")}, 0);
  });
  EXPECT_NE(two.detail().why.find("'0.jpg' may be front/0.jpg or back/0.jpg"), std::string::npos) << two.what();
}

TEST_F(GivenNames, MasksThatThePosesNameAreReported) {
  const fs::path file = transforms({"a.jpg", "b.jpg", "c.jpg"});
  const std::vector<Photo> photos{photo("a.jpg"), photo("b.jpg"), photo("c.jpg")};
  EXPECT_EQ(code(given_poses(file, photos, 0), "POSES_NAME_MASKS"), "");
  std::string text = read_file(file);
  for (const char* name : {"a", "b"}) {
    const std::string path = fmt::format("\"{}.jpg\",", name);
    text.insert(text.find(path) + path.size(), fmt::format(" \"mask_path\": \"masks/{}.png\",", name));
  }
  const std::string other = "\"c.jpg\",";
  text.insert(text.find(other) + other.size(), " \"mask_path\": null,");
  write_file(file, text);
  EXPECT_EQ(code(given_poses(file, photos, 0), "POSES_NAME_MASKS"),
            "2 poses name a mask (mask_path), and there are no such files");
  make_folders(folder.path() / "masks");
  write_ldr(folder.path() / "masks/b.png", Image8(4, 3, 1));
  EXPECT_EQ(code(given_poses(file, photos, 0), "POSES_NAME_MASKS"),
            fmt::format("2 poses name a mask (mask_path); the masks are not used: --masks {} uses them as masks of the object",
                        file.string()));
}

TEST_F(GivenNames, PosesWithoutAPhotoAreCounted) {
  const GivenPoses given =
      given_poses(transforms({"a.jpg", "b.jpg", "x.jpg", "y.jpg"}), std::vector{photo("a.jpg"), photo("b.jpg")}, 0);
  EXPECT_EQ(code(given, "POSES_WITHOUT_PHOTO"), "2 of 4 poses are left out: there is no such photo, for example 'x.jpg'");
}

TEST_F(GivenNames, AbsoluteAndForeignNamesAreUnderstoodInAColmapModel) {
  const std::vector<Photo> photos{photo("a.jpg"), photo("b.jpg")};
  for (const Names& in :
       {Names{"/home/a/a.jpg", "/home/a/b.jpg"}, Names{"cam1\\a.jpg", "cam1\\b.jpg"}, Names{"../x/a.jpg", "../x/b.jpg"}})
    EXPECT_EQ(names(given_poses(colmap("model", in), photos, 0)), (Names{"a.jpg", "b.jpg"})) << in[0];
}

TEST_F(GivenNames, SizesThatTheFileDoesNotStateAreThoseOfEachPhoto) {
  // Two sizes of photos, reduced by ingest; no picture lies beside the file.
  std::vector<Photo> photos{photo("a.jpg", 80, 60), photo("b.jpg", 40, 30), photo("c.jpg", 80, 60)};
  for (Photo& p : photos) p.width /= 2, p.height /= 2;
  const std::string frames = R"({"camera_angle_x": 1.0, "frames": [{"file_path": "sub/a", "transform_matrix": )" + pose_of(0) +
                             R"(}, {"file_path": "sub/b", "transform_matrix": )" + pose_of(1) +
                             R"(}, {"file_path": "sub/c", "fl_x": 70, "cx": 41, "cy": 29, "transform_matrix": )" + pose_of(2) +
                             "}]}";
  write_file(folder.path() / "t.json", frames);
  const ColmapModel m = given_poses(folder.path() / "t.json", photos, 0).model;
  ASSERT_EQ(m.images.size(), 3u);
  const auto k = [&](size_t i) { return pinhole_part(*m.find_camera(m.images[i].camera_id)); };
  EXPECT_EQ(k(0).width, 40);
  EXPECT_NEAR(k(0).fx, 20 / std::tan(0.5), 1e-9);
  EXPECT_EQ(k(1).width, 20);
  EXPECT_NEAR(k(1).fx, 10 / std::tan(0.5), 1e-9);
  EXPECT_NEAR(k(2).fx, 35, 1e-9);
  EXPECT_NEAR(k(2).cx, 20.5, 1e-9);
}

TEST_F(GivenNames, APrincipalPointOfLargerPicturesTellsTheirSize) {
  const std::vector<Photo> photos{photo("a.jpg"), photo("b.jpg")};
  const GivenPoses given = given_poses(transforms({"a.jpg", "b.jpg"}, R"("fl_x": 60, "cx": 41, "cy": 30, )"), photos, 0);
  EXPECT_NEAR(pinhole_part(given.model.cameras[0]).fx, 30, 1e-9);
  EXPECT_NE(code(given, "POSES_SIZE_ASSUMED"), "");
}

TEST_F(GivenNames, TwoFramesOfOnePhotoCountOnceOrAreRefused) {
  const std::vector<Photo> photos{photo("a.jpg"), photo("b.jpg")};
  const Error e = error_of([&] { given_poses(transforms({"a.jpg", "b.jpg", "a.jpg"}), photos, 0); });
  EXPECT_EQ(e.detail().code, "POSES_TWICE");
  EXPECT_NE(e.detail().why.find("frames[0] 'a.jpg' and frames[2] 'a.jpg' differ"), std::string::npos) << e.what();
  const std::string top = R"("fl_x": 30, "w": 40, "h": 30, )",
                    frame = R"({"file_path": "a.jpg", "transform_matrix": )" + pose_of(1) + "}";
  write_file(folder.path() / "t.json", "{" + top + "\"frames\": [" + frame + "," + frame +
                                           R"(, {"file_path": "b.jpg", "transform_matrix": )" + pose_of(2) + "}]}");
  const GivenPoses given = given_poses(folder.path() / "t.json", photos, 0);
  EXPECT_EQ(names(given), (Names{"a.jpg", "b.jpg"}));
  EXPECT_NE(code(given, "POSES_TWICE").find("frames[0] 'a.jpg' and frames[1] 'a.jpg'"), std::string::npos);
  // Of two cameras with equal file names either may be meant.
  EXPECT_EQ(error_of([&] {
              given_poses(colmap("rig", {"cam1/a.jpg", "cam1/b.jpg", "cam2/a.jpg"}), photos, 0);
            })
                .detail()
                .code,
            "POSES_TWICE");
}

TEST_F(GivenNames, TheModelOfMostPhotosIsReadAndTheOthersAreNamed) {
  const std::vector<Photo> photos{photo("a.jpg"), photo("b.jpg"), photo("c.jpg")};
  colmap("sparse/0", {"a.jpg", "b.jpg"});
  colmap("sparse/1", {"a.jpg", "b.jpg", "c.jpg"});
  const GivenPoses given = given_poses(folder.path(), photos, 0);
  EXPECT_EQ(given.source, folder.path() / "sparse/1");
  EXPECT_NE(code(given, "POSES_SEVERAL").find("sparse/0 (2 poses, of 2 of these photos)"), std::string::npos);
  // A damaged one is named, and does not count.
  write_file(folder.path() / "sparse/0/images.txt", "1 2 x\n");
  EXPECT_NE(code(given_poses(folder.path(), photos, 0), "POSES_OTHERS_UNREADABLE").find("sparse/0"), std::string::npos);
}

TEST_F(GivenNames, OfBlendersFilesTheOneOfThesePhotosIsRead) {
  const std::string top = R"("camera_angle_x": 1.0, )";
  transforms({"./train/r_0", "./train/r_1"}, top, "transforms_train.json");
  transforms({"./test/r_0", "./test/r_1", "./test/r_2"}, top, "transforms_test.json");
  const std::vector<Photo> test{photo("r_0.png"), photo("r_1.png"), photo("r_2.png")};
  const GivenPoses given = given_poses(folder.path(), test, 0);
  EXPECT_EQ(given.source.filename(), "transforms_test.json");
  EXPECT_NE(code(given, "POSES_SEVERAL").find("transforms_train.json"), std::string::npos);
  EXPECT_EQ(given_poses(folder.path(), std::vector{test[0], test[1]}, 0).source.filename(), "transforms_train.json");
}

TEST_F(GivenNames, MasksOfJoinedFilesAreUsedByTheirFolder) {
  make_folders(folder.path() / "masks");
  for (const char* set : {"train", "test"}) {
    const fs::path file = transforms({fmt::format("./{}/r_0", set), fmt::format("./{}/r_1", set)}, R"("camera_angle_x": 1.0, )",
                                     fmt::format("transforms_{}.json", set));
    std::string text = read_file(file);
    text.insert(text.find("\"transform_matrix\""), fmt::format("\"mask_path\": \"masks/{}.png\", ", set));
    write_file(file, text);
    write_ldr(folder.path() / fmt::format("masks/{}.png", set), Image8(4, 3, 1));
  }
  const std::vector photos{photo("train/r_0.png"), photo("train/r_1.png"), photo("test/r_0.png"), photo("test/r_1.png")};
  EXPECT_EQ(code(given_poses(folder.path(), photos, 0), "POSES_NAME_MASKS"),
            fmt::format("2 poses name a mask (mask_path); the masks are not used: --masks {} uses them as masks of the object",
                        folder.path().string()));
}

TEST_F(GivenNames, BlendersFilesForTrainingAndTestAreJoinedForPhotosOfBoth) {
  const std::string top = R"("camera_angle_x": 1.0, )";
  transforms({"./train/r_0", "./train/r_1"}, top, "transforms_train.json");
  transforms({"./test/r_0"}, top, "transforms_test.json");
  const std::vector photos{photo("train/r_0.png"), photo("train/r_1.png"), photo("test/r_0.png")};
  const GivenPoses given = given_poses(folder.path(), photos, 0);
  EXPECT_EQ(names(given), (Names{"test/r_0.png", "train/r_0.png", "train/r_1.png"}));
  const auto is = [&](const char* text) {
    return std::any_of(given.notes.begin(), given.notes.end(), [&](const Note& n) { return n.text.find(text) != std::string::npos; });
  };
  EXPECT_TRUE(is("the 3 poses of transforms_train.json and transforms_test.json are joined"));
  EXPECT_FALSE(is("several sets of poses"));
  // A file given itself stays alone; a transforms.json is the whole set.
  EXPECT_EQ(names(given_poses(folder.path() / "transforms_train.json", photos, 0)), (Names{"train/r_0.png", "train/r_1.png"}));
  transforms({"./train/r_0", "./train/r_1"}, top);
  EXPECT_EQ(names(given_poses(folder.path(), photos, 0)), (Names{"train/r_0.png", "train/r_1.png"}));
}

TEST_F(GivenNames, PosesWithoutIntrinsicsNeedThoseOfThePhotos) {
  write_file(folder.path() / "t.json", R"([{"file_path": "a.jpg", "transform": [[1,0,0,0],[0,1,0,0],[0,0,1,2]]},
                                          {"file_path": "b.jpg", "transform": [[1,0,0,1],[0,1,0,0],[0,0,1,2]]}])");
  std::vector<Photo> photos{photo("a.jpg", 80, 60), photo("b.jpg", 80, 60)};
  const Error e = error_of([&] { given_poses(folder.path() / "t.json", photos, 0); });
  EXPECT_EQ(e.detail().code, "POSES_NO_FOCAL");
  EXPECT_NE(e.detail().hint.find("ns-export cameras"), std::string::npos);
  for (Photo& p : photos) p.width = 40, p.height = 30, p.focal_px = 33;
  const GivenPoses given = given_poses(folder.path() / "t.json", photos, 0);
  EXPECT_NEAR(pinhole_part(given.model.cameras[0]).fx, 33, 1e-9);
  EXPECT_NE(code(given, "POSES_FOCAL_FROM_EXIF"), "");
}

TEST_F(GivenNames, PointsThatNoTwoPhotosSeeAreCounted) {
  const fs::path model = colmap("model", {"a.jpg", "b.jpg"});
  write_file(model / "points3D.txt", "1 0 0 5 1 2 3 0\n2 0 0 6 1 2 3 0\n");
  const GivenPoses given = given_poses(model, std::vector{photo("a.jpg"), photo("b.jpg")}, 0);
  EXPECT_TRUE(given.model.points.empty());
  EXPECT_NE(code(given, "POSES_POINTS_WITHOUT_TRACK").find("2 of the 2 points"), std::string::npos);
}

TEST_F(GivenNames, DanglingReferencesAreDroppedWithOneWarning) {
  const fs::path model = colmap("model", {"a.jpg", "b.jpg", "c.jpg"});
  write_file(model / "images.txt",
             "1 1 0 0 0 0 0 2 1 a.jpg\n5 5 1 6 6 77\n2 1 0 0 0 1 0 2 1 b.jpg\n5 5 1\n3 1 0 0 0 2 0 2 9 c.jpg\n\n");
  write_file(model / "points3D.txt", "1 0 0 5 1 2 3 0 1 0 2 0 8 0\n");
  const GivenPoses given = given_poses(model, std::vector{photo("a.jpg"), photo("b.jpg"), photo("c.jpg")}, 0);
  EXPECT_EQ(names(given), (Names{"a.jpg", "b.jpg"}));
  EXPECT_EQ(given.model.points.size(), 1u);
  const std::string text = code(given, "POSES_DANGLING");
  for (const char* part : {"1 image names a camera", "1 2D point names a 3D point", "1 entry of a track names an image"})
    EXPECT_NE(text.find(part), std::string::npos) << text;
}

TEST_F(GivenNames, TextThatWasEditedBesideBinaryFilesIsMentioned) {
  const fs::path model = colmap("model", {"a.jpg", "b.jpg", "c.jpg"});
  write_colmap_model(model, read_colmap_model(model), ColmapFormat::Binary);
  const std::vector<Photo> photos{photo("a.jpg"), photo("b.jpg"), photo("c.jpg")};
  write_file(model / "points3D.txt", "");
  EXPECT_EQ(code(given_poses(model, photos, 0), "POSES_TEXT_NOT_READ"), "") << "they say the same";
  write_file(model / "images.txt", "1 1 0 0 0 0 0 2 1 a.jpg\n\n");
  EXPECT_NE(code(given_poses(model, photos, 0), "POSES_TEXT_NOT_READ").find("hold 1 images and 0 points"), std::string::npos);
}

TEST_F(GivenNames, TwoMatricesOfOnePhotoAreRefused) {
  for (const char* file : {"P/a.txt", "P/a_P.txt", "P/b.txt"}) {
    make_folders(folder.path() / "P");
    write_file(folder.path() / file, "30 0 20 0 0 30 15 0 0 0 1 2");
  }
  const Error e = error_of([&] { given_poses(folder.path(), std::vector{photo("a.jpg"), photo("b.jpg")}, 1); });
  EXPECT_EQ(e.detail().code, "POSES_TWICE");
}

class ListedMasks : public testing::Test {
 protected:
  ListedMasks() {
    for (const char* name : {"masks/front/0.png", "masks/back/0.png"}) {
      make_folders((folder.path() / name).parent_path());
      write_ldr(folder.path() / name, Image8(4, 3, 1));
    }
  }
  MaskFolder masks(const std::string& front, const std::string& back) const {
    write_file(folder.path() / "transforms.json", R"({"frames": [{"file_path": "images/front/0.jpg", "mask_path": ")" + front +
                                                      R"("}, {"file_path": "images\\back\\0.jpg", "mask_path": ")" + back +
                                                      "\"}]}");
    return MaskFolder(folder.path() / "transforms.json");
  }
  TemporaryFolder folder;
};

TEST_F(ListedMasks, BelongToThePhotosOfTheirPaths) {
  for (const auto& [front, back] : {std::pair{"masks/front/0.png", "masks/back/0.png"},
                                    {"masks\\\\front\\\\0.png", "C:\\\\set\\\\masks\\\\back\\\\0.png"},
                                    {"/home/me/set/masks/front/0.png", "./masks/back/0.png"}}) {
    const MaskFolder files = masks(front, back);
    const auto found = files.match(MaskClass::Object, Names{"back/0.jpg", "front/0.jpg", "left/0.jpg"});
    ASSERT_TRUE(found[0] && found[1]) << front;
    EXPECT_EQ(found[0]->path, folder.path() / "masks/back/0.png");
    EXPECT_EQ(found[1]->path, folder.path() / "masks/front/0.png");
    EXPECT_FALSE(found[2]);
    EXPECT_TRUE(files.notes().empty());
  }
}

TEST_F(ListedMasks, ThatDoNotExistAreCounted) {
  const MaskFolder files = masks("masks/front/0.png", "masks/back/9.png");
  ASSERT_EQ(files.notes().size(), 1u);
  EXPECT_NE(files.notes()[0].text.find("1 of 2 files that mask_path names do not exist, for example 'masks/back/9.png'"),
            std::string::npos);
  EXPECT_FALSE(files.match(MaskClass::Object, Names{"front/0.jpg", "back/0.jpg"})[1]);
  EXPECT_EQ(error_of([&] { masks("a/9.png", "b/9.png"); }).detail().code, "MASKS_MISSING");
}

TEST_F(ListedMasks, AreNotWhatOtherFilesHold) {
  for (const auto& [name, text, what] :
       {std::tuple{"masks.zip", "PK\x03\x04 and more", "archive"},
        {"annotations.xml", "<?xml version=\"1.0\"?>\n<annotations/>", "annotations (CVAT, Pascal VOC)"},
        {"coco.json", "{\"images\": [], \"annotations\": [], \"categories\": []}", "annotations (COCO)"},
        {"a.json", "{\"shapes\": [], \"imagePath\": \"a.jpg\"}", "annotations (labelme)"},
        {"other.json", "{\"views\": []}", "JSON without 'frames'"}}) {
    write_file(folder.path() / name, text);
    const Error e = error_of([&] { MaskFolder{folder.path() / name}; });
    EXPECT_EQ(e.detail().code, "MASKS_MISSING") << name;
    EXPECT_NE(e.detail().why.find(what), std::string::npos) << e.what();
  }
  EXPECT_NE(error_of([&] { MaskFolder{folder.path() / "masks/front/0.png"}; }).detail().why.find("one picture"), std::string::npos);
  write_file(folder.path() / "cut.json", "{\"frames\": [");
  EXPECT_EQ(error_of([&] { MaskFolder{folder.path() / "cut.json"}; }).detail().code, "BAD_JSON");
}

TEST_F(ListedMasks, AreTheFilesThatCountForTheCache) {
  const fs::path json = folder.path() / "transforms.json";
  masks("masks/front/0.png", "./masks/back/0.png");
  EXPECT_EQ(files_of_mask_list(json),
            (std::vector<fs::path>{folder.path() / "masks/back/0.png", folder.path() / "masks/front/0.png"}));
  masks("masks/front/0.png", "masks/front/0.png");
  EXPECT_EQ(files_of_mask_list(json), std::vector<fs::path>{folder.path() / "masks/front/0.png"});
  write_file(json, "{\"frames\": 3}");
  EXPECT_TRUE(files_of_mask_list(json).empty()) << "its reader reports the mistake";
  EXPECT_TRUE(files_of_mask_list(folder.path()).empty());
}

}  // namespace
}  // namespace vitrine
