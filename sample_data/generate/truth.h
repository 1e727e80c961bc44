// The answers beside the photos (layout: sample_data/README.md). The whole set at photo size with `full`, else reduced:
// depth and normals at a fraction of the size, transmitted and relit pictures for a few views at half size.
#pragma once

#include <filesystem>

#include "sample_data/generate/integrator.h"
#include "sample_data/generate/scene.h"

namespace vitrine::generate {

struct GenerateDesc {
  bool geometry = true;  // poses, meshes, depth, normals, masks, albedo
  bool photos = true;
  bool relit = true;  // the other skies, the pictures under them, and the pictures without glass
  bool full_truth = false;
  int samples = 0;  // 0 = the scene's own number
};

// Writes photos/ and truth/ into `folder`; files that are there already are replaced, no file is removed.
void generate(const Scene& scene, const std::filesystem::path& folder, const GenerateDesc& desc);
// One photo as generate() writes it, before the file format's own loss.
Image8 photograph(const Scene& scene, size_t view, int samples, const Integrator::CacheDesc& cache = {});
// Views at another picture size, same field of view.
void resize_views(Scene& scene, int width, int height);
// Exposure and white balance of its own for each photo: +-1.5 EV, +-800 K around 6500 K, uniform; the mean over the photos is 1
// in log, as View::gain requires. Deterministic in the number of the view.
void bracket_gains(Scene& scene);

}  // namespace vitrine::generate
