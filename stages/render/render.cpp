#include "stages/render/render.h"

#include <algorithm>
#include <numbers>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/process.h"
#include "core/foundation/config/json_file.h"
#include "core/render/picture/panorama_picture.h"
#include "core/render/picture/picture_frames.h"
#include "core/render/picture/trained_scene.h"
#include "core/render/picture/view_picture.h"
#include "core/render/raster/device.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/ldr.h"

namespace vitrine {

namespace {

std::string problem_of(const RenderConfig& c) {
  if ((c.width == 0) != (c.height == 0)) return "width and height must be given together";
  if (c.camera == RenderCamera::Equirect && c.width != 2 * c.height)
    return "an equirectangular picture is twice as wide as high: width must be 2 x height";
  return frames_problem(c.frames);
}

// One upright panorama for each place: views that share a centre, as those cut from one panorama, would show the same. Frames of
// a path are all kept.
std::vector<View> panorama_views(const RenderConfig& config, const std::vector<View>& views) {
  constexpr double kSamePlace = 1e-6;  // of the scene radius
  std::vector<View> out;
  for (const View& v : views) {
    const bool seen = config.views != ViewChoice::Path && std::ranges::any_of(out, [&](const View& other) {
                        return length(other.centre_in_world() - v.centre_in_world()) < kSamePlace;
                      });
    if (seen) continue;
    const int width = std::min(config.width > 0 ? config.width : panorama_width(v.intrinsics), kMaxPictureSide);
    out.push_back(upright_panorama(v));
    out.back().intrinsics = {width,       width / 2,   width / (2 * std::numbers::pi), width / (2 * std::numbers::pi),
                             0.5 * width, 0.25 * width};
  }
  return out;
}

// Writes the picture and its layers below `out`.
void write_picture(const ViewPicture& picture, const std::string& stem, const fs::path& out) {
  const fs::path file = out / (stem + ".png");
  make_folders(file.parent_path());
  Image8 bytes(picture.srgb.width(), picture.srgb.height(), 3);
  std::ranges::transform(picture.srgb.data(), bytes.data().begin(), [](float v) { return uint8_t(v * 255 + 0.5f); });
  write_ldr(file, bytes);
  for (const PictureLayer& layer : picture.layers) {
    const fs::path exr = out / "layers" / layer.name / (stem + ".exr");
    make_folders(exr.parent_path());
    write_exr(exr, layer.map);
  }
}

// The word of nerfstudio.
void name_camera_model(const fs::path& path, const char* model) {
  nlohmann::json cameras = nlohmann::json::parse(read_file(path));
  cameras["camera_model"] = model;
  write_json_file(path, cameras);
}

}  // namespace

void describe(Describer& d, RenderConfig& c) {
  d.choice("views", c.views, kViewChoiceWords, "Cameras: held-out photos, training photos, both, or those of the input `path`.");
  d.choice("camera", c.camera, kRenderCameraWords,
           "Pictures: perspective, or equirect (the whole sphere around each camera, 2:1, upright).");
  d.option("layers", c.layers, "Also write what the pictures are made of, as EXR.");
  d.option("without_medium", c.without_medium, "Leave out the water or haze of the photos.");
  d.option("width", c.width, "Width of the pictures; 0 = as trained, or as in the path.").range(0, kMaxPictureSide);
  d.option("height", c.height, "Height of the pictures; 0 = as trained, or as in the path.").range(0, kMaxPictureSide);
  d.option("samples", c.samples, "Rays that a rough pixel reflects; 0 = the way the scene was trained.").range(0, 4096);
  d.option("frames", c.frames, "Only these of the pictures, numbered from 0: 10-19, or 7; empty = all.");
  d.choice("backend", c.backend, {"reference", "cpu"}, "Renderer: cpu, or reference (slow, double precision).");
}

void run_render(const RenderConfig& config, StageContext& context) {
  const bool equirect = config.camera == RenderCamera::Equirect;
  std::vector<View> views = picture_views({.which = config.views,
                                           .sfm = context.input("sfm"),
                                           .optimize = context.input("optimize"),
                                           .path = context.optional_input("path"),
                                           .width = equirect ? 0 : config.width,
                                           .height = equirect ? 0 : config.height});
  if (equirect) views = panorama_views(config, views);
  const FrameRange frames = frames_of(config.frames, views.size());
  const StoredFrames stored(context.scratch(), config.frames);
  ScenePainter painter(
      read_trained_scene(context.input("optimize"), context.optional_input("refine")),
      {.backend = config.backend, .layers = config.layers, .samples = config.samples, .medium = !config.without_medium});
  const fs::path out = context.output() / "render";
  for (size_t i = frames.first; i <= frames.last; ++i) {
    throw_if_interrupted();
    const std::string stem = views[i].stem();
    if (!stored.take("render", stem, context.output()))
      write_picture(equirect ? panorama_picture(painter, views[i], views[i].intrinsics.width) : painter.picture(views[i]), stem,
                    out);
    const size_t done = i - frames.first + 1;
    context.progress({.fraction = double(done) / double(frames.count()),
                      .text = fmt::format("view {}/{}", done, frames.count()),
                      .values = {}});
  }
  for (View& v : views) v.name = v.stem() + ".png";
  write_transforms_json(out / "transforms.json", views, ".");
  if (equirect) name_camera_model(out / "transforms.json", "EQUIRECTANGULAR");
  context.metric("views", double(frames.count()));
  const Intrinsics& k = views[0].intrinsics;
  context.summary(fmt::format("{} {}{} of {}x{}{}{}", frames.count(), equirect ? "equirectangular " : "",
                              frames.count() == 1 ? "picture" : "pictures", k.width, k.height,
                              config.layers ? ", with layers" : "", part_text(frames, views.size())));
}

Stage render_stage() {
  StageInfo info{
      .name = "render",
      .version = 9,
      .summary = "pictures of a trained scene from any camera",
      .inputs = {{.name = "sfm", .doc = "Cameras and gains of the photos."},
                 {.name = "optimize", .doc = "The trained surfels and the list of held-out views."},
                 {.name = "refine", .optional = true, .doc = "Better surfels behind glass."},
                 {.name = "path",
                  .artifact = false,
                  .optional = true,
                  .doc = "Cameras in the scene's frame, in order: a transforms.json, or a camera path of nerfstudio's viewer."}},
      .device = kRasterDevice};
  return make_stage<RenderConfig>(
      std::move(info), run_render,
      [] {
        return std::map<std::string, std::string>{{"renderer", std::string(make_renderer(Backend::Cpu)->numerics_tag())}};
      },
      problem_of);
}

}  // namespace vitrine
