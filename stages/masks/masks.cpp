#include "stages/masks/masks.h"

#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/timer.h"
#include "core/foundation/config/yaml.h"
#include "core/intake/masks/mask_files.h"
#include "core/intake/poses/photo_orientation.h"
#include "stages/masks/outputs.h"
#include "stages/masks/unseen_source.h"
#include "stages/training_cost.h"

namespace vitrine {

namespace {

// Source of this class's masks: that of the option or, for "auto", the first that the inputs allow.
MaskSourceKind chosen_source(MaskClass kind, const MasksConfig& config, const std::optional<MaskFolder>& folder,
                             const std::vector<MarkedObject>& marked, bool network) {
  if (config.of(kind).source != MaskSourceKind::Auto) return config.of(kind).source;
  if (std::any_of(marked.begin(), marked.end(), [&](const MarkedObject& t) { return marks_class(t.kind, kind); }))
    return MaskSourceKind::Boxes;
  if (folder && folder->file_count(kind) > 0) return MaskSourceKind::Files;
  if (network && !config.onnx.channels_of(kind).empty()) return MaskSourceKind::Onnx;
  if (folder || !marked.empty() || network) return MaskSourceKind::None;
  return kind == MaskClass::Transparent || kind == MaskClass::Specular ? MaskSourceKind::Proposed : MaskSourceKind::None;
}

void report_all_white(MaskClass kind, const MasksConfig& config, const PhotoMasks& masks, StageContext& context) {
  const std::string text =
      fmt::format("all masks of the class '{}' are {} everywhere", name(kind), masks.black_belongs() ? "black" : "white");
  const std::string turned = fmt::format("--set masks.{}.polarity={} turns them round", name(kind),
                                         config.of(kind).polarity == MaskPolarity::Black ? "white" : "black");
  if (kind == MaskClass::Ignore)
    throw Error(ErrorKind::Input, text,
                {.why = fmt::format("{} masks, and no pixel is left to learn from", masks.matched()),
                 .hint = turned,
                 .code = "MASKS_ALL_WHITE"});
  context.warning("MASKS_ALL_WHITE", fmt::format("{}: every pixel belongs to it; {}", text, turned));
}

std::unique_ptr<FileSource> file_source(MaskClass kind, const MasksConfig& config, const MaskCapture& capture,
                                        const std::optional<MaskFolder>& folder, StageContext& context) {
  if (!folder)
    throw Error(ErrorKind::Usage, fmt::format("masks.{}.source is 'files', and there are no files", name(kind)),
                {.hint = "--masks DIR (vitrine run), --input masks=DIR (vitrine-masks)", .code = "MASKS_MISSING"});
  auto source = std::make_unique<FileSource>(capture, *folder, kind, config.of(kind), config.frame);
  for (const Note& note : source->notes()) context.warning(note.code, note.text);
  const size_t views = source->masks().photo_count();
  if (source->masks().everything()) report_all_white(kind, config, source->masks(), context);
  if (source->matched() < views && !source->masks().nothing())
    context.warning("MASKS_INCOMPLETE",
                    fmt::format("{} of {} photos have no mask of the class '{}'", views - source->matched(), views, name(kind)));
  return source;
}

// A class without any marked pixel is omitted with a note; if all classes are empty, the files are wrong.
void leave_out_empty(std::array<std::unique_ptr<FileSource>, kMaskClassCount>& files, bool other_sources, StageContext& context) {
  const auto marks = [](const auto& source) { return source && !source->masks().nothing(); };
  const bool any = other_sources || std::any_of(files.begin(), files.end(), marks);
  for (std::unique_ptr<FileSource>& source : files) {
    if (!source || !source->masks().nothing()) continue;
    if (!any) source->masks().throw_all_black();
    context.warning("MASKS_EMPTY", fmt::format("{} ({}): the scene has nothing of it", source->masks().all_black_text(),
                                               source->masks().matched()));
    source.reset();
  }
}

void sources_of_network(const MasksConfig& config, const MaskCapture& capture, const std::optional<fs::path>& file,
                        std::span<const MaskClass> classes, StageContext& context, MaskSources& sources) {
  if (!file)
    throw Error(ErrorKind::Usage, fmt::format("masks.{}.source is 'onnx', and there is no network", name(classes.front())),
                {.hint = "--set input.mask_network=FILE.onnx (vitrine run), --input mask_network=FILE.onnx (vitrine-masks)",
                 .code = "MASKS_MISSING"});
  const auto masks = network_masks(config.onnx, capture, *file, classes, [&](double f) {
    context.progress({.fraction = 0.8 * f, .text = "a network looks at the photos", .values = {}});
  });
  for (MaskClass kind : classes) {
    const NetworkMasks::Class& c = masks->classes[size_t(kind)];
    if (!c.found)
      context.warning("MASKS_EMPTY", fmt::format("the network finds no pixel of the class '{}' in any photo", name(kind)));
    else if (!c.voted && kind != MaskClass::Ignore)
      context.warning("MASKS_NOT_VOTED",
                      fmt::format("what the network finds of the class '{}' does not meet in space: every photo "
                                  "keeps its own mask",
                                  name(kind)));
    sources[size_t(kind)] = std::make_unique<NetworkSource>(masks, kind);
  }
}

// Warns about a network that no class uses: the user would notice only after hours of training.
void report_unused_network(const MasksConfig& config, const fs::path& file, StageContext& context) {
  const bool named = std::ranges::any_of(kMaskClasses, [&](MaskClass kind) { return !config.onnx.channels_of(kind).empty(); });
  if (!named)
    throw Error(ErrorKind::Usage, "a network is given, and no class names its channels",
                {.where = file.string(),
                 .hint = "--set masks.onnx.transparent=[1] (which of them is glass), or -c configs/masks/NAME.yaml; "
                         "--set input.mask_network=none leaves it out",
                 .code = "NETWORK_UNUSED"});
  context.warning("NETWORK_UNUSED", "no class takes its masks from the network: masks.CLASS.source is something else");
}

std::string problem(const MasksConfig& c) {
  for (MaskClass kind : {MaskClass::Object, MaskClass::Ignore})
    if (c.of(kind).source == MaskSourceKind::Proposed)
      return fmt::format("masks.{}.source cannot be proposed: only glass and mirrors can be", name(kind));
  for (MaskClass kind : kMaskClasses)
    if (c.of(kind).source == MaskSourceKind::Onnx && c.onnx.channels_of(kind).empty())
      return fmt::format("masks.{0}.source is onnx, and masks.onnx.{0} names none of the network's channels", name(kind));
  return c.onnx.problem();
}

}  // namespace

MaskCapture read_mask_capture(const std::filesystem::path& sfm_folder) {
  MaskCapture capture{.sfm_folder = sfm_folder, .set = load_view_set(sfm_folder), .undistortions = {}};
  PhotoLenses lenses = read_photo_lenses(sfm_folder, capture.set);
  capture.undistortions = std::move(lenses.undistortions);
  capture.photos = std::move(lenses.photos);
  capture.without_camera = std::move(lenses.without_camera);
  capture.camera_flash = lenses.camera_flash;
  capture.cut_out = lenses.cut_out;
  return capture;
}

const MaskClassConfig& MasksConfig::of(MaskClass kind) const {
  const MaskClassConfig* all[] = {&object, &transparent, &specular, &ignore};
  return *all[size_t(kind)];
}

void describe(Describer& d, MaskClassConfig& c) {
  d.choice("source", c.source, {"auto", "files", "boxes", "onnx", "proposed", "none"},
           "Where its masks come from; auto: files, boxes or onnx where masks, marks or a network of the class are given; "
           "without any, a proposal for glass and mirrors.");
  d.choice("polarity", c.polarity, {"auto", "white", "black"},
           "What belongs to the class in files: white, black, or white after a check that this can be (auto).");
}

void describe(Describer& d, MasksConfig& c) {
  d.group("object", c.object, "What the capture is about.");
  d.group("transparent", c.transparent, "Glass: what is behind it shows through.");
  d.group("specular", c.specular, "Surfaces that mirror: bare metal, mirrors, glass.");
  d.group("ignore", c.ignore, "What no photo should be held to: passers-by, a tripod, a hand.");
  d.choice("flat", c.flat, kMaskClassWords, "Class of mask files that do not lie in a folder called like a class.");
  d.choice(
      "frame", c.frame, {"auto", "photo", "undistorted"},
      "Pictures on which the files were drawn: the photos as taken (photo), undistorted (undistorted), or found by size (auto).");
  d.group("onnx", c.onnx, "The segmentation network given as input.mask_network: what goes in, what comes out.");
  d.group("proposed", c.proposed, "Masks that nobody drew: display cases, and mirrors.");
}

namespace {

// Masks or marks of the user.
struct GivenMasks {
  std::optional<MaskFolder> folder;
  std::vector<MarkedObject> marked;
};
GivenMasks given_masks(const MasksConfig& config, const MaskCapture& capture, StageContext& context) {
  GivenMasks given;
  if (const auto path = context.optional_input("masks"); path && is_yaml_file(*path)) {
    Marks marks = read_marks(*path, capture);
    given.marked = std::move(marks.objects);
    if (!marks.without_camera.empty())
      context.warning("MASKS_WITHOUT_CAMERA", fmt::format("what is marked in {} does not count: sfm could not place {}",
                                                          fmt::join(marks.without_camera, ", "),
                                                          marks.without_camera.size() == 1 ? "that photo" : "those photos"));
  } else if (path) {
    std::vector<std::string> photos = capture.without_camera;
    for (const View& view : capture.set.views) photos.push_back(view.name);
    for (const std::string& photo : capture.photos) photos.push_back(photo);  // that views are cut from
    given.folder.emplace(*path, config.flat, photos);
    for (const Note& note : given.folder->notes()) context.warning(note.code, note.text);
    size_t files = 0;
    for (MaskClass kind : kMaskClasses) files += given.folder->file_count(kind);
    if (files == 0) throw_no_mask_file(*path);
  }
  return given;
}

// `carried`: objects propagated from marks, or nullptr.
void write_results(const MaskOutputDesc& desc, const MarkedMasks* carried, StageContext& context) {
  make_folders(context.output() / "masks");
  const MaskResults results = write_masks(desc, context);
  std::vector<std::string> objects;
  if (carried != nullptr) {
    write_marked_objects(context.output(), desc.capture, *carried);
    for (const CarriedObject::Summary& t : carried->objects) objects.push_back(t.word);
  }
  write_mask_report(desc, results, objects);
  write_contact_sheet(desc, results);

  std::string summary;
  for (MaskClass kind : kMaskClasses) {
    const ClassResult& result = results.classes[size_t(kind)];
    if (!result.kept) continue;
    context.metric(fmt::format("{}_coverage", name(kind)), result.mean_coverage());
    summary += fmt::format("{}{} {:.1f} % ({})", summary.empty() ? "" : ", ", name(kind), 100 * result.mean_coverage(),
                           desc.sources[size_t(kind)]->name());
  }
  context.summary(summary.empty() ? "nothing to mask" : summary);
}

}  // namespace

void run_masks(const MasksConfig& config, StageContext& context) {
  set_thread_limit(context.threads());
  const MaskCapture capture = read_mask_capture(context.input("sfm"));
  const auto [folder, marked] = given_masks(config, capture, context);
  const std::optional<fs::path> network = context.optional_input("mask_network");
  std::array<MaskSourceKind, kMaskClassCount> chosen{};
  std::vector<MaskClass> from_network;
  for (MaskClass kind : kMaskClasses) {
    chosen[size_t(kind)] = chosen_source(kind, config, folder, marked, network.has_value());
    if (chosen[size_t(kind)] == MaskSourceKind::Onnx) from_network.push_back(kind);
  }
  MaskSources sources;
  if (!from_network.empty())
    sources_of_network(config, capture, network, from_network, context, sources);
  else if (network)
    report_unused_network(config, *network, context);
  std::shared_ptr<const Proposal> proposal;
  std::shared_ptr<const MarkedMasks> carried;
  std::array<std::unique_ptr<FileSource>, kMaskClassCount> from_files;
  for (MaskClass kind : kMaskClasses)
    if (chosen[size_t(kind)] == MaskSourceKind::Files)
      from_files[size_t(kind)] = file_source(kind, config, capture, folder, context);
  leave_out_empty(
      from_files,
      std::ranges::any_of(chosen, [](MaskSourceKind c) { return c != MaskSourceKind::Files && c != MaskSourceKind::None; }),
      context);
  for (MaskClass kind : kMaskClasses) {
    const MaskSourceKind source = chosen[size_t(kind)];
    if (source == MaskSourceKind::Files) sources[size_t(kind)] = std::move(from_files[size_t(kind)]);
    if (source == MaskSourceKind::Boxes) {
      if (marked.empty())
        throw Error(
            ErrorKind::Usage, fmt::format("masks.{}.source is 'boxes', and nothing is marked", name(kind)),
            {.hint = "--masks MARKS.yaml (vitrine run), --input masks=MARKS.yaml (vitrine-masks)", .code = "MASKS_MISSING"});
      if (!carried)
        carried = carry_marks(capture, marked, config.hull_voxels, [&](double f) {
          context.progress({.fraction = 0.8 * f, .text = "carries the marks to all photos", .values = {}});
        });
      sources[size_t(kind)] = std::make_unique<MarkedSource>(carried, kind);
    }
    if (source != MaskSourceKind::Proposed) continue;
    if (!proposal) {
      const Timer timer;
      proposal = propose(config.proposed, capture, [&](double f) {
        context.progress({.fraction = 0.8 * f, .text = "looks for cases, and for what changes from view to view", .values = {}});
      });
      context.timing("proposed", timer.seconds());
      if (proposal->unsure)
        context.warning("MASKS_UNSURE",
                        "the photos do not show clearly enough what changes with the view: no glass or mirror is proposed; "
                        "vitrine mark lets you draw them");
    }
    sources[size_t(kind)] = std::make_unique<ProposedSource>(proposal, kind);
  }
  add_unseen_pixels(capture, sources[size_t(MaskClass::Ignore)]);
  write_results({.capture = capture, .sources = sources, .output = context.output()}, carried.get(), context);
}

Stage masks_stage() {
  StageInfo info{
      .name = "masks",
      .version = 19,
      .summary = "which pixels are glass, mirror, object, or not to be used",
      .inputs = {{.name = "sfm", .doc = "cameras and undistorted photos"},
                 {.name = "masks",
                  .artifact = false,
                  .optional = true,
                  .doc =
                      "masks of the photos, a folder per class: object, transparent, specular, ignore; or a YAML file of marks",
                  .also = files_of_mask_list},
                 {.name = "mask_network",
                  .artifact = false,
                  .optional = true,
                  .doc = "a network that segments glass, mirrors or the object in one photo (ONNX)"}},
      .doing = "finding glass and mirrors",
      .cost = masks_cost};
  return make_stage<MasksConfig>(std::move(info), run_masks, {}, problem);
}

StageCost masks_cost(const CostTerms& t) {
  const double out = ingested_mpx(t);
  if (t.capture.masks) return stage_cost(0.25 * t.photos(), 0.9, 110 + 4 * out, 0.35 * out);
  return stage_cost(3.2 * t.photos(), 0.9, 160 + 3 * out + 5 * t.photos(), 0.05 * out);
}

}  // namespace vitrine
