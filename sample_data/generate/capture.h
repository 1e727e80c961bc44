// Pictures of a scene: radiance through a pixel filter, the first surface at the pixel centres, and the sensor behind it.
#pragma once

#include <functional>

#include "core/scene/image/image.h"
#include "sample_data/generate/integrator.h"

namespace vitrine::generate {

struct CameraRay {
  Vec3f origin, direction;
};
using RayOfPixel = std::function<CameraRay(double x, double y)>;

// Tent filter of radius one pixel; `key` separates the random numbers of views and lightings.
ImageF rendered(const Integrator& integrator, const IrradianceCache* cache, const View& view, int samples, uint64_t key);
ImageF rendered(const Integrator& integrator, const IrradianceCache* cache, int width, int height, int samples, uint64_t key,
                const RayOfPixel& ray_of);

struct SurfacePictures {  // one sample at every pixel centre; 0 where nothing was hit
  ImageF zdepth;          // [h,w,1] first surface, the glass counts
  ImageF normal;          // [h,w,3] world, facing the camera, first surface
  ImageF albedo;          // [h,w,3] first surface that is not glass, the base of a coat; 0 for metal and mirrors
  Image8 object, transparent, specular, coated;
  Image8 content;  // what fills glass takes a twentieth or more of the light, on the bent ray
};
SurfacePictures first_surface(const RayScene& rays, const View& view);

// Gain (View::gain), clipping at 1, shot and read noise, sRGB, 8 bit.
Image8 developed(const ImageF& radiance, const Vec3d& gain, const SensorDesc& sensor, uint64_t key);

}  // namespace vitrine::generate
