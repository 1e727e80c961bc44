#include "core/intake/film/photos_and_films.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/process.h"
#include "core/foundation/config/json_file.h"
#include "core/foundation/config/text.h"
#include "core/intake/film/film_frames.h"
#include "core/scene/image/contact_sheet.h"

namespace vitrine {

namespace {

constexpr double kLivePhotoSeconds = 5;
constexpr double kHopelessBlur = 3;  // pixels at a longest side of 800
constexpr size_t kLeastFrames = 2;

struct Film {
  FilmInfo info;
  std::vector<TrackedFrame> track;
};

// "4.1 s", "61 s".
std::string seconds_text(double s) { return fmt::format("{:.1f} s", s); }

// Start of the paths of its frames below the given folder: folder and stem of the film, with its extension where the stem is
// that of another film, or photos are numbered with it.
std::string frame_stem(const std::string& film, const PhotoFolder& folder) {
  const auto stem = [](const std::string& source) { return fs::path(source).replace_extension().generic_string(); };
  const std::string own = stem(film);
  for (const FilmFile& other : folder.films)
    if (other.source != film && stem(other.source) == own) return film;
  for (const PhotoFile& photo : folder.photos)
    if (photo.source.starts_with(own + "_")) return film;
  return own;
}

int64_t milliseconds(const TrackedFrame& frame) { return std::llround(std::max(frame.time.seconds, 0.0) * 1000); }

PhotoFolder found_folder(const fs::path& given) {
  std::error_code ec;
  if (!fs::is_regular_file(given, ec) || !is_film_name(given)) return find_photos(given, FilmsAre::Photos);
  PhotoFolder folder;
  folder.folder = given.parent_path();
  folder.films.push_back({given, given.filename().string(), false});
  return folder;
}

// Whether the file is a Live Photo; those are left out. A film that cannot be read is none.
bool is_live_photo(const FilmFile& file) {
  if (!file.of_photo) return false;
  if (!find_program("ffprobe")) return true;
  try {
    return read_film_info(file.path).seconds <= kLivePhotoSeconds;
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Input) throw;
    return true;  // its photo is there
  }
}

std::vector<FilmFile> films_to_cut(PhotoFolder& folder) {
  std::vector<FilmFile> cut;
  for (const FilmFile& file : folder.films)
    if (is_live_photo(file))
      folder.live_photos.push_back(file.source);
    else
      cut.push_back(file);
  return cut;
}

Error stands_still(const FilmFile& film, const Film& tracked) {
  const double moved = tracked.track.empty() ? 0 : tracked.track.back().motion;
  return Error(
      ErrorKind::Input, "the camera of this film hardly moves",
      {.where = film.path.string(),
       .why = fmt::format("in {} its picture moves by {:.1f} % of the longest side; depth needs views from several places",
                          seconds_text(tracked.track.empty() ? 0 : tracked.track.back().time.seconds), 100 * moved),
       .hint = "walk around the object slowly while filming; give the film without parts that stand still",
       .code = "FILM_STANDS_STILL"});
}

void require_sharp(const FilmFile& file, const std::vector<WrittenFrame>& written) {
  for (const WrittenFrame& w : written)
    if (w.blur_px ? *w.blur_px <= kHopelessBlur : w.textured) return;
  throw Error(ErrorKind::Input, "all frames of this film are blurred or show nothing",
              {.where = file.path.string(),
               .why = fmt::format("none of the sharpest {} frames has edges narrower than {:.0f} pixels of 800", written.size(),
                                  kHopelessBlur),
               .hint = "film again: slower, in more light, and in focus",
               .code = "FILM_BLURRED"});
}

// Pass 2 of one film; adds its frames to the photos.
void write_frames(const FilmFile& file, size_t f, const Film& film, const CutRequest& request, size_t films,
                  PhotosAndFilms& all) {
  std::vector<FrameFile> files;
  for (const FilmFrameReport& frame : all.frames)
    if (frame.film == f)
      files.push_back({frame.time.pts, request.work / "frames" / std::to_string(f) / fs::path(frame.source).filename()});
  make_folders(files.front().path.parent_path());
  const std::vector<WrittenFrame> written = write_film_frames(film.info, files, [&](size_t done) {
    const double share = double(done) / double(files.size());
    request.progress(0.5 + 0.5 * (double(f) + share) / double(films),
                     fmt::format("{}: {} / {} frames written", file.source, done, files.size()));
  });
  require_sharp(file, written);
  size_t k = 0;
  for (FilmFrameReport& frame : all.frames) {
    if (frame.film != f) continue;
    frame.blur_px = written[k].blur_px;
    frame.thumbnail = written[k].thumbnail;
    all.folder.photos.push_back({files[k].path, frame.source, {}, {}});
    ++k;
  }
}

FilmReport report_of(const FilmFile& file, const Film& film, const std::string& damage) {
  FilmReport r{.source = file.source,
               .seconds = film.track.back().time.seconds,
               .width = film.info.width,
               .height = film.info.height,
               .frames = film.track.size(),
               .notes = film.info.notes,
               .damage = {},
               .failure = {}};
  if (film.info.orientation >= 5) std::swap(r.width, r.height);
  if (!damage.empty()) r.damage.push_back(fmt::format("it is damaged ({}): frames may be missing", damage));
  constexpr double kMissing = 0.9;  // of the stated duration
  if (film.info.seconds > 1 && r.seconds < kMissing * film.info.seconds - 1)
    r.damage.push_back(
        fmt::format("it is truncated: {} of {} can be decoded", seconds_text(r.seconds), seconds_text(film.info.seconds)));
  return r;
}

void forget_skipped(PhotoFolder& folder) {
  for (const FilmFile& file : folder.films) {
    const auto at = folder.skipped.find(lower_extension(file.path));
    if (at != folder.skipped.end() && --at->second == 0) folder.skipped.erase(at);
  }
}

}  // namespace

std::string FilmReport::sentence() const {
  if (!failure.empty()) return fmt::format("{} is left out: {}", source, failure);
  std::string text =
      fmt::format("{}: {}, {} x {}: {} of {} frames are used", source, seconds_text(seconds), width, height, chosen, frames);
  for (const std::vector<std::string>* list : {&notes, &damage})
    for (const std::string& note : *list) text += "; " + note;
  return text;
}

bool PhotosAndFilms::is_frame(const std::string& source) const { return !camera_of(source).empty(); }

std::string PhotosAndFilms::camera_of(const std::string& source) const {
  for (const FilmFrameReport& frame : frames)
    if (frame.source == source) return "film " + films[frame.film].source;
  return {};
}

namespace {

// The two passes over all films. A film that fails is left out; its error is kept.
class Cutter {
 public:
  Cutter(const std::vector<FilmFile>& files, const CutRequest& request, PhotosAndFilms& all)
      : files_(files), request_(request), all_(all), films_(files.size()) {}

  void cut() {
    std::error_code ec;
    fs::remove_all(request_.work / "frames", ec);  // of a run that was killed
    for (size_t f = 0; f < files_.size(); ++f) {
      all_.films.push_back({.source = files_[f].source, .notes = {}, .damage = {}, .failure = {}});
      attempt(f, [&] { track(f); });
    }
    choose();
    for (size_t f = 0; f < files_.size(); ++f)
      if (all_.films[f].failure.empty())
        attempt(f, [&] { write_frames(files_[f], f, films_[f], request_, files_.size(), all_); });
    std::erase_if(all_.frames, [&](const FilmFrameReport& frame) { return !all_.films[frame.film].failure.empty(); });
    if (all_.folder.photos.empty() && first_) throw *first_;
  }

 private:
  void fail(size_t f, const Error& e) {
    all_.films[f].failure = e.detail().why.empty() ? e.message() : e.message() + ": " + e.detail().why;
    all_.films[f].chosen = 0;
    if (!first_) first_ = e;
  }
  template <class Body>
  void attempt(size_t f, Body&& body) {
    try {
      body();
    } catch (const Error& e) {
      if (e.kind() != ErrorKind::Input) throw;
      fail(f, e);
    }
  }
  void track(size_t f) {
    films_[f].info = read_film_info(files_[f].path);
    std::string damage;
    films_[f].track = track_film(
        films_[f].info,
        [&](double share) {
          request_.progress(0.5 * (double(f) + share) / double(files_.size()), fmt::format("watching {}", files_[f].source));
        },
        damage);
    all_.films[f] = report_of(files_[f], films_[f], damage);
  }
  void choose() {
    std::vector<std::vector<TrackedFrame>> tracks;
    for (const Film& film : films_) tracks.push_back(film.track);
    const FrameChoice choice = choose_frames(tracks, request_.most_frames);
    all_.least_motion = choice.least_motion;
    for (const ChosenFrame& c : choice.frames) ++all_.films[c.film].chosen;
    for (size_t f = 0; f < files_.size(); ++f) {
      if (all_.films[f].failure.empty() && all_.films[f].chosen < kLeastFrames) fail(f, stands_still(files_[f], films_[f]));
      if (choice.soft[f] > 0)
        all_.films[f].notes.push_back(fmt::format("{} parts have blurred frames only and are left out", choice.soft[f]));
    }
    name_frames(choice, tracks);
  }
  void name_frames(const FrameChoice& choice, const std::vector<std::vector<TrackedFrame>>& tracks) {
    int64_t longest = 0;
    for (const std::vector<TrackedFrame>& track : tracks)
      if (!track.empty()) longest = std::max(longest, milliseconds(track.back()));
    const int digits = std::max(int(std::to_string(longest).size()), 6);
    for (const ChosenFrame& c : choice.frames) {
      if (!all_.films[c.film].failure.empty()) continue;
      const TrackedFrame& t = tracks[c.film][c.frame];
      const std::string name =
          fmt::format("{}_{:0{}}.png", frame_stem(files_[c.film].source, all_.folder), milliseconds(t), digits);
      if (!all_.frames.empty() && all_.frames.back().source == name)
        --all_.films[c.film].chosen;  // in one millisecond
      else
        all_.frames.push_back({name, c.film, t.time, t.sharpness, t.motion, c.among, {}, {}});
    }
  }

  const std::vector<FilmFile>& files_;
  const CutRequest& request_;
  PhotosAndFilms& all_;
  std::vector<Film> films_;
  std::optional<Error> first_;
};

}  // namespace

PhotosAndFilms photos_and_films(const fs::path& given, const CutRequest& request) {
  PhotosAndFilms all;
  all.folder = found_folder(given);
  const std::vector<FilmFile> files = films_to_cut(all.folder);
  if (files.empty() && all.folder.photos.empty()) all.folder = find_photos(given);  // throws
  forget_skipped(all.folder);
  if (files.empty()) return all;
  Cutter(files, request, all).cut();
  std::ranges::sort(all.folder.photos, {}, &PhotoFile::source);
  assign_names(all.folder.photos);
  return all;
}

void write_film_report(const fs::path& folder, const PhotosAndFilms& all) {
  if (all.films.empty()) return;
  nlohmann::json films = nlohmann::json::array(), frames = nlohmann::json::array();
  constexpr int kColumns = 6, kCell = 240;
  ContactSheet sheet(kColumns, kCell);
  size_t shown = all.films.size();
  for (const FilmReport& f : all.films)
    films.push_back({{"source", f.source},
                     {"seconds", f.seconds},
                     {"width", f.width},
                     {"height", f.height},
                     {"frames", f.frames},
                     {"chosen", f.chosen},
                     {"notes", f.notes},
                     {"damage", f.damage},
                     {"failure", f.failure}});
  double before = 0;
  for (const FilmFrameReport& f : all.frames) {
    if (f.film != shown) sheet.start_row(all.films[f.film].sentence() + "; below: time, sharpest of how many, motion");
    if (f.film != shown) before = f.motion;
    shown = f.film;
    sheet.add(fmt::format("{:.2f} s of {} {:+.0f} %", f.time.seconds, f.among, 100 * (f.motion - before)), f.thumbnail);
    before = f.motion;
    frames.push_back({{"photo", f.source},
                      {"film", all.films[f.film].source},
                      {"pts", f.time.pts},
                      {"time_s", f.time.seconds},
                      {"sharpness", f.sharpness},
                      {"motion", f.motion},
                      {"sharpest_of", f.among},
                      {"blur_px_at_800", f.blur_px ? nlohmann::json(*f.blur_px) : nlohmann::json()}});
  }
  write_json_file(folder / "ingest" / "films.json", {{"films", films}, {"frames", frames}, {"least_motion", all.least_motion}});
  sheet.write(folder / "ingest" / "films.jpg");
}

}  // namespace vitrine
