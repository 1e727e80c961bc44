// GPS coordinates in the EXIF data of the photos give the scene its place and its unit; without them nothing changes.
#include "core/foundation/math/geodesy.h"
#include "tests/e2e/tiny_room.h"
#include "tests/support/gps_exif.h"

namespace vitrine {
namespace {

class GpsRoom : public TinyRoom {
 protected:
  // The photos become JPEG files that name the places of the true poses, 20 m to their unit.
  void tag_photos(double metres) const {
    const LocalFrame frame({47.3769, 8.5417, 431});
    for (const View& view : read_transforms_json(true_poses())) {
      const Geodetic g = frame.place(metres * view.centre_in_world());
      const fs::path jpeg = folder.path() / "tagged.jpg";
      write_ldr(jpeg, read_srgb8(photos() / view.name), 95);
      test::add_exif(jpeg, test::exif_with_gps(test::place_tags(g.latitude, g.longitude, g.altitude)));
      write_file(photos() / view.name, read_file(jpeg));  // contents decide, not names
    }
  }
  Outcome up_to_sfm(const std::string& poses) const { return room(poses, {"--to", "sfm"}); }
};

TEST_F(GpsRoom, PlaceAndUnitOfTheScene) {
  const std::string poses = write_true_model();
  const Outcome plain = up_to_sfm(poses);
  ASSERT_EQ(plain.exit, 0) << plain.text;
  for (const char* file : {"scene.json", "transforms.json", "sfm/report.json"}) {
    EXPECT_EQ(read_file(out() / file).find("enu_origin"), std::string::npos) << file;
    EXPECT_EQ(read_file(out() / file).find("gps"), std::string::npos) << file;
  }
  const auto before = json("scene.json");

  constexpr double kMetres = 20;
  tag_photos(kMetres);
  const Outcome tagged = up_to_sfm(poses);
  ASSERT_EQ(tagged.exit, 0) << tagged.text;
  EXPECT_TRUE(tagged.has("scale from GPS of 12 of 12 photos, 0.0 m rms")) << tagged.text;
  const auto scene = json("scene.json");
  const auto& place = scene.at("enu_origin");
  EXPECT_NEAR(place.at("metres_per_unit").get<double>() * scene.at("scene_from_colmap").at("scale").get<double>(), kMetres,
              5e-3);  // the up vector by the cameras counts, too
  EXPECT_NEAR(place.at("latitude"), 47.3769, 1e-3);
  EXPECT_NEAR(place.at("longitude"), 8.5417, 1e-3);
  EXPECT_EQ(json("transforms.json").at("enu_origin"), place);
  EXPECT_EQ(scene.at("scene_from_colmap").at("scale"), before.at("scene_from_colmap").at("scale")) << "the ring keeps its radius";
  EXPECT_NE(json("sfm/report.json").at("gps").at("text").get<std::string>().find("scale from GPS"), std::string::npos);

  const Outcome looked = call({"inspect", photos().string()});
  EXPECT_TRUE(looked.has("12 of 12 photos have GPS coordinates")) << looked.text;
}

}  // namespace
}  // namespace vitrine
