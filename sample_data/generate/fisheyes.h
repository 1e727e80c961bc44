// Fisheye photos instead of pinhole ones: equidistant lenses of 180 degrees at the cameras of a scene, black outside the circle
// of the lens.
#pragma once

#include "sample_data/generate/integrator.h"
#include "sample_data/generate/scene.h"

namespace vitrine::generate {

// OPENCV_FISHEYE without distortion, its circle as wide as the shorter side.
ColmapCamera fisheye_camera(int width, int height);
double fisheye_circle_px(const ColmapCamera& camera);  // radius

// Every view becomes a photo of `width` x `height` pixels with its pose; the views of the scene are then the pinhole views that
// sfm cuts from them (core/scene/camera/wide_views.h), under the names that it gives them.
void replace_by_fisheyes(Scene& scene, int width, int height);

// Radiance as capture.h has it for pinhole views.
ImageF rendered_fisheye(const Integrator& integrator, const IrradianceCache* cache, const Rigid& cam_from_world,
                        const ColmapCamera& camera, int samples, uint64_t key);
// Poses of the photos with their lens, in the layout of nerfstudio.
void write_fisheye_poses(const std::filesystem::path& path, const Scene& scene);

}  // namespace vitrine::generate
