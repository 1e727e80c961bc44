// Local frame of a capture from the GPS coordinates of its photos: x = east, y = north, z = up, in metres.
//
// A robust similarity takes the camera centres of structure from motion to their GPS positions on WGS84. Hypotheses from two
// photos with the up vector of the scene, and from three photos without it, are scored by the squared distances of all photos,
// truncated at the accuracy of a receiver; each one that leads is refined by Gauss-Newton steps over the photos that agree.
// Heights count less than horizontal positions, since receivers know them less well, and the up vector of the scene is a further
// observation of limited weight.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/foundation/math/geodesy.h"
#include "core/intake/photos/photo_list.h"
#include "core/scene/camera/scene_info.h"
#include "stages/sfm/normalize.h"

namespace vitrine {

struct GpsSighting {
  Vec3d centre;  // of the camera, in the frame of the model
  GpsPosition gps;
};

struct GpsFit {
  std::string refused = {};  // empty: the photos agree, and the frame is used
  size_t photos = 0;         // cameras with GPS coordinates
  size_t agreeing = 0;
  double rms_m = 0;              // horizontal distance of the photos that agree
  double precision = 0;          // standard error of the scale, relative
  bool on_a_line = false;        // GPS does not determine the rotation around it
  bool confirms_metres = false;  // the given poses are in metres, and keep their unit
  Geodetic origin = {};          // of the local frame: the median of the coordinates
  bool altitude_known = false;
  Similarity local_from_model = {};
  double metres_per_unit = 0;  // of the scene, set by the stage

  bool used() const { return refused.empty(); }
};

// What is known of the model without GPS.
struct GpsPriors {
  Orientation orientation;   // by its photos
  bool up_chosen = false;    // the user chose how up is found: GPS does not change it
  bool given_poses = false;  // a unit that agrees with the metre within the error of the fit is the metre
};

// nullopt: no camera has coordinates.
std::optional<GpsFit> fitted_gps(std::span<const GpsSighting> sightings, const GpsPriors& priors);

// Cameras of the model whose photos have coordinates.
std::vector<GpsSighting> gps_sightings(const ColmapModel& model, std::span<const Photo> photos);

// Place of the scene's origin, for scene.json. Requires a fit that is used.
GeoOrigin geo_origin(const GpsFit& fit, const Similarity& scene_from_model);

// Frame of the scene (normalize.h). A fit that is used replaces the up vector, determines east, and gives the place of the
// origin.
SceneInfo framed_scene(const ColmapModel& model, Orientation& orientation, std::optional<GpsFit>& fit);

// "scale from GPS of 17 of 18 photos, 1.8 m rms: one unit is 31.2 m", or the reason why there is none.
std::string gps_text(const GpsFit& fit);

}  // namespace vitrine
