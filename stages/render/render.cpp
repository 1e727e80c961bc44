#include "stages/render/render.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/process.h"
#include "core/camera/view_set.h"
#include "core/camera/view_split.h"
#include "core/image/ldr.h"
#include "core/picture/trained_scene.h"
#include "core/picture/view_picture.h"

namespace vitrine {

namespace {

constexpr int kMaxSide = 16384;

// The cameras of a path; the pictures are numbered, because the names in such a file need not fit this file system.
std::vector<View> path_views(const fs::path& path) {
  std::vector<View> views = read_transforms_json(path);
  for (size_t i = 0; i < views.size(); ++i) views[i].name = fmt::format("frame_{:04}.png", i);
  return views;
}

std::vector<View> chosen_views(const RenderConfig& config, const StageContext& context) {
  if (config.views == "path") {
    const auto path = context.optional_input("path");
    if (!path)
      throw Error(ErrorKind::Usage, "which camera path?",
                  {.hint = "--input path=FILE, a transforms.json", .code = "MISSING_INPUT"});
    return path_views(*path);
  }
  const std::vector<View> all = load_view_set(context.input("sfm")).views;
  const fs::path list = context.input("optimize") / "optimize" / "views.json";
  const ViewSplit split = read_view_split(list, all);
  std::vector<View> views;
  const auto take = [&](const std::vector<size_t>& indices) {
    for (size_t i : indices) views.push_back(all[i]);
  };
  if (config.views != "train") take(split.heldout);
  if (config.views != "heldout") take(split.train);
  if (views.empty())
    throw Error(ErrorKind::Input, fmt::format("the scene has no {} views", config.views == "train" ? "training" : "held-out"),
                {.where = list.string(), .hint = "render --views all", .code = "NO_VIEWS"});
  std::ranges::sort(views, {}, &View::name);
  for (View& v : views) v.intrinsics = v.intrinsics.limited_to(split.max_side);
  return views;
}

std::string problem_of(const RenderConfig& c) {
  return (c.width == 0) == (c.height == 0) ? "" : "width and height must be given together";
}

}  // namespace

Intrinsics covering(const Intrinsics& k, int width, int height) {
  const double s = std::max(double(width) / k.width, double(height) / k.height);
  return {
      width, height, k.fx * s, k.fy * s, 0.5 * width + (k.cx - 0.5 * k.width) * s, 0.5 * height + (k.cy - 0.5 * k.height) * s};
}

void describe(Describer& d, RenderConfig& c) {
  d.option("views", c.views, "Cameras: held-out photos, training photos, both, or those of the input `path`.")
      .choices({"heldout", "train", "all", "path"});
  d.option("layers", c.layers, "Also write what the pictures are made of, as EXR.");
  d.option("width", c.width, "Width of the pictures; 0 = as trained, or as the path says.").range(0, kMaxSide);
  d.option("height", c.height, "Height of the pictures; 0 = as trained, or as the path says.").range(0, kMaxSide);
  d.option("samples", c.samples, "Rays that a rough pixel reflects; 0 = the way the scene was trained.").range(0, 4096);
  d.option("backend", c.backend, "Renderer: cpu, or reference (slow, double precision).").choices({"cpu", "reference"});
}

void run_render(const RenderConfig& config, StageContext& context) {
  std::vector<View> views = chosen_views(config, context);
  for (View& v : views) {
    if (config.width > 0) v.intrinsics = covering(v.intrinsics, config.width, config.height);
    if (std::max(v.intrinsics.width, v.intrinsics.height) > kMaxSide)
      throw Error(ErrorKind::Input,
                  fmt::format("a picture of {}x{} pixels is too large", v.intrinsics.width, v.intrinsics.height),
                  {.where = v.name, .hint = "give a smaller size: width, height", .code = "PICTURE_TOO_LARGE"});
  }
  ScenePainter painter(read_trained_scene(context.input("optimize")),
                       {.backend = config.backend == "reference" ? Backend::Reference : Backend::Cpu,
                        .layers = config.layers,
                        .samples = config.samples});
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
  StageInfo info{.name = "render",
                 .version = 1,
                 .summary = "pictures of a trained scene from any camera",
                 .inputs = {{.name = "sfm", .doc = "Cameras and gains of the photos."},
                            {.name = "optimize", .doc = "The trained surfels and the list of held-out views."},
                            {.name = "path",
                             .artifact = false,
                             .optional = true,
                             .doc = "Cameras in the scene's frame: a transforms.json with w and h."}}};
  return make_stage<RenderConfig>(
      std::move(info), run_render,
      [] {
        return std::map<std::string, std::string>{{"renderer", std::string(make_renderer(Backend::Cpu)->numerics_tag())}};
      },
      problem_of);
}

}  // namespace vitrine
