// Which photo a name means that stands in somebody's file: a pose, a mask that a list names, a mark. The one place that decides
// it.
//
// All names of a file are matched together. In this order:
//   1. the path as written, below the photo folder;
//   2. the longest end of the path ("/home/me/set/images/a.jpg" -> "images/a.jpg" -> "a.jpg");
//   3. of equally long ends the one that is so as written, then without letter case (and whatever way accents are composed), then
//      without extension ("r_0", "a.jpg.png"), then without both;
//   4. the one that puts most names of the file into the same folder; then the photo whose whole path the name ends with.
// A name that still may mean several photos is tried in the folders that belong to the file, if such a file is there. Otherwise
// it decides nothing, and the photos are named. Before that, "./", "file://" and '\' (unless a photo has one in its name) are
// understood.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

namespace vitrine {

struct PhotoMatch {
  std::optional<size_t> photo;
  std::vector<size_t> could_be;       // two or more: the name is ambiguous
  std::optional<size_t> better_name;  // of the list: it fits the photo that this name also ends like; `photo` is empty then
};

class PhotoNameFinder {
 public:
  explicit PhotoNameFinder(std::span<const std::string> names);
  // Photos that have several paths; `names` are what messages call them.
  PhotoNameFinder(std::span<const std::string> names, std::span<const std::vector<std::string>> paths);

  // One entry per name. Names may mean the same photo when they fit it equally well. `folders`: where the file that has the names
  // lies, or where the pictures that it was made with should lie.
  std::vector<PhotoMatch> match(std::span<const std::string> names, std::span<const std::filesystem::path> folders = {}) const;
  // A name by itself.
  PhotoMatch match(const std::string& name) const;

  const std::string& name(size_t photo) const { return names_[photo]; }

 private:
  enum Level : size_t { kExact, kFolded, kBare, kFoldedBare, kLevels };
  using Parts = std::vector<std::string>;  // of a path
  struct Alias {
    size_t photo;
    Parts parts[2];  // as written; folded
  };
  struct Candidate {
    const Alias* alias;
    size_t common = 0;  // last parts of both paths that agree
    size_t level = 0;
    size_t votes = 0;  // names that this folder of the photos suits as well
    bool exact = false, whole = false;
    auto path_rank() const { return std::tuple(exact, common, kLevels - level); }
    auto rank() const { return std::tuple(path_rank(), votes, whole); }
  };
  struct Query;

  void add(size_t photo, const std::string& path);
  void index();
  Parts parts_of(std::string name) const;
  std::vector<Candidate> candidates(const Query& query, size_t level) const;
  void decide(std::vector<Query>& queries) const;

  std::vector<std::string> names_;
  std::vector<Alias> aliases_;
  std::map<std::string, std::vector<size_t>, std::less<>> by_file_[kLevels];  // file name as the level has it -> aliases
  bool keep_backslashes_ = false;
};

// Without letter case, accents composed: macOS writes e and an accent where others write one letter.
std::string folded_name(const std::string& text);
// "front/0.jpg or back/0.jpg": photos that an ambiguous name could mean.
std::string listed(const PhotoNameFinder& finder, const std::vector<size_t>& photos);

}  // namespace vitrine
