// Sections of pictures: photo against rendered view, layers, mesh and normals, other lights.
#include <algorithm>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/folder_files.h"
#include "core/scene/mesh/mesh_io.h"
#include "pipeline/report_page/page.h"
#include "pipeline/report_page/pictures.h"
#include "pipeline/tool.h"

namespace vitrine {

namespace {

constexpr size_t kMostCompared = 8, kMostLayered = 2, kMostSurfaceViews = 3, kMostRelit = 4, kMostLights = 6;
constexpr int kOpeningScale = 3;

// Not lazily loaded: unloaded pictures would be blank in print.
std::string image(const Picture& p, const std::string& alt, std::string_view css_class = {}) {
  return fmt::format("<img{} src=\"{}\" width=\"{}\" height=\"{}\" alt=\"{}\">",
                     css_class.empty() ? std::string() : fmt::format(" class=\"{}\"", css_class), p.uri, p.width, p.height,
                     escaped(alt));
}

std::string captioned(const Picture& p, const std::string& alt, const std::string& caption) {
  return fmt::format("<figure>{}<figcaption>{}</figcaption></figure>", image(p, alt), escaped(caption));
}

fs::path eval_file(const Material& m, const std::string& stem, const char* what) {
  return m.project / "eval" / fmt::format("{}_{}.png", stem, what);
}

std::string stem_of(const std::string& name) { return fs::path(name).replace_extension().generic_string(); }

// At most `most` items, evenly spaced, including first and last.
template <class T>
std::vector<T> spread(const std::vector<T>& all, size_t most) {
  if (all.size() <= most) return all;
  std::vector<T> some;
  for (size_t i = 0; i < most; ++i) some.push_back(all[i * (all.size() - 1) / (most - 1)]);
  return some;
}

// Held-out views, lowest PSNR first.
std::vector<PhotoScore> heldout_by_psnr(const Material& m) {
  std::vector<PhotoScore> views;
  for (const PhotoScore& v : m.figures.views)
    if (v.heldout && stays_below(v.name)) views.push_back(v);
  std::stable_sort(views.begin(), views.end(), [](const PhotoScore& a, const PhotoScore& b) { return a.psnr < b.psnr; });
  return views;
}

std::string compared(const Material& m, const PhotoScore& v, size_t number) {
  const std::string stem = stem_of(v.name);
  const auto photo = picture_of_file(eval_file(m, stem, "gt"), kLargePicture),
             render = picture_of_file(eval_file(m, stem, "pred"), kLargePicture),
             error = picture_of_file(eval_file(m, stem, "err"), kMiddlePicture),
             confidence = picture_of_file(eval_file(m, stem, "conf"), kMiddlePicture);
  if (!photo || !render) return {};
  std::string text = "<figure class=\"compare\">";
  if (error) text += fmt::format("<input type=\"checkbox\" class=\"show-error\" id=\"error-{}\">", number);
  if (confidence) text += fmt::format("<input type=\"checkbox\" class=\"show-confidence\" id=\"confidence-{}\">", number);
  text += fmt::format("<div class=\"pair\" style=\"aspect-ratio:{}/{}\">", render->width, render->height);
  text += image(*render, "Render of the view " + v.name) + image(*photo, "Photo " + v.name, "photo");
  if (error) text += image(*error, "Where photo and render differ: bright is a large difference", "error");
  if (confidence) text += image(*confidence, "Confidence of the surface: yellow is sure, violet is not", "confidence");
  text += fmt::format(
      "<span class=\"tag photo-tag\" aria-hidden=\"true\">photo</span><span class=\"tag render-tag\" "
      "aria-hidden=\"true\">render</span><span "
      "class=\"bar\" aria-hidden=\"true\"></span><input type=\"range\" min=\"0\" max=\"100\" value=\"50\" "
      "aria-label=\"{}\"></div>",
      escaped(fmt::format("{}: how much of the photo covers the render", v.name)));
  text += fmt::format("<figcaption><span class=\"name\">{}</span> <span>{:.1f}\u00a0dB{}</span>", escaped(v.name), v.psnr,
                      v.ssim ? fmt::format(", SSIM {:.3f}", *v.ssim) : "");
  if (error) text += fmt::format("<label for=\"error-{}\">error</label>", number);
  if (confidence) text += fmt::format("<label for=\"confidence-{}\">confidence</label>", number);
  return text + "</figcaption></figure>";
}

struct LayerKindOf {
  const char *folder, *title;
  AovKind kind;
  bool main = false;  // shown initially; others on request
};
constexpr LayerKindOf kLayers[] = {
    {"diffuse", "matt surface", AovKind::Radiance, true},
    {"reflection", "what is reflected", AovKind::Radiance, true},
    {"transmission", "what is seen through glass", AovKind::Radiance, true},
    {"reflected", "what the reflected rays brought", AovKind::Radiance},
    {"transmitted", "what the rays behind the glass brought", AovKind::Radiance},
    {"specular_weight", "where it is glossy", AovKind::Weight},
    {"transmission_weight", "where light goes through", AovKind::Weight},
    {"roughness", "roughness", AovKind::Weight},
    {"normal", "normals, world", AovKind::Normal, true},
    {"depth", "depth, near is bright", AovKind::Depth, true},
};

// PNG frames of one light in a folder, without the contact sheet.
std::vector<fs::path> frames_of(const fs::path& folder) {
  std::vector<fs::path> frames;
  std::error_code ec;
  for (fs::recursive_directory_iterator it(folder, ec), end; !ec && it != end; it.increment(ec))
    if (it->path().extension() == ".png" && it->path().stem() != "contact_sheet") frames.push_back(it->path());
  std::sort(frames.begin(), frames.end());
  return frames;
}

std::vector<fs::path> folders_in(const fs::path& folder) {
  std::vector<fs::path> all;
  std::error_code ec;
  for (fs::directory_iterator it(folder, ec), end; !ec && it != end; it.increment(ec))
    if (it->is_directory(ec) && !it->path().filename().string().starts_with(".")) all.push_back(it->path());
  std::sort(all.begin(), all.end());
  return all;
}

// Folders of relit pictures, one per light.
std::vector<fs::path> lights_of(const Material& m) {
  std::vector<fs::path> lights = folders_in(m.project / "relit");
  for (const fs::path& folder : folders_in(m.project))
    for (const fs::path& light : folders_in(folder / "relit")) lights.push_back(light);
  if (lights.size() > kMostLights) lights.resize(kMostLights);
  return lights;
}

struct Opening {
  Picture picture;
  std::string caption;
};
// First view under the first light; otherwise the picture made with view.html; otherwise the best held-out view.
std::optional<Opening> opening_of(const Material& m) {
  for (const fs::path& light : lights_of(m))
    for (const fs::path& frame : frames_of(light))
      if (auto p = picture_of_file(frame, kOpeningPicture))
        return Opening{std::move(*p),
                       fmt::format("The scene under the light {}, view {}.", light.filename().string(), frame.stem().string())};
  if (auto p = picture_of_file(relit_sample_path(m.project), kOpeningPicture))
    return Opening{std::move(*p), "The scene under the light of the photos, turned by 150 degrees."};
  const std::vector<PhotoScore> views = heldout_by_psnr(m);
  for (auto v = views.rbegin(); v != views.rend(); ++v)
    if (auto p = picture_of_file(eval_file(m, stem_of(v->name), "pred"), kOpeningPicture))
      return Opening{
          std::move(*p),
          fmt::format("The scene as photographed, rendered from the camera of {}, which training never saw.", v->name)};
  return std::nullopt;
}

}  // namespace

std::string opening_section(const Material& m) {
  const std::optional<Opening> opening = opening_of(m);
  std::error_code ec;
  const fs::path scene = view_page_path(m.project);
  const bool linked = fs::exists(scene, ec);
  if (!opening && !linked) return {};
  const std::string target = linked ? scene.filename().string() : std::string();
  std::string text = "<figure id=\"opening\">";
  if (opening) {
    // Limits the magnification, which would blur the picture.
    const std::string shown = fmt::format("<div style=\"max-width:{}px\">{}</div>", kOpeningScale * opening->picture.width,
                                          image(opening->picture, opening->caption));
    text += linked ? fmt::format("<a href=\"{}\">{}</a>", target, shown) : shown;
  }
  text += "<figcaption>";
  if (opening) text += fmt::format("<span>{}</span>", escaped(opening->caption));
  if (linked) text += fmt::format("<a class=\"open\" href=\"{}\">Open the scene: any side, any light</a>", target);
  return text + "</figcaption></figure>\n";
}

std::string compare_section(const Material& m) {
  std::string body;
  size_t number = 0;
  for (const PhotoScore& v : spread(heldout_by_psnr(m), kMostCompared)) body += compared(m, v, ++number);
  if (!body.empty()) body = "<div class=\"compares\">" + body + "</div>";
  return section("views", "Photo against render",
                 "Photos that training never saw, the weakest first. Drag across a picture: the photo is on the left, the render "
                 "on the right.",
                 body);
}

std::string layers_section(const Material& m) {
  std::string body;
  std::vector<PhotoScore> views = heldout_by_psnr(m);
  std::reverse(views.begin(), views.end());
  for (const PhotoScore& v : spread(views, kMostLayered)) {
    std::string main, more;
    for (const LayerKindOf& layer : kLayers)
      if (const auto p =
              picture_of_layer(m.project / "eval/layers" / layer.folder / (stem_of(v.name) + ".exr"), layer.kind, kSmallPicture))
        (layer.main ? main : more) += captioned(*p, fmt::format("{} of {}", layer.title, v.name), layer.title);
    if (main.empty() && more.empty()) continue;
    body += fmt::format("<h3>{}</h3><div class=\"grid five\">{}</div>", escaped(v.name), main);
    if (!more.empty())
      body += fmt::format("<details><summary>Rays and weights of {}</summary><div class=\"grid five\">{}</div></details>",
                          escaped(v.name), more);
  }
  if (const auto masks = picture_of_file(m.project / "masks/contact_sheet.png", kLargePicture))
    body += fmt::format("<details><summary>Masks of glass and mirrors</summary>{}</details>",
                        image(*masks, "Contact sheet of the masks of glass and mirrors"));
  if (const auto objects = picture_of_file(m.project / "objects/contact_sheet.png", kLargePicture))
    body += fmt::format(
        "<details><summary>Glass, mirrors and coats (objects/objects.json; correct it and give it with "
        "--objects)</summary>{}</details>",
        image(*objects, "Photos with the objects that were found"));
  if (const auto transients = picture_of_file(m.project / "optimize/transients/contact_sheet.png", kLargePicture))
    body += fmt::format("<details><summary>Transient content, not trained on</summary>{}</details>",
                        image(*transients, "Photos with the pixels that the other photos contradict"));
  return section("layers", "Layers", "What the picture is made of: the matt surface, what it reflects, what is seen through it.",
                 body);
}

std::string surface_section(const Material& m) {
  const fs::path file = m.project / "mesh/mesh.ply";
  std::error_code ec;
  if (!m.views || !fs::is_regular_file(file, ec)) return {};
  std::vector<const View*> held, all;
  for (const View& v : m.views->views) {
    all.push_back(&v);
    if (m.heldout.contains(v.name)) held.push_back(&v);
  }
  std::string body;
  try {
    const TriMesh triangles = read_mesh_ply(file);
    if (triangles.faces.empty()) return {};
    const MeshHits mesh(triangles);
    for (const View* v : spread(held.size() >= kMostSurfaceViews ? held : all, kMostSurfaceViews)) {
      const SurfaceView seen = surface_view(mesh, *v, kMiddlePicture);
      std::string cells = captioned(picture_of(seen.clay), "The mesh, in clay, from the camera of " + v->name, "mesh") +
                          captioned(picture_of(seen.normals), "Normals of the mesh from the camera of " + v->name, "normals");
      if (const auto photo = picture_of_file(eval_file(m, v->stem(), "gt"), kMiddlePicture); photo && stays_below(v->stem()))
        cells = captioned(*photo, "Photo " + v->name, v->name) + cells;
      body += fmt::format("<div class=\"grid three\">{}</div>", cells);
    }
  } catch (const Error&) {
    return {};
  }
  return section(
      "mesh", "Mesh and normals",
      "The surface as the photos' cameras see it. Normals in the camera's frame: red to the right, green up, blue towards you.",
      body);
}

std::string relit_section(const Material& m) {
  std::string body;
  for (const fs::path& light : lights_of(m)) {
    std::string cells;
    for (const fs::path& frame : spread(frames_of(light), kMostRelit))
      if (const auto p = picture_of_file(frame, kMiddlePicture))
        cells += captioned(*p, fmt::format("{} under the light {}", frame.stem().string(), light.filename().string()),
                           frame.stem().string());
    if (!cells.empty())
      body += fmt::format("<h3>{}</h3><div class=\"grid\">{}</div>",
                          escaped(light.lexically_relative(m.project).generic_string()), cells);
  }
  const auto sheet = [&](const char* name, const char* title, const char* alt) {
    if (const auto p = picture_of_file(m.project / "decompose" / name, kLargePicture))
      body += fmt::format("<details><summary>{}</summary>{}</details>", title, image(*p, alt));
  };
  sheet("albedo.png", "Albedo and light", "Photo, albedo and light on the surface, for some photos");
  sheet("baked.png", "What stays baked in",
        "Photo, albedo times light and their ratio, for some photos: what a new light will not move");
  return section("light", "Under another light",
                 "Pictures of <code>vitrine relight</code>, and how the colours were taken apart into albedo and light.", body);
}

}  // namespace vitrine
