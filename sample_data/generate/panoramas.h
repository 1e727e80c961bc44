// Panoramas instead of photos: equirectangular pictures of all directions from the places of a scene's cameras.
#pragma once

#include "sample_data/generate/integrator.h"
#include "sample_data/generate/scene.h"

namespace vitrine::generate {

enum class CameraKind { Pinhole, Equirect, Fisheye };
// "pinhole", "equirect", "fisheye"; throws Error{Usage} for other words.
CameraKind camera_kind(const std::string& word);

// Every view becomes a panorama of `width` x `width` / 2 pixels at its place, level and turned to its side; the views of the
// scene are then the pinhole views that ingest cuts from them (core/scene/camera/panorama_views.h), under the names that it gives
// them. `width` 0: as many pixels as the photo had.
void replace_by_panoramas(Scene& scene, int width);

// Radiance as capture.h has it for pinhole views.
ImageF rendered_panorama(const Integrator& integrator, const IrradianceCache* cache, const Rigid& cam_from_world, int width,
                         int samples, uint64_t key);
// JPEG with the XMP of a panorama (GPano:ProjectionType).
void write_panorama(const std::filesystem::path& path, const Image8& picture, int jpeg_quality);

}  // namespace vitrine::generate
