#include "core/intake/poses/named_poses.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/intake/masks/mask_files.h"
#include "core/intake/poses/colmap_repair.h"
#include "core/intake/poses/pose_files.h"
#include "core/intake/poses/program_poses.h"
#include "core/scene/camera/transforms_file.h"

namespace vitrine {

namespace {

// Content of a pose file, and the photos matched to its names.
struct Reading {
  PoseFile file;
  ColmapModel model;          // of all but a transforms.json
  TransformsFile transforms;  // of a transforms.json
  std::vector<std::string> names, places;
  std::vector<PhotoMatch> matches;
  Notes notes;
  size_t photos = 0;     // with a pose
  size_t same_size = 0;  // photos of exactly the size in the file
};

std::string shown(const Reading& r, size_t i) { return fmt::format("{} '{}'", r.places[i], r.names[i]); }

// Notes a text model that is newer than the binary files next to it and differs: users convert COLMAP's files to text to edit
// them, but the binary files are read.
void note_other_format(Reading& r) {
  const fs::path &folder = r.file.path, binary = folder / "images.bin";
  std::error_code ec;
  for (const char* part : {"cameras", "images", "points3D"})
    for (const char* extension : {".bin", ".txt"})
      if (!fs::exists(folder / (std::string(part) + extension), ec)) return;
  const auto written = fs::last_write_time(binary, ec);
  if (fs::last_write_time(folder / "images.txt", ec) <= written && fs::last_write_time(folder / "points3D.txt", ec) <= written)
    return;
  std::string difference = "cannot be read";
  try {
    const ColmapModel text = read_colmap_parts(folder, ColmapFormat::Text);
    if (text.images.size() == r.model.images.size() && text.points.size() == r.model.points.size()) return;
    difference = fmt::format("hold {} images and {} points", text.images.size(), text.points.size());
  } catch (const Error&) {
  }
  r.notes.push_back(
      {"POSES_TEXT_NOT_READ",
       fmt::format("{} holds a model twice: the .bin files are read ({} images, {} points); the .txt files are newer and "
                   "{}: to use them, remove the .bin files",
                   folder.string(), r.model.images.size(), r.model.points.size(), difference)});
}

ProgramPoses program_poses(const PoseFile& file) {
  switch (file.kind) {
    case PoseFile::Kind::Metashape:
      return read_metashape(file.path);
    case PoseFile::Kind::OpenSfm:
      return read_opensfm(file.path);
    case PoseFile::Kind::OpenMvg:
      return read_openmvg(file.path);
    case PoseFile::Kind::Colmap:
    case PoseFile::Kind::Transforms:
    case PoseFile::Kind::Matrices:
      break;
  }
  VITRINE_CHECK(false, "no poses of another program");
  return {};
}

Reading reading_of(const PoseFile& file, const PhotoFinder& finder, std::span<const Photo> photos) {
  Reading r;
  r.file = file;
  std::vector<std::optional<PictureSize>> sizes;
  if (file.kind == PoseFile::Kind::Colmap) {
    r.model = read_colmap_parts(file.path);
    note_other_format(r);
    const ColmapRepairs repairs = drop_dangling_references(r.model);
    if (repairs.count() > 0)
      r.notes.push_back(
          {"POSES_DANGLING", fmt::format("{}: {}; these references are dropped", file.path.string(), repairs.text())});
    check_colmap_model(r.model, file.path, ColmapNames::Any);
    for (const ColmapImage& image : r.model.images) r.places.push_back(fmt::format("image {}", image.id));
  } else if (file.kind != PoseFile::Kind::Transforms) {
    ProgramPoses poses = program_poses(file);
    r.model = std::move(poses.model);
    r.places = std::move(poses.places);
    r.notes = std::move(poses.notes);
    check_colmap_model(r.model, file.path, ColmapNames::Any);
  } else {
    r.transforms = read_transforms_file(file.path);
    std::string parts = file.path.filename().string();
    for (const fs::path& part : file.joined) {
      const std::string name = part.filename().string();
      parts += (part == file.joined.back() ? " and " : ", ") + name;
      TransformsFile more = read_transforms_file(part);
      r.transforms.masks += more.masks;
      for (TransformsFrame& frame : more.frames) {
        frame.place = name + ": " + frame.place;
        r.transforms.frames.push_back(std::move(frame));
      }
    }
    if (!file.joined.empty())
      r.notes.push_back({"", fmt::format("the {} poses of {} are joined", r.transforms.frames.size(), parts)});
    for (const TransformsFrame& frame : r.transforms.frames) {
      r.names.push_back(frame.name);
      r.places.push_back(frame.place);
      sizes.push_back(frame.camera.size);
    }
  }
  for (const ColmapImage& image : r.model.images) {
    r.names.push_back(image.name);
    const ColmapCamera& camera = *r.model.find_camera(image.camera_id);
    sizes.push_back(PictureSize{int(camera.width), int(camera.height)});
  }
  r.matches = finder.match(r.names, picture_folders(file));
  std::set<size_t> taken;
  for (size_t i = 0; i < r.names.size(); ++i)
    if (const auto photo = r.matches[i].photo; photo && taken.insert(*photo).second)
      r.same_size += sizes[i] == PictureSize{photos[*photo].original_width, photos[*photo].original_height};
  r.photos = taken.size();
  return r;
}

Reading best_reading(std::span<const PoseFile> files, const PhotoFinder& finder, std::span<const Photo> photos) {
  std::vector<Reading> readings;
  Notes unreadable;
  std::exception_ptr first_failure;
  for (const PoseFile& file : files) try {
      readings.push_back(reading_of(file, finder, photos));
    } catch (const Error& e) {
      if (e.kind() != ErrorKind::Input || files.size() == 1) throw;
      if (!first_failure) first_failure = std::current_exception();
      if (!file.joined.empty()) continue;  // its parts are named
      unreadable.push_back({"POSES_OTHERS_UNREADABLE", fmt::format("{} cannot be read: {}", file.path.string(), e.detail().why)});
    }
  if (readings.empty()) std::rethrow_exception(first_failure);
  const auto best = std::max_element(readings.begin(), readings.end(), [](const Reading& a, const Reading& b) {
    return std::tuple(a.photos, a.same_size) < std::tuple(b.photos, b.same_size);  // the first on a tie
  });
  if (best->photos < 2 && first_failure) std::rethrow_exception(first_failure);  // the unreadable file may be the intended one
  Reading out = std::move(*best);
  readings.erase(best);
  std::string others, other_formats;
  const auto read_with = [&](const Reading& r) {  // parts and their union are no other set of poses
    const auto& parts = out.file.joined;
    return !r.file.joined.empty() || (!parts.empty() && r.file.path == out.file.path) ||
           std::ranges::find(parts, r.file.path) != parts.end();
  };
  for (const Reading& r : readings) {
    if (read_with(r)) continue;
    // A transforms.json next to a COLMAP model is usually the same poses in another format.
    std::string& list = r.file.kind == out.file.kind ? others : other_formats;
    list += fmt::format("{}{} ({} poses, of {} of these photos)", list.empty() ? "" : ", ", r.file.path.string(), r.names.size(),
                        r.photos);
  }
  const std::string read =
      fmt::format("{} is read ({} poses, of {} of these photos)", out.file.path.string(), out.names.size(), out.photos);
  if (!others.empty())
    out.notes.push_back({"POSES_SEVERAL", fmt::format("there are several sets of poses: {}; not read: {}", read, others)});
  if (!other_formats.empty()) out.notes.push_back({"", fmt::format("{}; not read: {}", read, other_formats)});
  out.notes.insert(out.notes.end(), unreadable.begin(), unreadable.end());
  return out;
}

[[noreturn]] void throw_no_match(const Reading& r, std::span<const Photo> photos, const PhotoFinder& finder) {
  std::string why = fmt::format("{} of {} photos have a pose of their name", r.photos, photos.size());
  const auto ambiguous =
      std::find_if(r.matches.begin(), r.matches.end(), [](const PhotoMatch& m) { return !m.could_be.empty(); });
  std::string hint = "names in the poses must be names of photos";
  if (ambiguous != r.matches.end()) {
    why += fmt::format(": '{}' may be {}", r.names[size_t(ambiguous - r.matches.begin())], listed(finder, ambiguous->could_be));
    hint = "give the folder of the photos that have the poses, or write paths into the poses that distinguish these photos";
  } else if (!r.names.empty() && !photos.empty()) {
    size_t example = 0;
    while (example + 1 < r.names.size() && r.matches[example].photo) ++example;
    why += fmt::format(": the poses name '{}', the photos are called '{}'", r.names[example], photos.front().source);
  }
  for (const Note& note : r.notes)
    if (note.code == "POSES_DANGLING") why += "; " + note.text;
  throw Error(ErrorKind::Input, "the given poses do not belong to these photos",
              {.where = r.file.path.string(), .why = why, .hint = hint, .code = "POSES_DO_NOT_MATCH"});
}

void note_left_out(Reading& r, const PhotoFinder& finder) {
  size_t unknown = 0, ambiguous = 0, worse = 0;
  std::string unknown_name, ambiguous_name, worse_name;
  for (size_t i = 0; i < r.names.size(); ++i) {
    const PhotoMatch& m = r.matches[i];
    if (m.photo) continue;
    if (!m.could_be.empty()) {
      if (ambiguous++ == 0) ambiguous_name = fmt::format("'{}' may be {}", r.names[i], listed(finder, m.could_be));
    } else if (m.better_name) {
      if (worse++ == 0) worse_name = fmt::format("'{}' beside '{}'", r.names[i], r.names[*m.better_name]);
    } else if (unknown++ == 0) {
      unknown_name = r.names[i];
    }
  }
  const size_t n = r.names.size();
  if (unknown > 0)
    r.notes.push_back({"POSES_WITHOUT_PHOTO", fmt::format("{} of {} poses are left out: there is no such photo, for example '{}'",
                                                          unknown, n, unknown_name)});
  if (ambiguous > 0)
    r.notes.push_back({"POSES_AMBIGUOUS", fmt::format("{} of {} poses are left out: their names may mean several photos, for "
                                                      "example {}",
                                                      ambiguous, n, ambiguous_name)});
  if (worse > 0)
    r.notes.push_back({"POSES_WITHOUT_PHOTO", fmt::format("{} of {} poses are left out: another name fits the photo better, for "
                                                          "example {}",
                                                          worse, n, worse_name)});
}

bool same_pose(const Rigid& a, const Rigid& b) {
  constexpr double kSame = 1e-9;
  double most = length(a.translation - b.translation) / (1 + length(a.translation));
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j) most = std::max(most, std::abs(a.rotation(i, j) - b.rotation(i, j)));
  return most < kSame;
}

// Indices of the names in use: the first of several for one photo, if their poses are equal.
std::vector<size_t> used_names(Reading& r, const PhotoFinder& finder) {
  const auto pose = [&](size_t i) {
    return r.file.kind == PoseFile::Kind::Transforms ? r.transforms.frames[i].cam_from_world : r.model.images[i].cam_from_world();
  };
  std::vector<size_t> used;
  std::map<size_t, size_t> first;  // photo -> name index
  size_t again = 0;
  std::string example;
  for (size_t i = 0; i < r.names.size(); ++i) {
    if (!r.matches[i].photo) continue;
    const auto [at, fresh] = first.emplace(*r.matches[i].photo, i);
    if (fresh) {
      used.push_back(i);
    } else if (same_pose(pose(i), pose(at->second))) {
      if (again++ == 0) example = fmt::format("{} and {}", shown(r, at->second), shown(r, i));
    } else {
      throw Error(
          ErrorKind::Input, "two poses are of one photo",
          {.where = r.file.path.string(),
           .why = fmt::format("{} and {} differ, and both mean the photo {}", shown(r, at->second), shown(r, i),
                              finder.name(at->first)),
           .hint = r.names[i] == r.names[at->second]
                       ? "remove one of them, or correct its name"
                       : "give the folder above these photos, so that their folders distinguish them; or remove one of them",
           .code = "POSES_TWICE"});
    }
  }
  if (again > 0)
    r.notes.push_back({"POSES_TWICE", fmt::format("{} of {} poses repeat another one of the same photo, and do not count: {}",
                                                  again, r.names.size(), example)});
  return used;
}

ColmapModel posed_by_model(Reading& r, const std::vector<size_t>& used, std::span<const Photo> photos) {
  ColmapModel model = std::move(r.model);
  const size_t without_track = static_cast<size_t>(
      std::count_if(model.points.begin(), model.points.end(), [](const ColmapPoint3D& p) { return p.track.size() < 2; }));
  if (without_track > 0)
    r.notes.push_back({"POSES_POINTS_WITHOUT_TRACK",
                       fmt::format("{} of the {} points of {} are left out: no two photos are named that see them", without_track,
                                   model.points.size(), r.file.path.string())});
  std::vector<ColmapImage> images;
  for (size_t i : used) {
    images.push_back(std::move(model.images[i]));
    images.back().name = photos[*r.matches[i].photo].name;
  }
  model.images = std::move(images);
  return model;
}

// Size of a picture for which the file has none: the photo's size. If the principal point is far from its middle, the photo's
// size times an integer or its inverse.
PictureSize assumed_size(const TransformsFrame& frame, const Photo& photo, size_t& resized) {
  const PictureSize own{photo.original_width, photo.original_height};
  if (!frame.camera.cx || !frame.camera.cy) return own;
  const auto off = [&](double scale) {
    return std::max(std::abs(*frame.camera.cx / (scale * own.width) - 0.5),
                    std::abs(*frame.camera.cy / (scale * own.height) - 0.5));
  };
  constexpr double kFar = 0.2, kNear = 0.08;
  if (off(1) < kFar) return own;
  for (double scale : {2.0, 4.0, 8.0, 3.0, 0.5, 0.25, 0.125})
    if (off(scale) < kNear) {
      ++resized;
      return {int(std::lround(scale * own.width)), int(std::lround(scale * own.height))};
    }
  return own;
}

// Masks that the frames name are not read with the poses: one class of masks changes the whole scene.
void note_masks(Reading& r) {
  if (r.transforms.masks == 0) return;
  size_t there = files_of_mask_list(r.file.path).size();
  for (const fs::path& part : r.file.joined) there += files_of_mask_list(part).size();
  const fs::path given = r.file.joined.empty() ? r.file.path : r.file.path.parent_path();  // a folder stands for all of its lists
  const std::string named =
      fmt::format("{} {} a mask (mask_path)", r.transforms.masks, r.transforms.masks == 1 ? "pose names" : "poses name");
  r.notes.push_back({std::string(kMasksNamed),
                     there == 0 ? named + ", and there are no such files"
                                : fmt::format("{}; the masks are not used: --masks {} uses them as masks of the object", named,
                                              given.string())});
}

ColmapModel posed_by_transforms(Reading& r, const std::vector<size_t>& used, std::span<const Photo> photos) {
  ColmapModel model;
  size_t from_exif = 0, resized = 0;
  for (size_t i : used) {
    const TransformsFrame& frame = r.transforms.frames[i];
    const Photo& photo = photos[*r.matches[i].photo];
    const PictureSize size = frame.camera.size ? *frame.camera.size : assumed_size(frame, photo, resized);
    std::optional<double> focal;
    if (!frame.camera.has_focal_length()) {
      if (!photo.focal_px)
        throw Error(ErrorKind::Input, "the poses have no focal length",
                    {.where = r.file.path.string(),
                     .why = fmt::format("{} has neither fl_x nor camera_angle_x, and the photo {} names none in its EXIF data",
                                        shown(r, i), photo.name),
                     .hint = "`ns-export cameras` writes poses alone: give the transforms.json of the data set; or add fl_x, in "
                             "pixels, to the frames",
                     .code = "POSES_NO_FOCAL"});
      focal = *photo.focal_px * double(std::max(size.width, size.height)) / double(std::max(photo.width, photo.height));
      ++from_exif;
    }
    ColmapCamera camera = frame.camera.camera(size, focal);
    const auto same =
        std::find_if(model.cameras.begin(), model.cameras.end(), [&](ColmapCamera c) { return c.id = 0, c == camera; });
    camera.id = static_cast<uint32_t>(same - model.cameras.begin()) + 1;
    const uint32_t camera_id = camera.id;
    if (same == model.cameras.end()) model.cameras.push_back(std::move(camera));
    model.images.push_back({.id = static_cast<uint32_t>(i) + 1,
                            .rotation = quaternion(frame.cam_from_world.rotation),
                            .translation = frame.cam_from_world.translation,
                            .camera_id = camera_id,
                            .name = photo.name,
                            .points = {}});
  }
  if (from_exif > 0)
    r.notes.push_back(
        {"POSES_FOCAL_FROM_EXIF", fmt::format("{} poses come without a focal length: that of the photo's EXIF data is "
                                              "used, which may be some percent off",
                                              from_exif)});
  if (resized > 0)
    r.notes.push_back(
        {"POSES_SIZE_ASSUMED",
         fmt::format("w and h are missing, and the principal point of {} poses lies far from the middle of its photo: "
                     "they are taken for poses of the photo in another size",
                     resized)});
  if (!r.transforms.points.empty())
    r.notes.push_back(
        {"", fmt::format("the points of {} (ply_file_path) are not read: points are found in the photos", r.transforms.points)});
  note_masks(r);
  return model;
}

std::vector<size_t> versions_without_pose(const Reading& r, std::span<const Photo> photos) {
  const std::vector<size_t> first = first_versions(photos);
  std::set<size_t> posed, posed_versions;
  for (const PhotoMatch& m : r.matches)
    if (m.photo) posed.insert(*m.photo), posed_versions.insert(first[*m.photo]);
  std::vector<size_t> out;
  for (size_t i = 0; i < photos.size(); ++i)
    if (!posed.contains(i) && posed_versions.contains(first[i])) out.push_back(i);
  return out;
}

}  // namespace

NamedPoses named_poses(std::span<const PoseFile> files, std::span<const Photo> photos) {
  const PhotoFinder finder(photos);
  Reading r = best_reading(files, finder, photos);
  if (r.photos < 2) throw_no_match(r, photos, finder);
  note_left_out(r, finder);
  const std::vector<size_t> used = used_names(r, finder);
  NamedPoses out;
  out.file = r.file;
  out.versions = versions_without_pose(r, photos);
  out.model = r.file.kind == PoseFile::Kind::Transforms ? posed_by_transforms(r, used, photos) : posed_by_model(r, used, photos);
  if (!out.versions.empty())
    r.notes.push_back(
        {"POSES_OTHER_VERSIONS", fmt::format("{} photos are left out, for example {}: they have no pose, and are other "
                                             "versions of photos that have one",
                                             out.versions.size(), photos[out.versions.front()].name)});
  out.notes = std::move(r.notes);
  return out;
}

}  // namespace vitrine
