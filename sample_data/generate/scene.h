// A scene as data: parts with materials, lamps, an environment, the cameras that photograph it and the other environments
// it is shown under. One file in scenes/ fills one of these; nothing else knows a scene by name.
#pragma once

#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/camera/colmap_model.h"
#include "sample_data/generate/environment.h"
#include "sample_data/generate/material.h"
#include "sample_data/generate/medium.h"
#include "sample_data/generate/shape.h"

namespace vitrine::generate {

struct Part {
  std::string name;
  Shape shape;
  Material material;
  bool object = false;    // truth/mask/object
  bool measured = false;  // goes into truth/mesh.ply
  int lamp = -1;          // index in Scene::lamps of an emitter
};

// A rectangle that shines from the side of cross(edge_u, edge_v). It is a part as well, so that rays see it.
struct Lamp {
  Vec3f corner, edge_u, edge_v, radiance;
};

struct NamedEnvironment {
  std::string name;
  Environment environment;
};

struct SensorDesc {
  float shot_noise = 1.5e-4f;  // variance per unit of linear signal
  float read_noise = 1.2e-3f;  // standard deviation, linear
  int jpeg_quality = 92;
  std::string extension = ".jpg";
};

// How carefully the light on diffuse surfaces is solved (irradiance.h).
struct CacheDesc {
  uint32_t direct_samples = 256, gather_samples = 64;  // a vertex
  int passes = 3;                                      // diffuse bounces
};

// A picture of all directions (core/scene/camera/equirect.h), or a fisheye photo.
struct Panorama {
  std::string name;
  Rigid cam_from_world;
  Vec3d gain{1, 1, 1};
};

struct Scene {
  std::string name;
  std::vector<Part> parts;
  std::vector<Lamp> lamps;               // off when the scene is shown under another environment
  Environment environment;               // truth/env/captured.exr
  std::optional<Medium> medium = {};     // before the cameras of the photos; the other pictures show the scene in air
  std::vector<NamedEnvironment> others;  // truth/relit
  std::vector<View> views;               // names are file names of photos/
  std::vector<Panorama> panoramas;       // not empty: the photos, from which `views` are cut (panoramas.h)
  int panorama_width = 0;
  std::optional<ColmapCamera> fisheye;   // lens of the panoramas: they are fisheye photos (fisheyes.h)
  std::vector<Vec3f> probes;             // points of the scene from which the sampling of the environment is planned
  SensorDesc sensor;
  int samples = 64;                                  // per pixel of a photo; a power of two suits the sampler
  float relit_samples = 2, transmitted_samples = 2;  // per pixel, times `samples`: no sensor noise hides theirs
  CacheDesc cache;
  int relit_every = 12, transmitted_every = 12;  // of the views, in the reduced truth
  int reduced_divisor = 4;                       // depth and normals of the reduced truth: photo size divided by this
  size_t reduced_faces = 60000;                  // of the opaque truth mesh, in the reduced truth
  bool full_truth = false;                       // of the scenes that are small: truth at photo size, albedo
  bool marked = false;                           // marks.yaml beside the photos
};

// The scene's parts plus one emitter part for each lamp.
void add_lamp(Scene& scene, const Lamp& lamp);

struct CameraRing {
  int count = 12;
  double azimuth_rad = 0;  // of the first view
  double elevation_rad = 0.4;
  double distance = 1.5;
  double sway = 0.05;  // hand-held: relative spread of distance and height, aim and roll follow
  double span_rad = 2 * std::numbers::pi;
  uint64_t seed = 0x5ca1e;  // of the sway
};
// Views around `target`, appended to scene.views as img_0000, ...; deterministic in the view's number.
void add_ring(Scene& scene, const CameraRing& ring, const Vec3d& target, const Intrinsics& intrinsics);
Rigid looking_at(const Vec3d& eye, const Vec3d& target, const Vec3d& up);  // cam_from_world

}  // namespace vitrine::generate
