#include "stages/view/view.h"

#include <algorithm>

#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/process.h"
#include "core/foundation/math/color.h"
#include "core/render/relight/relit_painter.h"
#include "core/scene/camera/corrected_poses.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"
#include "core/scene/mesh/clean_openmesh.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/mesh/mesh_topology.h"
#include "stages/page_text.h"
#include "stages/view/page_blocks.h"
#include "stages/view/page_surfels.h"

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kPhotoQuality = 75;
constexpr double kTurned_deg = 150;
constexpr size_t kRays = 5'000'000;  // per picture; about ten seconds on one core
constexpr size_t kLeastSamples = 16, kMostSamples = 64;
constexpr int kSampleQuality = 90;
constexpr int kEnvironmentWidth = 128;  // width of the photo environment in the page

struct Scene {
  std::vector<View> views;    // at training size
  std::vector<View> photos;   // the same at the size of images/
  std::vector<bool> heldout;  // [views]
  SceneInfo info;
  TrainedScene trained;
  std::optional<RelitScene> relit;
  std::optional<TriMesh> mesh;
};

Scene read_scene(const StageContext& context) {
  Scene s;
  const fs::path sfm = context.input("sfm"), optimize = context.input("optimize");
  const auto refine = context.optional_input("refine"), mesh = context.optional_input("mesh"),
             decompose = context.optional_input("decompose");
  s.views = s.photos = load_view_set(sfm, optimize).views;
  const ViewSplit split = read_view_split(optimize / "optimize/views.json", s.views);
  s.heldout.assign(s.views.size(), false);
  for (const size_t i : split.heldout) s.heldout[i] = true;
  for (View& v : s.views) v.intrinsics = v.intrinsics.limited_to(split.max_side);
  s.info = read_scene_info(sfm / "scene.json");
  if (mesh && decompose) {
    s.relit = read_relit_scene({.optimize = optimize, .refine = refine, .mesh = *mesh, .decompose = *decompose});
    s.trained = s.relit->trained;
    s.mesh = s.relit->mesh;
  } else {
    s.trained = read_trained_scene(optimize, refine);
    if (mesh) s.mesh = read_mesh_ply(*mesh / "mesh/mesh.ply");
  }
  return s;
}

Json numbers(const Mat3d& m) {
  Json out = Json::array();
  for (size_t row = 0; row < 3; ++row)
    for (size_t column = 0; column < 3; ++column) out.push_back(m(row, column));
  return out;
}
Json numbers(const Vec3d& v) { return {v.x, v.y, v.z}; }

Json camera_json(const View& v, const Intrinsics& photo, bool heldout) {
  const Intrinsics& k = v.intrinsics;
  return {{"name", v.name},
          {"width", k.width},
          {"height", k.height},
          {"fx", k.fx},
          {"fy", k.fy},
          {"cx", k.cx},
          {"cy", k.cy},
          {"rotation", numbers(v.cam_from_world.rotation)},
          {"translation", numbers(v.cam_from_world.translation)},
          {"gain", numbers(v.gain)},
          {"photo", {photo.width, photo.height}},
          {"heldout", heldout}};
}

// Photos as data: URIs, in the order of the cameras.
Json small_photos(const Scene& s, const fs::path& sfm, int side) {
  Json out = Json::array();
  for (size_t i = 0; i < s.views.size() && side > 0; ++i) {
    throw_if_interrupted();
    const ImageF linear = read_exr_rgb(linear_image_path(sfm, s.views[i]));
    const Intrinsics k = Intrinsics{.width = linear.width(), .height = linear.height()}.limited_to(side);
    out.push_back("data:image/jpeg;base64," +
                  base64(jpeg_bytes(srgb8_from_linear(resized(linear, k.width, k.height)), kPhotoQuality)));
  }
  return out;
}

// Mesh for browsers that cannot render surfels.
void add_mesh(const TriMesh& mesh, size_t faces, bool with_objects, PageBlocks& blocks) {
  const TriMesh small = mesh.faces.size() > faces ? decimated(mesh, {.target_faces = faces}) : mesh;
  std::vector<float> positions;
  std::vector<uint8_t> colors;
  const bool painted = small.colors.size() == small.positions.size();
  for (size_t v = 0; v < small.positions.size(); ++v)
    for (size_t c = 0; c < 3; ++c) {
      positions.push_back(small.positions[v][c]);
      colors.push_back(
          painted ? static_cast<uint8_t>(std::lround(255 * srgb_from_linear(std::clamp(small.colors[v][c], 0.f, 1.f)))) : 160);
    }
  std::vector<uint32_t> corners;
  for (const auto& f : small.faces) corners.insert(corners.end(), f.begin(), f.end());
  blocks.floats("mesh_position", positions, 3);
  blocks.bytes("mesh_color", colors, 3);
  blocks.indices("mesh_face", corners, 3);
  if (with_objects && !small.object_ids.empty()) blocks.words("mesh_object", small.object_ids, 1);
}

Json edits(const Scene& s, const StageContext& context, const LabelledObjects& objects, const PageSurfels& surfels, Json& shapes,
           PageBlocks& blocks) {
  const fs::path optimize = context.input("optimize");
  std::error_code ec;
  if (fs::exists(optimize / "edits.yaml", ec))
    return no_edits("This page shows edits that were made. Others start from the scene without them: open its own view.html.");
  const auto mesh = context.optional_input("mesh");
  if (!mesh || !s.mesh || s.mesh->faces.empty())
    return no_edits("There is no mesh yet (stage mesh), which vitrine edit needs: finish vitrine run, then vitrine view.");
  const EditScene scene = read_edit_scene({.optimize = optimize,
                                           .mesh = *mesh,
                                           .refine = context.optional_input("refine"),
                                           .decompose = context.optional_input("decompose")});
  return add_edits(scene, s.photos, {context.optional_input("masks"), objects}, surfels, shapes, blocks);
}

void add_environment(const Environment& light, PageBlocks& blocks) {
  ImageF map = light.map();
  if (map.width() > kEnvironmentWidth) map = resized(map, kEnvironmentWidth, kEnvironmentWidth / 2);
  blocks.floats("captured", map.data(), 3);
}

// The relit picture at the top of the report, a JPEG at the size of the view: the first held-out view under the light of the
// photos, rotated about the vertical, so that shadows and reflections differ.
std::string relit_sample(const RelitScene& scene, const View& view) {
  RelitPainter painter(scene);
  Lighting lighting;
  lighting.environment = scene.captured.rotated(kTurned_deg);
  painter.set_lighting(lighting);
  const size_t pixels = static_cast<size_t>(view.intrinsics.width) * static_cast<size_t>(view.intrinsics.height);
  const auto samples = static_cast<int>(std::clamp(kRays / std::max<size_t>(pixels, 1), kLeastSamples, kMostSamples));
  const RelitPicture picture = painter.picture(view, {.samples = samples});
  return jpeg_bytes(developed(picture.radiance, exposure_of_scene(painter.lit())), kSampleQuality);
}

}  // namespace

void describe(Describer& d, ViewConfig& c) {
  d.option("surfels", c.surfels, "At most so many surfels; those that cover least of the photos are left out.")
      .range(1000, 2000000);
  d.option("photo_side", c.photo_side, "Longest side of the photos in the page, pixels; 0 = no photos.").range(0, 4096);
  d.option("rays", c.rays, "Rays of each surfel that find the light which other surfaces send it.").range(8, 4096);
  d.option("mesh_faces", c.mesh_faces, "Faces of the mesh that browsers without WebGL2 show.").range(100, 200000);
}

void write_view(const std::string& page, const ViewConfig& config, StageContext& context) {
  const Scene s = read_scene(context);
  PageBlocks blocks;
  std::vector<Vec3d> eyes;
  for (const View& v : s.views) eyes.push_back(v.centre_in_world());
  PageSurfels surfels = page_surfels(s.trained, eyes, static_cast<size_t>(config.surfels));
  if (surfels.left_out > 0)
    context.warning("VIEW_SURFELS", fmt::format("the page leaves out {} of {} surfels, those that show least (--set surfels=N)",
                                                surfels.left_out, surfels.left_out + surfels.drawn));
  const Vec3d middle = looked_at(s.views).point;
  std::optional<PageLight> light;
  std::vector<LightProbe> light_probes;
  float lit_near = 0;
  if (s.relit) {
    mark_sky(s.relit->materials, surfels);
    context.progress({.fraction = 0.1, .text = "light on the scene", .values = {}});
    const SceneSurface surface(*s.relit);
    const LightTransfer transfer(surface, {.rays = config.rays});
    light = page_light(*s.relit, transfer, surfels);
    light_probes = probes(*s.relit, transfer, middle);
    lit_near = clear_of_surface(*s.relit, transfer);
    add_environment(s.relit->captured, blocks);
    add_probes(light_probes, blocks);
    add_subsurface(*s.relit, surfels, blocks);
  } else {
    context.warning("VIEW_NO_LIGHT", "there are no materials (stage decompose): the page shows the scene as photographed alone");
  }
  add_surfels(surfels, light, blocks);
  context.progress({.fraction = 0.5, .text = "which photos saw what", .values = {}});
  std::vector<View> trained_on;
  for (size_t i = 0; i < s.views.size(); ++i)
    if (!s.heldout[i]) trained_on.push_back(s.views[i]);
  add_coverage(page_coverage(surfels, trained_on, s.trained.image.diffuse.near_z), blocks);
  Json shapes = add_shapes(s.trained.image.shape.set.get(), blocks);
  const LabelledObjects labelled = LabelledObjects::all(context.optional_input("objects"));
  const Json objects = add_objects(labelled.objects().known(), s.trained.surfels, surfels, blocks);
  const Json editable = edits(s, context, labelled, surfels, shapes, blocks);
  if (s.mesh && !s.mesh->faces.empty()) add_mesh(*s.mesh, static_cast<size_t>(config.mesh_faces), !objects.empty(), blocks);

  Json cameras = Json::array(), centres = Json::array();
  for (size_t i = 0; i < s.views.size(); ++i) cameras.push_back(camera_json(s.views[i], s.photos[i].intrinsics, s.heldout[i]));
  for (const LightProbe& p : light_probes) centres.push_back(numbers(p.centre));
  const ImageOptions& image = s.trained.image;
  Json scene{{"format", 2},
             {"surfels", surfels.layer.size()},
             {"solid", surfels.solid},
             {"drawn", surfels.drawn},
             {"left_out", surfels.left_out},
             {"sh_degree", surfels.layer.sh_degree()},
             {"relit", light.has_value()},
             {"reflects", s.trained.surfels.reflection.size() > 0},
             {"reflection_near", image.reflection.near},
             {"lit_near", lit_near},
             {"blend", image.composite.blend == LayerBlend::Layered ? "layered" : "rtrgs"},
             {"near_z", image.diffuse.near_z},
             {"middle", numbers(middle)},
             {"radius", s.info.radius},
             {"metres_per_unit", s.info.metres_per_unit().value_or(0)},
             {"probe_side", kProbeSide},
             {"probes", centres},
             {"shapes", shapes},
             {"objects", objects},
             {"edits", editable},
             {"cameras", cameras},
             {"blocks", blocks.directory()}};
  const Json photos = small_photos(s, context.input("sfm"), config.photo_side);
  const std::string text =
      page_of(page, {json_part("scene", scene), json_part("photos", photos), bytes_part("blocks", deflated(blocks.buffer()))});
  write_file(context.output() / "view.html", text);
  if (s.relit && !s.views.empty()) {
    context.progress({.fraction = 0.7, .text = "a relit picture", .values = {}});
    const auto heldout = std::ranges::find(s.heldout, true);
    const size_t shown = heldout == s.heldout.end() ? 0 : static_cast<size_t>(heldout - s.heldout.begin());
    write_file(context.output() / "view_relit.jpg", relit_sample(*s.relit, s.views[shown]));
  }
  context.metric("size_bytes", double(text.size()));
  context.summary(
      fmt::format("{} surfels{}, {:.1f} MB", surfels.drawn, light ? "" : ", not to be relit", double(text.size()) / 1e6));
}

void run_view(const ViewConfig& config, StageContext& context) {
  // Fails before any computation if the build has no page.
  write_view(empty_page("view", "to view a scene in"), config, context);
}

Stage view_stage() {
  StageInfo info{.name = "view",
                 .version = 9,
                 .summary = "one page that shows the scene from any side, under any light",
                 .inputs = {{.name = "sfm", .doc = "Cameras, gains and photos."},
                            {.name = "optimize", .doc = "The trained surfels and the list of held-out views."},
                            {.name = "refine", .optional = true, .doc = "Better surfels behind glass."},
                            {.name = "mesh", .optional = true, .doc = "The mesh that throws shadows."},
                            {.name = "decompose", .optional = true, .doc = "Materials and the light of the photos."},
                            {.name = "masks", .optional = true, .doc = "Which pixels show the object, for edits."},
                            {.name = "objects", .optional = true, .doc = "The table of objects, and which pixels show them."}}};
  return make_stage<ViewConfig>(std::move(info), run_view, [] {
    return std::map<std::string, std::string>{{"renderer", std::string(make_renderer(Backend::Cpu)->numerics_tag())},
                                              {"page", empty_page_digest("view")}};
  });
}

}  // namespace vitrine
