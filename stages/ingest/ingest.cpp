#include "stages/ingest/ingest.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <set>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/hash.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/intake/film/photos_and_films.h"
#include "core/intake/photos/photo_list.h"
#include "core/scene/camera/panorama_views.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/probe.h"
#include "core/intake/photos/photo_files.h"
#include "stages/ingest/develop.h"
#include "stages/ingest/panorama_photos.h"

namespace vitrine {

namespace {

using namespace ingest;

constexpr size_t kMinPhotos = 2;  // minimum for structure from motion
constexpr double kFilmShare = 0.8;  // of the progress, if there are films

// Result for one file.
struct Outcome {
  std::vector<Photo> photos;  // one; the views of a panorama
  std::string failure;  // empty = developed
  ColorFacts color;
  RepairedValues repaired;
  std::vector<std::string> notes;
  std::string aside;
  Digest digest;  // of the file
};

size_t stored_pixels(const fs::path& path) {
  constexpr size_t kHead = 1 << 18;  // EXIF with a thumbnail is shorter
  std::string head(kHead, '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<size_t>(in.gcount()));
  Probe probe = probe_photo(head);
  if (probe.format == PhotoFormat::Tiff) probe = probe_photo(read_file(path));  // directories are often at the end of the file
  if (probe.format == PhotoFormat::Raw) {  // its first directory is often that of a preview
    const RawFacts facts = raw_head(path).facts;
    probe.width = uint64_t(facts.width), probe.height = uint64_t(facts.height);
  }
  constexpr uint64_t kTypicalPixels = 24'000'000, kMaxSide = 1 << 20;
  if (probe.width == 0 || probe.height == 0 || probe.width > kMaxSide || probe.height > kMaxSide) return kTypicalPixels;
  return static_cast<size_t>(probe.width * probe.height);
}

// Number of photos processed in parallel: one per thread, limited by memory.
size_t photos_at_once(const std::vector<PhotoFile>& photos, const StageContext& context) {
  size_t largest = 1;
  for (const PhotoFile& photo : photos) largest = std::max(largest, stored_pixels(photo.path));
  constexpr size_t kDefaultBudget = size_t{3} << 30;
  const size_t budget = context.max_memory_bytes() > 0 ? context.max_memory_bytes() / 4 * 3 : kDefaultBudget;
  const size_t fitting = std::max<size_t>(budget / develop_bytes(largest), 1);
  return std::min(fitting, static_cast<size_t>(std::max(thread_limit(), 1)));
}

// `view_folder`: of the views, if it is a panorama.
Outcome ingest_photo(const PhotoFile& file, const std::string& view_folder, int max_side, const fs::path& output) {
  Outcome outcome;
  Developed developed;
  try {
    developed = develop(file.path, max_side, file.balance);
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Input) throw;
    outcome.failure = e.detail().why.empty() ? e.message() : e.detail().why;
    return outcome;
  }
  Photo& photo = developed.photo;
  photo.name = file.name;
  photo.stem = file.stem;
  photo.source = file.source;
  outcome.color = std::move(developed.color);
  outcome.repaired = developed.repaired;
  outcome.notes = std::move(developed.notes);
  outcome.aside = std::move(developed.aside);
  outcome.digest = developed.digest;
  if (developed.panorama) {
    outcome.photos = write_panorama_views(std::move(developed.linear), photo, view_folder, max_side, output);
    return outcome;
  }
  write_exr_rgb(ingested_linear_path(output, photo), developed.linear);
  write_ldr(ingested_ldr_path(output, photo), srgb8_from_linear(developed.linear));
  outcome.photos.push_back(photo);
  return outcome;
}

// Progress starts at the fraction `begun`.
std::vector<Outcome> ingest_photos(const std::vector<PhotoFile>& files, int max_side, double begun, StageContext& context) {
  std::vector<Outcome> outcomes(files.size());
  const size_t at_once = photos_at_once(files, context);
  const std::vector<std::string> folders = view_folders(files);
  for (size_t begin = 0; begin < files.size(); begin += at_once) {
    throw_if_interrupted();
    const size_t count = std::min(at_once, files.size() - begin);
    parallel_for(count, 1, [&](size_t i) {
      outcomes[begin + i] = ingest_photo(files[begin + i], folders[begin + i], max_side, context.output());
    });
    const size_t done = begin + count;
    context.progress({.fraction = begun + (1 - begun) * static_cast<double>(done) / static_cast<double>(files.size()),
                      .text = fmt::format("{} / {} photos", done, files.size()),
                      .values = {{"done", static_cast<double>(done)}, {"total", static_cast<double>(files.size())}}});
  }
  return outcomes;
}

// List of the failures, one per line, at most `kShown`.
std::string failure_list(const std::vector<PhotoFile>& files, const std::vector<Outcome>& outcomes) {
  constexpr size_t kShown = 10;
  std::string text;
  size_t failed = 0;
  for (size_t i = 0; i < files.size(); ++i) {
    if (outcomes[i].failure.empty() || ++failed > kShown) continue;
    text += fmt::format("{}{}: {}", text.empty() ? "" : "\n         ", files[i].source, outcomes[i].failure);
  }
  if (failed > kShown) text += fmt::format("\n         and {} more", failed - kShown);
  return text;
}

void report_folder(const PhotoFolder& folder, StageContext& context) {
  size_t skipped = 0;
  for (const auto& [extension, count] : folder.skipped) skipped += count;
  const size_t unseen = folder.listed.hidden + folder.listed.junk;
  context.metric("files_skipped", static_cast<double>(skipped + unseen));
  context.metric("files_beside_photos", static_cast<double>(folder.beside.size()));
  if (skipped + unseen > 0)
    log_info("skipped {} hidden, {} of the system and {} other files{}{}", folder.listed.hidden, folder.listed.junk, skipped,
             skipped ? ": " : "", skipped_text(folder));
  for (const FolderNote& note : notes_of(folder)) context.warning(note.code, note.sentence());
}

void report_films(const PhotosAndFilms& all, StageContext& context) {
  if (all.films.empty()) return;
  context.metric("films", static_cast<double>(all.films.size()));
  context.metric("film_frames", static_cast<double>(all.frames.size()));
  for (const FilmReport& film : all.films)
    if (!film.failure.empty())
      context.warning("FILMS_LEFT_OUT", film.sentence());
    else if (!film.damage.empty())
      context.warning("FILM_DAMAGED", film.sentence());
    else
      log_info("{}", film.sentence());
}

// Reports copies of one file: they cost time and add no information, but do no harm.
void report_repeated(const std::vector<PhotoFile>& files, const std::vector<Outcome>& outcomes, StageContext& context) {
  std::map<std::string, size_t> first;
  size_t repeated = 0;
  std::string example;
  for (size_t i = 0; i < files.size(); ++i) {
    if (!outcomes[i].failure.empty()) continue;
    const auto [same, is_new] = first.emplace(outcomes[i].digest.hex(), i);
    if (is_new) continue;
    if (++repeated == 1) example = fmt::format("{} is {}", files[i].source, files[same->second].source);
  }
  if (repeated > 0)
    context.warning("PHOTOS_REPEATED",
                    fmt::format("{} the same file as another ({}): {} different photos remain",
                                repeated == 1 ? "1 photo is" : fmt::format("{} photos are", repeated), example, first.size()));
}

// Reports each omitted or assumed content once, with the number of photos and the name of the first.
void report_contents(const std::vector<PhotoFile>& files, const std::vector<Outcome>& outcomes, StageContext& context) {
  struct Several {
    size_t photos = 0, first = 0;
  };
  std::map<std::string, Several> notes, asides;
  const auto add = [](std::map<std::string, Several>& to, const std::string& note, size_t photo) {
    Several& several = to[note];
    if (several.photos++ == 0) several.first = photo;
  };
  for (size_t i = 0; i < outcomes.size(); ++i) {
    for (const std::string& note : outcomes[i].notes) add(notes, note, i);
    if (!outcomes[i].aside.empty()) add(asides, outcomes[i].aside, i);
  }
  const auto sentence = [&](const std::string& note, const Several& several) {
    return several.photos == 1 ? fmt::format("{} is {}", files[several.first].source, note)
                               : fmt::format("{} photos ({} and others): {}", several.photos, files[several.first].source, note);
  };
  for (const auto& [note, several] : notes) context.warning("PHOTO_CONTENT", sentence(note, several));
  for (const auto& [aside, several] : asides) log_info("{}", sentence(aside, several));
}

// Reports assumptions about colours and alpha. Returns the conversions, for the summary.
std::string report_colors(const std::vector<Outcome>& outcomes, StageContext& context) {
  std::vector<const ColorFacts*> colors;
  for (const Outcome& o : outcomes) colors.push_back(o.failure.empty() ? &o.color : nullptr);
  for (const ColorNote& note : color_notes(colors)) {
    if (!note.warning_code.empty())
      context.warning(note.warning_code, fmt::format("{}: {}; {}", note.what, note.why, note.hint));
    else
      log_info("{}: {}", note.what, note.why);
  }
  return colors_text(colors);
}

void report_photos(const std::vector<Photo>& photos, const std::string& colors, size_t left_out, StageContext& context) {
  std::set<std::pair<int, int>> sizes;
  size_t with_focal = 0, with_exposure = 0;
  double darkest = 1e300, brightest = -1e300;
  for (const Photo& p : photos) {
    sizes.insert({p.width, p.height});
    with_focal += p.focal_px.has_value();
    if (!p.exposure_ev) continue;
    ++with_exposure;
    darkest = std::min(darkest, *p.exposure_ev);
    brightest = std::max(brightest, *p.exposure_ev);
  }
  context.metric("photos", static_cast<double>(photos.size()));
  context.metric("photos_left_out", static_cast<double>(left_out));
  context.metric("photo_sizes", static_cast<double>(sizes.size()));
  context.metric("photos_with_focal", static_cast<double>(with_focal));
  if (with_exposure > 0) context.metric("exposure_range_ev", brightest - darkest);
  if (sizes.size() > 1) {
    std::string list;
    for (const auto& [w, h] : sizes) list += fmt::format("{}{} x {}", list.empty() ? "" : ", ", w, h);
    context.warning("PHOTO_SIZES_DIFFER",
                    fmt::format("the photos have {} sizes ({}): each keeps its own camera", sizes.size(), list));
  }
  const auto views = size_t(std::ranges::count_if(photos, [](const Photo& p) { return p.rig.has_value(); }));
  if (views > 0) context.metric("panoramas", static_cast<double>(views / kPanoramaViews));
  const Photo& first = photos.front();
  context.summary(fmt::format("{} photos{}{}{}{}{}{}", photos.size(),
                              views > 0 ? fmt::format("  {} of them cut from {} panoramas", views, views / kPanoramaViews) : "",
                              sizes.size() == 1 ? fmt::format("  {} x {}", first.width, first.height) : "",
                              first.camera.empty() ? "" : "  " + first.camera,
                              with_focal > 0 ? fmt::format("  focal known for {}", with_focal) : "  no focal length",
                              colors.empty() ? "" : "  " + colors, left_out > 0 ? fmt::format("  {} left out", left_out) : ""));
}

void run(const IngestConfig& config, StageContext& context) {
  const fs::path input = context.input("photos");
  const PhotosAndFilms all =
      photos_and_films(input, {.most_frames = size_t(config.frames),
                               .work = context.scratch() / "films",
                               .progress = [&](double fraction, const std::string& text) {
                                 context.progress({.fraction = kFilmShare * fraction, .text = text, .values = {}});
                               }});
  const PhotoFolder& folder = all.folder;
  report_folder(folder, context);
  report_films(all, context);
  std::vector<Outcome> outcomes = ingest_photos(folder.photos, config.max_side, all.films.empty() ? 0 : kFilmShare, context);
  for (size_t i = 0; i < outcomes.size(); ++i)
    if (const std::string camera = all.camera_of(folder.photos[i].source); !camera.empty())
      for (Photo& photo : outcomes[i].photos) photo.camera = camera;

  std::vector<Photo> photos;
  RepairedValues repaired;
  size_t usable = 0;  // views of one panorama have one centre
  for (const Outcome& outcome : outcomes) {
    if (!outcome.failure.empty()) continue;
    ++usable;
    photos.insert(photos.end(), outcome.photos.begin(), outcome.photos.end());
    repaired += outcome.repaired;
  }
  if (photos.size() > usable) std::ranges::sort(photos, {}, &Photo::name);
  const size_t left_out = outcomes.size() - usable;
  const std::string failures = failure_list(folder.photos, outcomes);
  if (usable < kMinPhotos)
    throw Error(
        ErrorKind::Input,
        fmt::format("{} usable {} too few: at least {} are needed, and 20 to 60 are usual", usable,
                    usable == 1 ? "photo is" : "photos are", kMinPhotos),
        {.where = input.string(),
         .why = failures.empty() ? fmt::format("the folder holds {} photo{}", outcomes.size(), outcomes.size() == 1 ? "" : "s")
                                 : failures,
         .hint = "add photos, or replace those that cannot be read",
         .code = "TOO_FEW_PHOTOS"});
  if (left_out > 0) context.warning("PHOTOS_LEFT_OUT", fmt::format("{} photos are left out:\n         {}", left_out, failures));
  if (repaired.not_numbers + repaired.too_bright > 0)
    context.warning("PIXELS_NOT_FINITE", repaired.text());
  else if (repaired.negative > 0)
    log_info("{}", repaired.text());
  report_contents(folder.photos, outcomes, context);
  report_repeated(folder.photos, outcomes, context);
  write_photo_list(context.output(), photos);
  write_film_report(context.output(), all);
  report_photos(photos, report_colors(outcomes, context), left_out, context);
}

}  // namespace

void describe(Describer& d, IngestConfig& c) {
  d.option("max_side", c.max_side,
           "Longest side of the ingested photos in pixels; larger ones are reduced in linear light; 0 = as they are.")
      .range(0, 32768);
  d.option("frames", c.frames, "Most frames that become photos, of all films together.").range(2, 2000);
}

Stage ingest_stage() {
  return make_stage<IngestConfig>(
      {.name = "ingest",
       .version = 6,
       .summary = "Photos become upright linear EXR files, 8-bit copies, and a list with focal length and exposure.",
       .inputs = {{.name = "photos", .artifact = false, .optional = false, .doc = "Folder of photos: JPEG, PNG, TIFF, EXR, HEIC, AVIF, raw; films in it, or one film."}},
       .doing = "reading the photos",
       .cost = ingest_cost},
      &run);
}

}  // namespace vitrine
