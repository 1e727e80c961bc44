#include "stages/render/render.h"

#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/process.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/ldr.h"
#include "core/render/picture/trained_scene.h"
#include "core/render/picture/view_picture.h"

namespace vitrine {

namespace {

std::string problem_of(const RenderConfig& c) {
  return (c.width == 0) == (c.height == 0) ? "" : "width and height must be given together";
}

}  // namespace

void describe(Describer& d, RenderConfig& c) {
  d.choice("views", c.views, kViewChoiceWords, "Cameras: held-out photos, training photos, both, or those of the input `path`.");
  d.option("layers", c.layers, "Also write what the pictures are made of, as EXR.");
  d.option("width", c.width, "Width of the pictures; 0 = as trained, or as the path says.").range(0, kMaxPictureSide);
  d.option("height", c.height, "Height of the pictures; 0 = as trained, or as the path says.").range(0, kMaxPictureSide);
  d.option("samples", c.samples, "Rays that a rough pixel reflects; 0 = the way the scene was trained.").range(0, 4096);
  d.choice("backend", c.backend, {"reference", "cpu"}, "Renderer: cpu, or reference (slow, double precision).");
}

void run_render(const RenderConfig& config, StageContext& context) {
  std::vector<View> views = picture_views({.which = config.views,
                                           .sfm = context.input("sfm"),
                                           .optimize = context.input("optimize"),
                                           .path = context.optional_input("path"),
                                           .width = config.width,
                                           .height = config.height});
  ScenePainter painter(read_trained_scene(context.input("optimize"), context.optional_input("refine")),
                       {.backend = config.backend, .layers = config.layers, .samples = config.samples});
  const fs::path out = context.output() / "render";
  for (size_t i = 0; i < views.size(); ++i) {
    throw_if_interrupted();
    const ViewPicture picture = painter.picture(views[i]);
    const fs::path file = out / (views[i].stem() + ".png");
    make_folders(file.parent_path());
    Image8 bytes(picture.srgb.width(), picture.srgb.height(), 3);
    std::ranges::transform(picture.srgb.data(), bytes.data().begin(), [](float v) { return uint8_t(v * 255 + 0.5f); });
    write_ldr(file, bytes);
    for (const PictureLayer& layer : picture.layers) {
      const fs::path exr = out / "layers" / layer.name / (views[i].stem() + ".exr");
      make_folders(exr.parent_path());
      write_exr(exr, layer.map);
    }
    views[i].name = views[i].stem() + ".png";
    context.progress(
        {.fraction = double(i + 1) / double(views.size()), .text = fmt::format("view {}/{}", i + 1, views.size()), .values = {}});
  }
  write_transforms_json(out / "transforms.json", views, ".");
  context.metric("views", double(views.size()));
  const Intrinsics& k = views[0].intrinsics;
  context.summary(fmt::format("{} {} of {}x{}{}", views.size(), views.size() == 1 ? "picture" : "pictures", k.width, k.height,
                              config.layers ? ", with layers" : ""));
}

Stage render_stage() {
  StageInfo info{
      .name = "render",
      .version = 7,
      .summary = "pictures of a trained scene from any camera",
      .inputs = {{.name = "sfm", .doc = "Cameras and gains of the photos."},
                 {.name = "optimize", .doc = "The trained surfels and the list of held-out views."},
                 {.name = "refine", .optional = true, .doc = "Better surfels behind glass."},
                 {.name = "path",
                  .artifact = false,
                  .optional = true,
                  .doc = "Cameras in the scene's frame, in order: a transforms.json, or a camera path of nerfstudio's viewer."}}};
  return make_stage<RenderConfig>(
      std::move(info), run_render,
      [] {
        return std::map<std::string, std::string>{{"renderer", std::string(make_renderer(Backend::Cpu)->numerics_tag())}};
      },
      problem_of);
}

}  // namespace vitrine
