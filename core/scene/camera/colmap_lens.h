// Facts about the lens models of COLMAP that code for all of them needs (parameter lists: COLMAP, src/colmap/sensor/models.h).
#pragma once

#include "core/scene/camera/colmap_model.h"

namespace vitrine {

// True if the parameters start with fx, fy, cx, cy; else with f, cx, cy.
bool has_two_focals(int model_id);

// True for fisheye models and FOV: photos may show directions at and beyond 90 degrees from the axis.
bool is_fisheye(int model_id);

// Pixel of a direction of the camera frame, of any length. Fisheye models and FOV: of any angle; other models: z > 0.
Vec2d project_ray(const ColmapCamera& camera, const Vec3d& ray);
// Inverse of project_ray(): a direction, of any length; nullopt where the distortion cannot be inverted, and from 180 degrees on.
std::optional<Vec3d> ray_of_pixel(const ColmapCamera& camera, const Vec2d& pixel);

// The camera in the simplest lens model that maps every direction to the same pixel. Models are reduced when their further
// parameters are zero: FULL_OPENCV to OPENCV, OPENCV, FOV, DIVISION and EUCM to PINHOLE, RADIAL to SIMPLE_RADIAL, SIMPLE_RADIAL
// and SIMPLE_DIVISION to SIMPLE_PINHOLE. Fisheye models stay: without distortion they are no pinhole cameras.
ColmapCamera simplest_camera(ColmapCamera camera);

}  // namespace vitrine
