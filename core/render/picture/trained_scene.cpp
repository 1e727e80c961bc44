#include "core/render/picture/trained_scene.h"

#include <array>
#include <cmath>
#include <functional>
#include <stdexcept>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/render/model/thick_glass.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/shape/shape_file.h"
#include "core/scene/surfels/splat_scene.h"

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<const char*, 2> kBlends{"rtrgs", "layered"};
constexpr std::array<const char*, 2> kLobes{"mirror", "sampled"};
constexpr std::array<const char*, 2> kGlasses{"traced", "thin"};
constexpr const char* kMirrored = "mirrored_surfels";
constexpr const char* kLayered = "layered";         // (OpaqueOptions)
constexpr const char* kShapes = "shapes";           // (shape_file.h)
constexpr const char* kThickGlass = "thick_glass";  // key in the file, and name of the mesh next to it

constexpr const char* kMedium = "medium";  // (MediumPass)
constexpr const char* kSilhouettes = "silhouettes";

fs::path thick_glass_path(const fs::path& options) { return options.parent_path() / fmt::format("{}.ply", kThickGlass); }

// Visits every word and number of the file in order; shared by reading and writing.
template <class Options, class Word, class Number>
void visit(Options& o, const Word& word, const Number& number) {
  word("blend", o.composite.blend, kBlends);
  word("lobe", o.reflection.lobe, kLobes);
  word("glass", o.transmission.glass, kGlasses);
  number("near_z", o.diffuse.near_z);
  number("min_alpha", o.surface.min_alpha);
  number("mirror_below", o.reflection.mirror_below);
  number("reflection_near", o.reflection.near);
  number("reflection_min_transmittance", o.reflection.min_transmittance);
  number("transmission_near", o.transmission.near);
  number("transmission_min_transmittance", o.transmission.min_transmittance);
}

// Shortest decimal that parses to the same float (a double would print 17 digits).
double shortest(float value) { return std::stod(fmt::format("{}", value)); }

Json numbers(const Vec3d& v) { return {shortest(float(v.x)), shortest(float(v.y)), shortest(float(v.z))}; }

// `fail`: an error with this cause.
template <class Fail>
MediumCoefficients<double> medium_of(const nlohmann::json& json, const Fail& fail) {
  MediumCoefficients<double> m;
  for (const auto& [key, row] : {std::pair{"direct", &m.direct}, {"backscatter", &m.backscatter}, {"veil", &m.veil}}) {
    const nlohmann::json& values = json.at(key);
    if (!values.is_array() || values.size() != 3) throw fail(fmt::format("{} of the medium is not three numbers", key));
    for (size_t c = 0; c < 3; ++c) {
      (*row)[c] = values[c].get<double>();
      if (!((*row)[c] >= 0) || !std::isfinite((*row)[c])) throw fail(fmt::format("{} of the medium is negative", key));
    }
  }
  return m;
}

SplatLayer layer_of(const fs::path& path, LayerKind kind) {
  SplatLayer layer = read_layer(path);
  if (layer.kind() != kind)
    throw Error(ErrorKind::Input, "a scene file holds another layer than its name states",
                {.where = path.string(),
                 .why = fmt::format("it holds the layer {}", name(layer.kind())),
                 .hint = "give the artifact as `vitrine run` wrote it",
                 .code = "BAD_SCENE"});
  return layer;
}

}  // namespace

TrainedScene read_trained_scene(const fs::path& optimize, const std::optional<fs::path>& refine) {
  TrainedScene trained;
  std::error_code none;
  const bool refined = refine && fs::exists(*refine / "refine/gaussians/diffuse.ply", none);
  const fs::path surfels = refined ? *refine / "refine/gaussians" : optimize / "gaussians";
  for (LayerKind kind : kAllLayers) {
    const fs::path path = surfels / fmt::format("{}.ply", name(kind));
    std::error_code ec;
    if (kind != LayerKind::Diffuse && !fs::exists(path, ec)) continue;
    trained.surfels.layer(kind) = layer_of(path, kind);
  }
  if (const fs::path twin = optimize / "gaussians/opaque.ply"; fs::exists(twin, none))
    trained.surfels.opaque = layer_of(twin, LayerKind::Diffuse);
  trained.image = read_image_options(refined ? *refine / "refine/model.json" : optimize / "optimize/model.json");
  trained.image.diffuse.sh_degree = trained.surfels.diffuse.sh_degree();
  trained.image.reflection.sh_degree = trained.surfels.reflection.sh_degree();
  trained.image.transmission.sh_degree = trained.surfels.transmittance.sh_degree();
  return trained;
}

void write_image_options(const fs::path& path, const ImageOptions& options) {
  Json json;
  visit(
      options, [&](const char* key, auto value, const auto& words) { json[key] = words[static_cast<size_t>(value)]; },
      [&](const char* key, float value) { json[key] = shortest(value); });
  if (options.panes.mirrored != SIZE_MAX) json[kMirrored] = options.panes.mirrored;
  if (options.opaque.layered != 1) json[kLayered] = shortest(options.opaque.layered);
  if (options.medium)
    json[kMedium] = {{"direct", numbers(options.medium->direct)},
                     {"backscatter", numbers(options.medium->backscatter)},
                     {"veil", numbers(options.medium->veil)}};
  if (options.shape.set) {
    json[kShapes] = write_shapes(*options.shape.set, path.parent_path());
    json[kSilhouettes] = options.shape.silhouettes;
  }
  if (const ThickGlass* thick = options.transmission.thick.get()) {
    json[kThickGlass] = {{"ior", shortest(thick->ior())}, {"tolerance", shortest(thick->tolerance())}};
    write_mesh_ply(thick_glass_path(path), thick->mesh());
  }
  write_file(path, json.dump(2) + "\n");
}

ImageOptions read_image_options(const fs::path& path) {
  ImageOptions options;
  std::error_code ec;
  if (!fs::exists(path, ec)) return options;
  const auto fail = [&](const std::string& why) {
    return Error(ErrorKind::Input, "the description of the scene's image formation is unusable",
                 {.where = path.string(),
                  .why = why,
                  .hint = fmt::format("run the {} stage again", path.parent_path().filename().string()),  // optimize or refine
                  .code = "BAD_IMAGE_OPTIONS"});
  };
  try {
    const auto json = nlohmann::json::parse(read_file(path));
    visit(
        options,
        [&](const char* key, auto& value, const auto& words) {
          const std::string word = json.at(key).get<std::string>();
          const auto it = std::find(words.begin(), words.end(), word);
          if (it == words.end()) throw fail(fmt::format("{} cannot be \"{}\"", key, word));
          value = static_cast<std::remove_reference_t<decltype(value)>>(it - words.begin());
        },
        [&](const char* key, float& value) {
          value = json.at(key).get<float>();
          if (!(value >= 0) || !std::isfinite(value)) throw fail(fmt::format("{} is not a positive number", key));
        });
    options.panes.mirrored = json.value(kMirrored, options.panes.mirrored);
    options.opaque.layered = json.value(kLayered, options.opaque.layered);
    if (!(options.opaque.layered >= 0 && options.opaque.layered <= 1)) throw fail("layered is not between 0 and 1");
    if (json.contains(kMedium)) options.medium = medium_of(json.at(kMedium), fail);
    if (json.contains(kShapes))
      options.shape.set = std::make_shared<const ShapeSet>(read_shapes(json.at(kShapes), path.parent_path()));
    options.shape.silhouettes = json.value(kSilhouettes, options.shape.silhouettes);
    if (!json.contains(kThickGlass)) return options;
    const float ior = json.at(kThickGlass).at("ior").get<float>(), tolerance = json.at(kThickGlass).at("tolerance").get<float>();
    if (!(ior > 1) || !std::isfinite(ior) || !(tolerance >= 0)) throw fail("ior or tolerance of thick glass is unusable");
    TriMesh mesh = read_mesh_ply(thick_glass_path(path));
    if (mesh.faces.empty()) throw fail("the mesh of the thick glass has no face");
    options.transmission.thick = std::make_shared<const ThickGlass>(std::move(mesh), ior, tolerance);
  } catch (const nlohmann::json::exception& e) {
    throw fail(cause_of(e));
  } catch (const std::domain_error& e) {
    throw fail(e.what());
  }
  return options;
}

}  // namespace vitrine
