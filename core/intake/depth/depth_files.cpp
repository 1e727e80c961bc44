#include "core/intake/depth/depth_files.h"

#include <algorithm>
#include <set>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/folder_files.h"
#include "core/foundation/config/json_file.h"
#include "core/foundation/config/photo_name_finder.h"
#include "core/intake/photos/named_file.h"
#include "core/intake/photos/photo_files.h"

namespace vitrine {

namespace {

constexpr std::string_view kExtensions[] = {".exr", ".tif", ".tiff", ".png"};  // the most precise first

std::optional<int> rank_of(const fs::path& file) {
  const auto found = std::ranges::find(kExtensions, lowered(file.extension().string()));
  return found == std::end(kExtensions) ? std::nullopt : std::optional(int(found - std::begin(kExtensions)));
}

std::string stem_key(const fs::path& photo) { return lowered(fs::path(photo).replace_extension().generic_string()); }
std::string file_key(const fs::path& photo) { return stem_key(photo.filename()); }

std::string joined(const fs::path& folder, const std::string& base) { return lowered((folder / base).generic_string()); }

// Maps in a folder of photos, found by name and content -> their photos.
std::map<std::string, std::string> depth_among_photos(const fs::path& folder) {
  std::map<std::string, std::string> maps;
  for (const BesidePhoto& file : companions_in(folder))
    if (file.role == PictureRole::Depth && !file.of.empty()) maps[file.source] = file.of;
  return maps;
}

[[noreturn]] void throw_missing(const fs::path& path, std::string why) {
  throw Error(ErrorKind::Input, "there are no depth maps",
              {.where = path.string(),
               .why = std::move(why),
               .hint = "give a folder of PNG, TIFF or EXR files named like the photos, or a transforms.json with depth_file_path",
               .code = "DEPTH_MISSING"});
}

// "depth/left/b.png" -> "left": without folders that only name the role.
fs::path without_role_folders(const fs::path& folder) {
  fs::path out;
  for (const fs::path& part : folder)
    if (role_of_folder(part.string()) != PictureRole::Depth) out /= part;
  return out;
}

}  // namespace

DepthFolder::DepthFolder(const fs::path& path) : path_(path) {
  std::error_code ec;
  if (fs::is_regular_file(path, ec)) {
    if (rank_of(path)) throw_missing(path, "this is one picture");
    add_transforms(path);
    if (listed_.empty()) throw_missing(path, "no frame has a depth_file_path");
    return;
  }
  if (!fs::is_directory(path, ec)) throw_missing(path, "there is no such folder");
  if (fs::is_regular_file(path / "transforms.json", ec)) add_transforms(path / "transforms.json");
  if (listed_.empty()) add_folder();
}

void DepthFolder::add_folder() {
  std::error_code ec;
  const FolderFiles listed = files_below(path_, ReachedTwice::Once, ec);
  if (ec || !listed.unreadable.empty())
    throw_missing(ec ? path_ : path_ / listed.unreadable[0], ec ? ec.message() : "it cannot be opened");
  const std::map<std::string, std::string> photo_of = depth_among_photos(path_);
  size_t arrays = 0;
  for (const fs::path& name : listed.files) {
    const std::string extension = lowered(name.extension().string());
    arrays += extension == ".npy" || extension == ".npz" || extension == ".bin" || extension == ".pfm";
    if (!rank_of(name)) continue;
    const auto photo = photo_of.find(name.generic_string());
    if (!photo_of.empty() && photo == photo_of.end()) continue;  // the photos themselves
    add(path_ / name, photo == photo_of.end() ? name : fs::path(photo->second));
  }
  if (files_ == 0)
    throw_missing(path_, arrays > 0 ? fmt::format("{} files are arrays (npy, npz, bin, pfm), which are not read", arrays)
                                    : std::string("it holds no PNG, TIFF or EXR file"));
}

void DepthFolder::add(const fs::path& file, const fs::path& relative) {
  ++files_;
  const fs::path folder = without_role_folders(relative.parent_path());
  const std::string base = relative.stem().string();
  std::string of = base;
  bool word = false;
  for (const NamedRole& role : roles_of_stem(base))
    if (role.role == PictureRole::Depth) {
      of = role.of, word = true;
      break;
    }
  const Candidate candidate{file, 2 * rank_of(file).value() + (word ? 0 : 1)};
  std::set<std::string> stems{lowered(base), lowered(of)};
  if (has_photo_extension(of)) stems.insert(stem_key(of));  // b.jpg.png
  for (const std::string& stem : stems) {
    by_path_[joined(folder, stem)].push_back(candidate);
    by_name_[stem].push_back(candidate);
  }
  const StemKey key = key_of_stem(base);
  if (!key.rest.empty() && key.role.value_or(PictureRole::Depth) == PictureRole::Depth) by_words_[key.rest].push_back(candidate);
}

void DepthFolder::add_transforms(const fs::path& json) {
  size_t named = 0;
  std::string missing;
  read_json_file(json, "transforms.json", [&](const nlohmann::json& j) {
    const JsonAt top(j);
    if (!top.has("frames")) return;
    for (const char* unit : {"integer_depth_scale", "depth_unit_scale_factor"})
      if (top.has(unit)) {
        unit_ = top.at(unit).number();
        if (!(unit_ > 0)) top.at(unit).fail("expected a positive number");
      }
    const JsonAt frames = top.at("frames");
    frames.list("a list of frames");
    for (size_t i = 0; i < frames.size(); ++i) {
      const char* key = frames[i].has("depth_file_path") ? "depth_file_path" : "depth_path";
      if (!frames[i].has(key)) continue;
      ++named;
      const JsonAt written = frames[i].at(key);
      if (const auto file = named_file(json.parent_path(), written)) {
        listed_photos_.push_back(frames[i].at("file_path").text());
        listed_.push_back(*file);
      } else if (missing.empty()) {
        missing = written.text();
      }
    }
  });
  files_ = listed_.size();
  lists_ = {json.parent_path()};
  if (listed_.empty() && named > 0)
    throw_missing(json, fmt::format("{} depth maps are named and do not exist, for example '{}'", named, missing));
}

std::vector<std::optional<fs::path>> DepthFolder::match(std::span<const std::string> photos) const {
  std::vector<std::optional<fs::path>> found(photos.size());
  const std::vector<PhotoMatch> matches = PhotoNameFinder(photos).match(listed_photos_, lists_);
  for (size_t i = 0; i < matches.size(); ++i)
    if (const auto photo = matches[i].photo; photo && !found[*photo]) found[*photo] = listed_[i];
  const auto best = [&](const Index& index, const std::string& key, const std::string& photo) -> std::optional<fs::path> {
    const auto at = index.find(key);
    if (at == index.end()) return std::nullopt;
    const auto& first = *std::ranges::min_element(at->second, {}, &Candidate::rank);
    for (const Candidate& other : at->second)
      if (other.rank == first.rank && other.path != first.path)
        throw Error(ErrorKind::Input, "two files claim to be the depth map of one photo",
                    {.where = photo,
                     .why = fmt::format("{} and {}", first.path.string(), other.path.string()),
                     .hint = "remove or rename one of them",
                     .code = "DEPTH_AMBIGUOUS"});
    return first.path;
  };
  for (size_t i = 0; i < photos.size(); ++i) {
    const fs::path photo = photos[i];
    if (!found[i]) found[i] = best(by_path_, stem_key(photo), photos[i]);
    if (!found[i]) found[i] = best(by_name_, file_key(photo), photos[i]);
    if (!found[i]) found[i] = best(by_words_, key_of_stem(photo.stem().string()).rest, photos[i]);
  }
  if (!photos.empty() && std::ranges::none_of(found, [](const auto& f) { return f.has_value(); }))
    throw Error(ErrorKind::Input, "no photo has a depth map",
                {.where = path_.string(),
                 .why = fmt::format("{} file{} there; none is called like a photo, for example {}", files_,
                                    files_ == 1 ? "" : "s", photos.front()),
                 .hint = fmt::format("call them {}", fs::path(photos.front()).replace_extension(".png").string()),
                 .code = "DEPTH_MATCHES_NO_PHOTO"});
  return found;
}

std::vector<fs::path> files_of_depth_list(const fs::path& depth) {
  std::error_code ec;
  if (!fs::is_regular_file(depth, ec)) return {};
  try {
    const DepthFolder folder(depth);
    std::set<fs::path> files(folder.listed().begin(), folder.listed().end());
    return {files.begin(), files.end()};
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Input) throw;
    return {};
  }
}

std::vector<std::string> check_depth_names(const fs::path& depth, const std::vector<std::string>& photos) {
  const DepthFolder folder(depth);
  const auto found = folder.match(photos);
  for (const auto& file : found)
    if (file) {
      read_depth(*file, folder.unit());  // a wrong kind of file is most often wrong in all
      break;
    }
  const auto without = std::count(found.begin(), found.end(), std::nullopt);
  if (without == 0) return {};
  return {fmt::format("{} of {} photos have no depth map", without, photos.size())};
}

}  // namespace vitrine
