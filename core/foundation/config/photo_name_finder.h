// Matching of photo names in user files (poses, mask lists, annotations) to the photos.
//
// All names of a file are matched together. "./", "file://" and '\' (unless a photo name contains one) are normalised first.
// Order of preference:
//   1. the path as written, below the photo folder;
//   2. the longest path suffix ("/home/me/set/images/a.jpg" -> "images/a.jpg" -> "a.jpg");
//   3. for equal suffixes: exact; case-insensitive, accents normalised; without extension ("r_0", "a.jpg.png"); both;
//   4. the folder that matches most names of the file; then the photo whose whole path is a suffix of the name.
// A name that matches nothing is decoded ("a%20b.jpg" -> "a b.jpg") and tried again.
// A name that is still ambiguous is resolved by the folders that belong to the file, if the photo exists there. Otherwise it
// matches nothing, and the candidates are reported.
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
  std::vector<size_t> could_be;       // two or more candidates: the name is ambiguous
  std::optional<size_t> better_name;  // name in the list that matches the same photo better; `photo` is empty then
};

class PhotoNameFinder {
 public:
  explicit PhotoNameFinder(std::span<const std::string> names);
  // Photos with several paths each; `names` are used in messages.
  PhotoNameFinder(std::span<const std::string> names, std::span<const std::vector<std::string>> paths);

  // One entry per name. Several names may match the same photo if they match equally well. `folders`: folder of the file with
  // the names, or where its images should be.
  std::vector<PhotoMatch> match(std::span<const std::string> names, std::span<const std::filesystem::path> folders = {}) const;
  // Matches a single name.
  PhotoMatch match(const std::string& name) const;

  const std::string& name(size_t photo) const { return names_[photo]; }

 private:
  enum Level : size_t { kExact, kFolded, kBare, kFoldedBare, kLevels };
  using Parts = std::vector<std::string>;  // of a path
  struct Alias {
    size_t photo;
    Parts parts[2];  // as written; case-folded
  };
  struct Candidate {
    const Alias* alias;
    size_t common = 0;  // number of trailing path parts that agree
    size_t level = 0;
    size_t votes = 0;  // number of names that this photo folder also matches
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
  std::map<std::string, std::vector<size_t>, std::less<>> by_file_[kLevels];  // file name normalised for the level -> aliases
  bool keep_backslashes_ = false;
};

// Lower case with composed accents (NFC): macOS stores decomposed accents.
std::string folded_name(const std::string& text);
// Candidates of an ambiguous name as text: "front/0.jpg or back/0.jpg".
std::string listed(const PhotoNameFinder& finder, const std::vector<size_t>& photos);

}  // namespace vitrine
