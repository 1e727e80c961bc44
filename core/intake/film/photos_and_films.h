// The photos of a run, where films are given: a film alone, or a folder with photos and films. Films are cut into frames, which
// take the place of photos. A film of up to five seconds with the name of a photo next to it is a Live Photo and left out.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/intake/film/frame_choice.h"
#include "core/intake/photos/photo_files.h"

namespace vitrine {

struct FilmReport {
  std::string source;  // below the given folder
  double seconds = 0;
  int width = 0, height = 0;  // upright
  size_t frames = 0, chosen = 0;
  std::vector<std::string> notes;   // assumptions, parts without a sharp frame
  std::vector<std::string> damage;  // frames that cannot be decoded
  std::string failure;              // why none of its frames is used; empty otherwise
  std::string sentence() const;     // "walk.mp4: 60.1 s, 1920 x 1080: 96 of 1803 frames are used"
};

struct FilmFrameReport {
  std::string source;  // of the frame, as in PhotoFile: "walk_004100.png", at 4.100 s
  size_t film = 0;     // index
  FrameTime time;
  double sharpness = 0, motion = 0;  // core/intake/film/film_track.h
  size_t among = 1;                  // number of frames of which it is the sharpest
  std::optional<double> blur_px;     // at a longest side of at most 800 pixels
  Image8 thumbnail;
};

struct CutRequest {
  size_t most_frames = 120;    // of all films
  std::filesystem::path work;  // frames are written here, below `frames`
  std::function<void(double fraction, const std::string& text)> progress;
};

struct PhotosAndFilms {
  PhotoFolder folder;                   // with the frames among the photos
  std::vector<FilmReport> films;        // empty: there are only photos
  std::vector<FilmFrameReport> frames;  // by film, then time
  double least_motion = 0;

  bool is_frame(const std::string& source) const;
  // Name of the camera of a photo or frame for photos.json; empty if it is no frame: frames of one film share one camera.
  std::string camera_of(const std::string& source) const;
};

// Throws Error{Input}: as find_photos; without any photo or usable film with the code BAD_FILM, FILM_STANDS_STILL or FILM_BLURRED
// of the first film. Error{Dependency} with the code NO_FFMPEG.
PhotosAndFilms photos_and_films(const std::filesystem::path& given, const CutRequest& request);

// ingest/films.json and ingest/films.jpg, a contact sheet of the frames: time, of how many it is the sharpest, motion of the
// picture since the frame before. Nothing if there are no films.
void write_film_report(const std::filesystem::path& folder, const PhotosAndFilms& all);

}  // namespace vitrine
