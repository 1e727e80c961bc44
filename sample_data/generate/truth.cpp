#include "sample_data/generate/truth.h"

#include <bit>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/foundation/base/file.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/mesh/clean_openmesh.h"
#include "core/scene/mesh/mesh_io.h"
#include "sample_data/generate/capture.h"
#include "sample_data/generate/content.h"
#include "sample_data/generate/fisheyes.h"
#include "sample_data/generate/marks.h"
#include "sample_data/generate/panoramas.h"

namespace vitrine::generate {
namespace {

// Names of the independent streams of random numbers.
enum Stream : uint64_t { kPhoto = 1, kSensor = 2, kTransmitted = 3, kRelit = 4, kBracket = 5 };

Environment planned(const RayScene& rays, Environment environment) {
  const std::vector<Vec3f>& probes = rays.scene().probes;
  environment.weigh_sampling([&](const Vec3f& d) {
    float seen = 0;
    for (const Vec3f& p : probes) seen += rays.transmittance(p, d, 1e5f) > 0 ? 1.0f : 0.0f;
    return probes.empty() ? 1.0f : seen / static_cast<float>(probes.size());
  });
  return environment;
}

IrradianceCache solved(const RayScene& rays, const Integrator& integrator, const CacheDesc& desc) {
  IrradianceCache cache(rays.scene());
  integrator.solve_irradiance(cache, desc);
  return cache;
}

// Zeroes the lowest 8 of the 23 mantissa bits: 1.5e-5 relative, and the files compress to half.
void shorten_mantissas(ImageF& image) {
  for (float& value : image.data()) value = std::bit_cast<float>((std::bit_cast<uint32_t>(value) + 0x80u) & 0xffffff00u);
}

constexpr const char* kSurfaceFolders[] = {"depth", "normal", "mask/object", "mask/transparent", "mask/specular", "mask/coated"};

View at_size(View view, int divisor) {
  view.intrinsics = view.intrinsics.scaled_to(view.intrinsics.width / divisor, view.intrinsics.height / divisor);
  return view;
}

// The faces whose centre some view sees, itself or through glass: a reconstruction can know no others.
TriMesh seen_faces(const RayScene& rays, const TriMesh& mesh) {
  const std::vector<View>& views = rays.scene().views;
  std::vector<uint8_t> seen(mesh.faces.size());
  parallel_for(mesh.faces.size(), 256, [&](size_t f) {
    const auto& [a, b, c] = mesh.faces[f];
    const Vec3f centre = (1.0f / 3.0f) * (mesh.positions[a] + mesh.positions[b] + mesh.positions[c]);
    for (const View& view : views) {
      const Intrinsics& k = view.intrinsics;
      const Vec3d p = view.cam_from_world * cast<double>(centre);
      const double u = k.fx * p.x / p.z + k.cx, v = k.fy * p.y / p.z + k.cy;
      if (p.z <= 0 || u < 0 || v < 0 || u >= k.width || v >= k.height) continue;
      const Vec3f eye = cast<float>(view.centre_in_world());
      const float distance = length(centre - eye);
      if (rays.transmittance(eye, (1.0f / distance) * (centre - eye), distance - 1e-3f, false) == 0) continue;
      seen[f] = 1;
      break;
    }
  });
  constexpr uint32_t kUnused = 0xffffffffu;
  std::vector<uint32_t> renamed(mesh.positions.size(), kUnused);
  TriMesh kept;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    if (!seen[f]) continue;
    std::array<uint32_t, 3> face{};
    for (size_t c = 0; c < 3; ++c) {
      uint32_t& v = renamed[mesh.faces[f][c]];
      if (v == kUnused) {
        v = static_cast<uint32_t>(kept.positions.size());
        kept.positions.push_back(mesh.positions[mesh.faces[f][c]]);
      }
      face[c] = v;
    }
    kept.faces.push_back(face);
  }
  return kept;
}

void write_meshes(const RayScene& rays, const fs::path& truth, bool full) {
  TriMesh glass, opaque;
  for (const Part& part : rays.scene().parts) {
    if (!part.measured) continue;
    const TriMesh seen = seen_faces(rays, part.shape.mesh);
    append(part.material.glass() ? glass : opaque, seen);
  }
  if (opaque.faces.empty() && glass.faces.empty()) return;
  // Flat parts come in the cells of the irradiance cache: most faces go without any loss.
  if (!full) opaque = decimated(opaque, {.target_faces = rays.scene().reduced_faces, .max_normal_turn_deg = 15});
  opaque.normals.clear();
  write_mesh_ply(truth / "mesh_opaque.ply", opaque);
  append(opaque, glass);
  write_mesh_ply(truth / "mesh.ply", opaque);
}

void write_environment(const fs::path& path, const Environment& environment) {
  make_folders(path.parent_path());
  if (!environment.black())
    write_exr_rgb(path, environment.map(), ExrPrecision::Half,
                  {{"vitrine:mapping", "latlong, first row +z, centre +x, u=0.75 is -y"}});
}

void write_surface(const RayScene& rays, const View& view, const fs::path& truth, bool full, int divisor) {
  for (const char* sub : kSurfaceFolders) make_folders((truth / sub / view.stem()).parent_path());
  if (full) make_folders((truth / "albedo" / view.stem()).parent_path());
  SurfacePictures s = first_surface(rays, view);
  for (const auto& [name, mask] :
       {std::pair{"object", &s.object}, {"transparent", &s.transparent}, {"specular", &s.specular}, {"coated", &s.coated}})
    write_ldr(truth / "mask" / name / (view.stem() + ".png"), *mask);
  if (rays.has_content()) {
    const fs::path path = truth / "mask" / "content" / (view.stem() + ".png");
    make_folders(path.parent_path());
    write_ldr(path, s.content);
  }
  if (full) write_exr_rgb(truth / "albedo" / (view.stem() + ".exr"), s.albedo);
  if (!full) s = first_surface(rays, at_size(view, divisor));
  shorten_mantissas(s.zdepth);
  write_exr(truth / "depth" / (view.stem() + ".exr"), {s.zdepth, {"Z"}, {}}, ExrPrecision::Float);
  write_exr(truth / "normal" / (view.stem() + ".exr"), {s.normal, {"X", "Y", "Z"}, {}}, ExrPrecision::Half);
}

const Medium* medium_of(const Scene& scene) { return scene.medium ? &*scene.medium : nullptr; }

// The photos as they would be in air: same samples, before the sensor.
void write_clear(const RayScene& rays, const Environment& environment, const IrradianceCache& cache, int samples,
                 const fs::path& truth) {
  const Scene& scene = rays.scene();
  const Integrator in_air(rays, {environment, scene.lamps});
  for (size_t i = 0; i < scene.views.size(); ++i) {
    const fs::path path = truth / "clear" / (scene.views[i].stem() + ".exr");
    make_folders(path.parent_path());
    write_exr_rgb(path, rendered(in_air, &cache, scene.views[i], samples, mix64(kPhoto, i)));
  }
  log_info("{}: the views without {}", scene.name, scene.medium->name);
}

bool has_glass(const Scene& scene) {
  for (const Part& part : scene.parts)
    if (part.material.glass()) return true;
  return false;
}

void write_geometry(const RayScene& rays, const fs::path& truth, bool full) {
  const Scene& scene = rays.scene();
  make_folders(truth);
  write_transforms_json(truth / "transforms.json", scene.views, "photos");
  write_meshes(rays, truth, full);
  write_environment(truth / "env" / "captured.exr", scene.environment);
  write_content(truth / "content.json", scene);
  for (const View& view : scene.views) write_surface(rays, view, truth, full, scene.reduced_divisor);
  log_info("{}: poses, meshes, depth, normals and masks", scene.name);
}

}  // namespace

void resize_views(Scene& scene, int width, int height) {
  for (View& view : scene.views) view.intrinsics = view.intrinsics.scaled_to(width, height);
}

void bracket_gains(Scene& scene) {
  constexpr double kExposure_ev = 1.5, kWhite_k = 6500, kTurn_k = 800;
  constexpr Vec3d kWavelength_m{610e-9, 550e-9, 465e-9};  // of the primaries of Rec. 709, about
  constexpr double kSecondRadiation_mk = 1.438777e-2;     // of Planck's law
  const auto black_body = [&](double temperature_k, size_t c) {
    return 1 / std::expm1(kSecondRadiation_mk / (kWavelength_m[c] * temperature_k));
  };
  std::vector<Vec3d> logs;
  Vec3d mean{};
  for (size_t i = 0; i < scene.views.size(); ++i) {
    Rng rng(kBracket, i);
    const double exposure = kExposure_ev * std::numbers::ln2 * (2 * double(rng.uniform()) - 1);
    const double balanced_k = kWhite_k + kTurn_k * (2 * double(rng.uniform()) - 1);
    Vec3d& log = logs.emplace_back();
    for (size_t c = 0; c < 3; ++c) log[c] = std::log(black_body(kWhite_k, c) / black_body(balanced_k, c));
    const double green = log.y;
    for (size_t c = 0; c < 3; ++c) log[c] += exposure - green;
    mean += log / double(scene.views.size());
  }
  for (size_t i = 0; i < logs.size(); ++i)
    for (size_t c = 0; c < 3; ++c) scene.views[i].gain[c] = std::exp(logs[i][c] - mean[c]);
}

Image8 photograph(const Scene& scene, size_t view, int samples, const Integrator::CacheDesc& desc) {
  const RayScene rays(scene);
  const Environment environment = planned(rays, scene.environment);
  const Integrator integrator(rays, {environment, scene.lamps, true, medium_of(scene)});
  const IrradianceCache cache = solved(rays, integrator, desc);
  const ImageF radiance = rendered(integrator, &cache, scene.views[view], samples, mix64(kPhoto, view));
  return developed(radiance, scene.views[view].gain, scene.sensor, mix64(kSensor, view));
}

void generate(const Scene& scene, const fs::path& folder, const GenerateDesc& desc) {
  const RayScene rays(scene);
  const fs::path truth = folder / "truth";
  const int samples = desc.samples > 0 ? desc.samples : scene.samples;
  const bool full = desc.full_truth || scene.full_truth;
  const Environment environment = planned(rays, scene.environment);
  if (desc.geometry) write_geometry(rays, truth, full);
  if (desc.geometry && scene.fisheye) write_fisheye_poses(folder / "poses" / "transforms.json", scene);
  if (desc.geometry && scene.marked) write_marks(scene, folder / "marks.yaml");
  if (desc.photos) {
    make_folders(folder / "photos");
    const Integrator integrator(rays, {environment, scene.lamps, true, medium_of(scene)});
    const IrradianceCache cache = solved(rays, integrator, scene.cache);
    const auto write = [&](const std::string& name, const Vec3d& gain, const ImageF& radiance, size_t i) {
      const Image8 picture = developed(radiance, gain, scene.sensor, mix64(kSensor, i));
      const fs::path path = folder / "photos" / name;
      if (scene.panoramas.empty() || scene.fisheye)
        write_ldr(path, picture, scene.sensor.jpeg_quality);
      else
        write_panorama(path, picture, scene.sensor.jpeg_quality);
      log_info("{}: photos/{}", scene.name, name);
    };
    for (size_t i = 0; i < scene.panoramas.size(); ++i) {
      const Panorama& p = scene.panoramas[i];
      const uint64_t key = mix64(kPhoto, i);
      write(p.name, p.gain,
            scene.fisheye ? rendered_fisheye(integrator, &cache, p.cam_from_world, *scene.fisheye, samples, key)
                          : rendered_panorama(integrator, &cache, p.cam_from_world, scene.panorama_width, samples, key),
            i);
    }
    for (size_t i = 0; scene.panoramas.empty() && i < scene.views.size(); ++i)
      write(scene.views[i].name, scene.views[i].gain, rendered(integrator, &cache, scene.views[i], samples, mix64(kPhoto, i)), i);
    if (scene.medium) {
      write_clear(rays, environment, cache, samples, truth);
      write_medium(truth / "medium.json", *scene.medium);
    }
  }
  if (!desc.relit) return;
  const auto pictures = [&](const Integrator& integrator, const fs::path& to, int every, float factor, Stream stream) {
    const IrradianceCache cache = solved(rays, integrator, scene.cache);
    make_folders(to);
    const int count = std::max(1, static_cast<int>(std::lround(factor * static_cast<float>(samples))));
    for (size_t i = 0; i < scene.views.size(); i += static_cast<size_t>(desc.full_truth ? 1 : every)) {
      const View view = at_size(scene.views[i], full ? 1 : 2);
      make_folders((to / view.stem()).parent_path());
      write_exr_rgb(to / (view.stem() + ".exr"), rendered(integrator, &cache, view, count, mix64(stream, i)));
      log_info("{}: {}/{}", scene.name, to.filename().string(), view.stem());
    }
  };
  for (const NamedEnvironment& other : scene.others) {
    write_environment(truth / "env" / (other.name + ".exr"), other.environment);
    const Environment sky = planned(rays, other.environment);
    pictures(Integrator(rays, {sky, {}}), truth / "relit" / other.name, scene.relit_every, scene.relit_samples, kRelit);
  }
  if (has_glass(scene))
    pictures(Integrator(rays, {environment, scene.lamps, false}), truth / "transmitted", scene.transmitted_every,
             scene.transmitted_samples, kTransmitted);
}

}  // namespace vitrine::generate
