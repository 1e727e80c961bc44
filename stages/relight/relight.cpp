#include "stages/relight/relight.h"

#include <algorithm>

#include <fmt/ranges.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/process.h"
#include "core/foundation/base/rng.h"
#include "core/foundation/config/photo_name_finder.h"
#include "core/render/picture/picture_frames.h"
#include "core/render/relight/relit_painter.h"
#include "core/scene/camera/corrected_poses.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/contact_sheet.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

constexpr size_t kSheetCells = 24;  // the first pictures
constexpr size_t kNamedPhotos = 8;  // in the message for a photo without a camera

// Folder name of a light: its file names without characters that file systems or shells may reject.
std::string label_of(const std::optional<fs::path>& environment, const std::optional<fs::path>& lights) {
  std::string label = environment ? environment->stem().string() : lights ? "" : "captured";
  if (lights && !label.empty()) label += '_';
  if (lights) label += lights->stem().string();
  for (char& c : label)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '_' && c != '.') c = '_';
  return label.find_first_not_of('.') == std::string::npos ? "light" : label;
}

Lighting chosen_lighting(const RelightConfig& config, StageContext& context, const RelitScene& scene) {
  Lighting lighting;
  const auto environment = context.optional_input("env"), lights = context.optional_input("lights");
  if (environment) {
    size_t negative = 0;
    lighting.environment = read_environment(*environment, &negative);
    if (negative > 0)
      context.warning("ENV_NEGATIVE", fmt::format("{} of {} texels of {} are darker than black: taken for black there", negative,
                                                  lighting.environment.map().pixel_count(), environment->filename().string()));
  } else if (!lights) {
    lighting.environment = scene.captured;
  }
  lighting.environment = lighting.environment.rotated(config.rotate);
  if (lights) read_lamps(*lights, lighting);
  return lighting;
}

// A light that cannot give a picture. A mistake in the file of lamps is one of usage, as others in it.
[[noreturn]] void throw_no_light(StageContext& context, std::string why) {
  const auto environment = context.optional_input("env"), lights = context.optional_input("lights");
  std::string where = lights ? lights->string() : environment ? environment->string() : std::string("the light of the photos");
  throw Error(lights ? ErrorKind::Usage : ErrorKind::Input, "this light does not reach the scene: all pictures would be black",
              {.where = std::move(where),
               .why = std::move(why),
               .hint = lights ? "place lamps where the cameras were, facing the origin (stages/relight/README.md), or add --env"
                              : "give another environment (--env) or lamps (--lights)",
               .code = "LIGHT_NONE"});
}

// Refuses light that cannot reach the scene, and warns of lamps that add nothing to it.
void check_lighting(const Lighting& lighting, const RelitScene& scene, StageContext& context) {
  std::vector<Vec3f> points = scene.mesh.positions;
  for (const TriMesh* mesh : {&scene.behind_glass, &scene.surroundings})
    points.insert(points.end(), mesh->positions.begin(), mesh->positions.end());
  std::vector<std::string> idle;
  for (size_t lamp = 0; lamp < lighting.lamps(); ++lamp)
    if (const std::string reason = lighting.idle_reason(lamp, points); !reason.empty())
      idle.push_back(fmt::format("{}: {}", lighting.places[lamp], reason));
  const auto environment = context.optional_input("env");
  const bool black = lighting.environment.black();
  if (black && environment) {
    const std::string text = fmt::format("no texel of {} is brighter than 0", environment->filename().string());
    if (idle.size() == lighting.lamps()) throw_no_light(context, text);
    context.warning("ENV_BLACK", text + ": the lamps alone light the scene");
  }
  if (black && idle.size() == lighting.lamps())
    throw_no_light(context, idle.empty() ? "it has no radiance" : fmt::format("{}", fmt::join(idle, "\n")));
  for (const std::string& lamp : idle) context.warning("LAMP_IDLE", "a lamp lights nothing: " + lamp);
}

// All light may end in shadows: known once it is on the scene.
void check_shadows(const Lighting& lighting, const LitScene& lit, StageContext& context) {
  const auto is_lit = [](const Vec3f& e) { return std::max({e.x, e.y, e.z}) > 0; };
  if (std::ranges::any_of(lit.irradiance(), is_lit)) return;
  const std::string why = "every surface lies in shadow, or shows its back to the light";
  if (lighting.environment.black()) throw_no_light(context, why);
  context.warning("LIGHT_NONE", why + ": the pictures show the environment alone");
}

// The photo of the host that --over names, with its camera, at the size of the pictures.
GuestDesc photo_of_host(const RelightConfig& config, const StageContext& context) {
  const fs::path sfm = context.input("sfm"), list = context.input("optimize") / "optimize" / "views.json";
  const std::vector<View> views = load_view_set(sfm, context.input("optimize")).views;
  std::vector<std::string> names;
  for (const View& v : views) names.push_back(v.name);
  const auto found = PhotoNameFinder(names).match(config.over).photo;
  if (!found)
    throw Error(ErrorKind::Input, fmt::format("'{}' has no camera in this scene", config.over),
                {.where = sfm.string(),
                 .why = fmt::format(
                     "photos with a camera: {}{}",
                     fmt::join(names.begin(), names.begin() + std::min<ptrdiff_t>(ptrdiff_t(names.size()), kNamedPhotos), ", "),
                     names.size() > kNamedPhotos ? fmt::format(" and {} more", names.size() - kNamedPhotos) : ""),
                 .hint = "--over takes a photo of the first part of the composition, by its name in images/",
                 .code = "NO_CAMERA"});
  GuestDesc desc{.view = views[*found], .photo = {}, .samples = config.samples, .seed = static_cast<uint64_t>(config.seed)};
  const ImageF photo = read_exr_rgb(linear_image_path(sfm, desc.view));
  desc.view.intrinsics = desc.view.intrinsics.limited_to(config.width > 0 ? std::max(config.width, config.height)
                                                                          : read_view_split(list, views).max_side);
  desc.photo = resized(photo, desc.view.intrinsics.width, desc.view.intrinsics.height);
  if (config.auto_exposure && (context.optional_input("env") || context.optional_input("lights"))) return desc;
  desc.stops = config.exposure;  // the light of the photos has their units
  return desc;
}

std::vector<View> chosen_views(const RelightConfig& config, const StageContext& context) {
  PictureViewsDesc desc{.which = config.views,
                        .sfm = context.input("sfm"),
                        .optimize = context.input("optimize"),
                        .path = context.optional_input("path"),
                        .width = config.width,
                        .height = config.height};
  if (config.turntable == 0) return picture_views(desc);
  desc.which = ViewChoice::All;
  return turntable_views(picture_views(desc), config.turntable);
}

// A film of frame_0000.png on. Bytes depend on the frames and on ffmpeg alone.
void write_film(const fs::path& ffmpeg, const fs::path& folder, const fs::path& film, double frame_rate) {
  const ProcessResult r = run_process({.arguments = {ffmpeg.string(),
                                                     "-nostdin",
                                                     "-y",
                                                     "-loglevel",
                                                     "error",
                                                     "-framerate",
                                                     fmt::format("{}", frame_rate),
                                                     "-i",
                                                     (folder / "frame_%04d.png").string(),
                                                     "-vf",
                                                     "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                                                     "-pix_fmt",
                                                     "yuv420p",
                                                     "-threads",
                                                     "1",
                                                     "-map_metadata",
                                                     "-1",
                                                     "-fflags",
                                                     "+bitexact",
                                                     "-flags:v",
                                                     "+bitexact",
                                                     film.string()}});
  if (!r.ok())
    throw Error(
        ErrorKind::Dependency, "ffmpeg could not make the film",
        {.where = film.string(), .why = r.tail, .hint = "the frames are fine: make the film by hand", .code = "FFMPEG_FAILED"});
}

// `stem`: path without extension. Linear radiance, and the developed picture.
void write_picture(const RelitPicture& picture, double exposure, const fs::path& stem) {
  make_folders(stem.parent_path());
  write_exr_rgb(fs::path(stem.string() + ".exr"), picture.radiance);
  write_ldr(fs::path(stem.string() + ".png"), developed(picture.radiance, exposure));
}

// Of all pictures. Returns the name of the film; empty if there is none.
std::string write_sheet_and_film(const RelightConfig& config, const std::vector<View>& views, const fs::path& out,
                                 StageContext& context) {
  ContactSheet sheet(4);
  for (size_t i = 0; i < std::min(views.size(), kSheetCells); ++i)
    sheet.add(views[i].stem(), read_srgb8(out / (views[i].stem() + ".png")));
  sheet.write(out / "contact_sheet.png");
  if (config.turntable == 0 && config.views != ViewChoice::Path) return "";
  const auto ffmpeg = find_program("ffmpeg");
  if (!ffmpeg) {
    context.warning("NO_FFMPEG", "ffmpeg is not installed: the frames are there, but no film");
    return "";
  }
  const std::string film = config.turntable > 0 ? "turntable.mp4" : "path.mp4";
  write_film(*ffmpeg, out, out / film, config.frame_rate);
  return film;
}

std::string problem_of(const RelightConfig& c) {
  if (!c.over.empty() && (c.turntable > 0 || c.views == ViewChoice::Path)) return "a picture over a photo has the photo's camera";
  if (!c.over.empty() && !c.frames.empty()) return "a picture over a photo is one picture: it has no frames";
  if (const std::string problem = frames_problem(c.frames); !problem.empty()) return problem;
  return (c.width == 0) == (c.height == 0) ? "" : "width and height must be given together";
}

void write_settings(const fs::path& path, const RelightConfig& c, double exposure, const Lighting& lighting, bool solid_glass) {
  nlohmann::ordered_json json;
  json["rotate_deg"] = c.rotate;
  json["exposure_stops_of_png"] = exposure;
  json["samples"] = c.samples;
  json["seed"] = c.seed;
  json["environment_orientation"] = "first row +z, centre +x, three quarters -y, before the rotation about +z";
  const Vec3f mean = lighting.environment.mean();
  json["environment_mean"] = {mean.x, mean.y, mean.z};
  json["lamps"] = lighting.lamps();
  json["approximations"] = {"what only glass shows keeps its trained colours, scaled by the ratio of the light there",
                            "light bounces between matt copies of the surfaces; no caustics"};
  if (solid_glass)
    json["approximations"].push_back(
        "solid glass bends what the camera sees through it; shadows and reflections see it as panes");
  write_file(path, json.dump(2) + "\n");
}

void relight_over_photo(const Lighting& lighting, const std::string& label, GuestDesc desc, StageContext& context,
                        const RelightConfig& config) {
  const EditScene scene = read_edit_scene({.optimize = context.input("optimize"),
                                           .mesh = context.input("mesh"),
                                           .refine = context.optional_input("refine"),
                                           .decompose = context.input("decompose")});
  const GuestPicture picture = guest_over_photo(scene, guest_ids(context.input("compose")), lighting, desc);
  const fs::path out = context.output() / "relit" / (label + "_over"), stem = out / desc.view.stem();
  make_folders(stem.parent_path());
  write_exr(fs::path(stem.string() + ".exr"), {picture.over, {"R", "G", "B", "A"}, {}});
  write_exr_rgb(fs::path(stem.string() + "_shadow.exr"), picture.shadow);
  write_ldr(fs::path(stem.string() + ".png"), developed(picture.composite, 0));
  desc.view.name = desc.view.stem() + ".png";
  write_transforms_json(out / "transforms.json", {desc.view}, ".");
  write_settings(out / "settings.json", config, desc.stops.value_or(0), lighting, false);
  context.metric("views", 1);
  context.summary(fmt::format("the guest over {} at {} spp", config.over, config.samples));
}

}  // namespace

void describe(Describer& d, RelightConfig& c) {
  d.choice("views", c.views, kViewChoiceWords, "Cameras: held-out photos, training photos, both, or those of the input `path`.");
  d.option("turntable", c.turntable, "Frames of a camera that goes around the scene; 0 = the views.").range(0, 100000);
  d.option(
      "over", c.over,
      "Name of a photo of a composition's first part: the other parts and their shadow over it, as RGBA EXR; empty: pictures of "
      "the whole scene.");
  d.option("width", c.width, "Width of the pictures; 0 = as trained, or as in the path.").range(0, kMaxPictureSide);
  d.option("height", c.height, "Height of the pictures; 0 = as trained, or as in the path.").range(0, kMaxPictureSide);
  d.option("samples", c.samples, "Samples a pixel: noise halves with four times as many.").range(1, 65536);
  d.option("seed", c.seed, "Another seed, another noise.").range(0, 1e9);
  d.option("rotate", c.rotate, "Turns the environment about +z, counter-clockwise seen from above, degrees.")
      .range(-36000, 36000);
  d.option("auto_exposure", c.auto_exposure,
           "Develop the PNG so that the surfaces of the scene are middle grey in the mean, whatever the units of the map.");
  d.option("exposure", c.exposure, "Stops that the PNG are brighter than the EXR, or than auto_exposure makes them.")
      .range(-30, 30);
  d.option("frames", c.frames, "Only these of the pictures, numbered from 0: 10-19, or 7; without a film; empty = all.");
  d.option("frame_rate", c.frame_rate, "Frames a second of the film of a turntable or path.").range(1, 240);
}

void run_relight(const RelightConfig& config, StageContext& context) {
  // Errors in light and cameras are reported before any computation.
  const bool over = !config.over.empty();
  if (over && !context.optional_input("compose"))
    throw Error(
        ErrorKind::Input, "there is no guest to put over a photo",
        {.why = "the scene is no composition", .hint = "vitrine compose SCENE.yaml -o DIR, then that DIR", .code = "NO_GUEST"});
  std::vector<View> views = over ? std::vector<View>{} : chosen_views(config, context);
  const FrameRange frames = over ? FrameRange{} : frames_of(config.frames, views.size());
  const GuestDesc guest = over ? photo_of_host(config, context) : GuestDesc{};
  RelitScene scene = read_relit_scene({.optimize = context.input("optimize"),
                                       .refine = context.optional_input("refine"),
                                       .mesh = context.input("mesh"),
                                       .decompose = context.input("decompose")});
  const Lighting lighting = chosen_lighting(config, context, scene);
  check_lighting(lighting, scene, context);
  const auto environment = context.optional_input("env");
  const float brightest = lighting.environment.map().empty() ? 0.f : *std::ranges::max_element(lighting.environment.map().data());
  if (environment && brightest > 0 && brightest <= 1)
    context.warning("ENV_LOW_RANGE", fmt::format("no texel of {} is brighter than 1: was it made from a display picture?",
                                                 environment->filename().string()));
  if (over) return relight_over_photo(lighting, label_of(environment, context.optional_input("lights")), guest, context, config);
  const bool glass = scene.trained.surfels.transmittance.size() > 0;
  const bool solid_glass = scene.trained.image.transmission.thick != nullptr;
  RelitPainter painter(std::move(scene));
  context.progress({.fraction = 0, .text = "light on the scene", .values = {}});
  painter.set_lighting(lighting, {.seed = static_cast<uint64_t>(config.seed)});
  check_shadows(lighting, painter.lit(), context);

  const double exposure = config.exposure + (config.auto_exposure ? exposure_of_scene(painter.lit()) : 0);
  const std::string folder = "relit/" + label_of(environment, context.optional_input("lights"));
  const fs::path out = context.output() / folder;
  make_folders(out);
  const StoredFrames stored(context.scratch(), config.frames);
  for (size_t i = frames.first; i <= frames.last; ++i) {
    throw_if_interrupted();
    const double done = double(i - frames.first), count = double(frames.count());
    const std::string text = fmt::format("view {}/{}", i - frames.first + 1, frames.count());
    const auto report = [&](double share) { context.progress({.fraction = (done + share) / count, .text = text, .values = {}}); };
    if (!stored.take(folder, views[i].stem(), context.output()))
      write_picture(
          painter.picture(views[i],
                          {.samples = config.samples, .seed = mix64(static_cast<uint64_t>(config.seed), i), .progress = report}),
          exposure, out / views[i].stem());
    report(1);
  }
  const std::string film = config.frames.empty() ? write_sheet_and_film(config, views, out, context) : "";
  write_settings(out / "settings.json", config, exposure, lighting, solid_glass);
  for (View& v : views) v.name = v.stem() + ".png";
  write_transforms_json(out / "transforms.json", views, ".");
  context.metric("views", double(frames.count()));
  const Intrinsics& k = views[0].intrinsics;
  context.summary(fmt::format("{} {} of {}x{} at {} spp{}{}{}", frames.count(), frames.count() == 1 ? "picture" : "pictures",
                              k.width, k.height, config.samples, part_text(frames, views.size()), film.empty() ? "" : ", " + film,
                              glass ? "; glass: its inside is relit approximately" : ""));
}

Stage relight_stage() {
  StageInfo info{
      .name = "relight",
      .version = 13,
      .summary = "pictures of a scene under another light",
      .inputs = {{.name = "sfm", .doc = "Cameras of the photos."},
                 {.name = "optimize", .doc = "The trained surfels and the list of held-out views."},
                 {.name = "refine", .optional = true, .doc = "Better surfels behind glass."},
                 {.name = "mesh", .doc = "The mesh that throws shadows and is seen in mirrors."},
                 {.name = "decompose", .doc = "Materials and the light of the photos."},
                 {.name = "compose", .optional = true, .doc = "The parts of a composition, for a picture over a photo."},
                 {.name = "env",
                  .artifact = false,
                  .optional = true,
                  .doc = "Environment: lat-long, 2:1, OpenEXR or Radiance HDR. Without env and lights: that of the photos."},
                 {.name = "lights", .artifact = false, .optional = true, .doc = "Lamps: a YAML file."},
                 {.name = "path",
                  .artifact = false,
                  .optional = true,
                  .doc = "Cameras in the scene's frame, in order: a transforms.json, or a camera path of nerfstudio's viewer."}}};
  return make_stage<RelightConfig>(
      std::move(info), run_relight,
      [] {
        return std::map<std::string, std::string>{{"renderer", std::string(make_renderer(Backend::Cpu)->numerics_tag())},
                                                  {"ffmpeg", find_program("ffmpeg") ? "present" : "none"}};
      },
      problem_of);
}

}  // namespace vitrine
