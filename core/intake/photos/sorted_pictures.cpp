#include "core/intake/photos/sorted_pictures.h"

#include <algorithm>
#include <cctype>
#include <optional>
#include <set>

#include "core/foundation/base/file.h"
#include "core/foundation/base/parallel.h"
#include "core/intake/photos/picture_content.h"

namespace vitrine {

namespace fs = std::filesystem;

namespace {

using Parts = std::vector<std::string>;

constexpr size_t kSamples = 5;  // pictures compared to detect a folder of copies

template <class T>
std::vector<T> spread_samples(const std::vector<T>& all) {
  std::vector<T> samples;
  const size_t n = std::min(kSamples, all.size());
  for (size_t k = 0; k < n; ++k) samples.push_back(all[k * all.size() / n]);
  return samples;
}

// Path of a picture in lower case, split into the parts used for matching.
struct Picture {
  Parts folders;
  std::string file, stem;     // "b.jpg", "b"
  size_t role_at = SIZE_MAX;  // index of the outermost folder named like a role, else like a mask class
  std::optional<PictureRole> folder_role;
  bool role_is_class = false;
  std::string stem_as_written;
};

Picture picture_of(const std::string& source) {
  const fs::path path(source);
  Picture p{.folders = {},
            .file = lowered(path.filename().string()),
            .stem = lowered(path.stem().string()),
            .role_at = SIZE_MAX,
            .folder_role = std::nullopt,
            .role_is_class = false,
            .stem_as_written = path.stem().string()};
  for (const fs::path& part : path.parent_path()) p.folders.push_back(lowered(part.string()));
  const auto take = [&](size_t at, PictureRole role, bool is_class) {
    if (p.folder_role) return;
    p.role_at = at;
    p.folder_role = role;
    p.role_is_class = is_class;
  };
  for (size_t k = 0; k < p.folders.size(); ++k)
    if (const auto role = role_of_folder(p.folders[k])) take(k, *role, false);
  for (size_t k = 0; k < p.folders.size(); ++k)
    if (is_class_folder(p.folders[k])) take(k, PictureRole::Mask, true);
  return p;
}

struct Candidate {
  PictureRole role;
  size_t of;
  bool twin = false;    // only the extension differs: "b.png" next to "b.jpg"
  bool of_all = false;  // for all photos in the folder
};

class Partners {
 public:
  explicit Partners(const std::vector<PhotoFile>& files) {
    for (const PhotoFile& file : files) pictures_.push_back(picture_of(file.source));
    for (size_t i = 0; i < pictures_.size(); ++i) {
      by_name_[pictures_[i].file].push_back(i);
      by_name_[pictures_[i].stem].push_back(i);
    }
  }

  const Picture& operator[](size_t i) const { return pictures_[i]; }

  // The photo that the picture may belong to, by its name.
  std::optional<Candidate> candidate(size_t i) const {
    const Picture& p = pictures_[i];
    if (role_of_folder(p.stem) == PictureRole::Mask)  // openMVG: mask.png is for all photos in the folder
      for (size_t k = 0; k < pictures_.size(); ++k)
        if (pictures_[k].folders == p.folders && !role_of_folder(pictures_[k].stem))
          return Candidate{PictureRole::Mask, k, false, true};
    const std::vector<NamedRole> roles = roles_of_stem(p.stem_as_written);
    for (const NamedRole& named : roles)
      for (const std::string& stem : photo_stems_of(named.of))
        if (const auto of = same_folder(i, stem)) return Candidate{named.role, *of, false, false};
    if (p.folder_role) {
      if (const auto of = of_folder(i, p.stem)) return Candidate{*p.folder_role, *of, false, false};
      for (const NamedRole& named : roles)
        if (const auto of = of_folder(i, lowered(named.of))) return Candidate{*p.folder_role, *of, false, false};
    } else if (const auto of = same_folder(i, p.stem)) {
      return Candidate{PictureRole::Mask, *of, true, false};
    }
    return std::nullopt;
  }

 private:
  const std::vector<size_t>& called(const std::string& name) const {
    static const std::vector<size_t> none;
    const auto found = by_name_.find(name);
    return found == by_name_.end() ? none : found->second;
  }

  std::optional<size_t> same_folder(size_t i, const std::string& name) const {
    for (size_t k : called(name))
      if (k != i && pictures_[k].folders == pictures_[i].folders) return k;
    return std::nullopt;
  }

  // For "a/masks/left/b.png": a/left/b.*, a/*/left/b.*, else the only other picture of that name. A class folder may follow
  // "masks".
  std::optional<size_t> of_folder(size_t i, const std::string& name) const {
    const Picture& p = pictures_[i];
    const Parts before(p.folders.begin(), p.folders.begin() + long(p.role_at));
    for (size_t skipped = 0; skipped < 2; ++skipped) {
      if (p.role_at + 1 + skipped > p.folders.size()) break;
      const Parts behind(p.folders.begin() + long(p.role_at + 1 + skipped), p.folders.end());
      for (size_t between = 0; between < 2; ++between)
        for (size_t k : called(name))
          if (may_be_photo(k, i) && matches(pictures_[k].folders, before, between, behind)) return k;
    }
    std::optional<size_t> only;
    for (size_t k : called(name)) {
      if (!may_be_photo(k, i)) continue;
      if (only) return std::nullopt;
      only = k;
    }
    return only;
  }

  // Photos may be in a folder named "object", and masks in another named "ignore".
  bool may_be_photo(size_t k, size_t i) const {
    return k != i && (!pictures_[k].folder_role || pictures_[k].role_is_class) && pictures_[k].folders != pictures_[i].folders;
  }

  static bool matches(const Parts& folders, const Parts& before, size_t between, const Parts& behind) {
    return folders.size() == before.size() + between + behind.size() &&
           std::equal(before.begin(), before.end(), folders.begin()) &&
           std::equal(behind.rbegin(), behind.rend(), folders.rbegin());
  }

  std::vector<Picture> pictures_;
  std::map<std::string, std::vector<size_t>> by_name_;
};

bool content_agrees(const Candidate& c, const fs::path& path, const fs::path& of) {
  switch (c.role) {
    case PictureRole::Mask:
      return looks_like_mask(path, {.both = c.twin, .alpha = true, .quick = !c.twin});
    case PictureRole::Depth:
      return looks_like_depth(path, of);
    case PictureRole::Normals:
      return looks_like_normals(path);
    case PictureRole::Copy:
      return CopyFinder().looks_like_copy(path, of, true);
  }
  return false;
}

// Removes the photos with `out` set.
void drop(std::vector<PhotoFile>& photos, const std::vector<uint8_t>& out) {
  std::vector<PhotoFile> kept;
  for (size_t i = 0; i < photos.size(); ++i)
    if (!out[i]) kept.push_back(std::move(photos[i]));
  photos = std::move(kept);
}

// masks_2/b.png next to masks/b.png is a reduced copy of the mask.
void reduced_masks(std::vector<BesidePhoto>& beside) {
  std::set<std::string> sources;
  for (const BesidePhoto& file : beside) sources.insert(file.source);
  for (BesidePhoto& file : beside) {
    fs::path full;
    for (const fs::path& part : fs::path(file.source).parent_path())
      full /= role_of_folder(part.string()) ? std::string(without_number(part.string())) : part.string();
    full /= fs::path(file.source).filename();
    if (full.generic_string() != file.source && sources.contains(full.generic_string())) {
      file.role = PictureRole::Copy;
      file.of = full.generic_string();
    }
  }
}

void sort_by_role(PhotoFolder& folder) {
  const Partners partners(folder.photos);
  const size_t n = folder.photos.size();
  std::vector<std::optional<Candidate>> candidates(n);
  for (size_t i = 0; i < n; ++i) candidates[i] = partners.candidate(i);
  std::vector<uint8_t> agrees(n, 0);
  const auto judge = [&](const std::vector<size_t>& pictures) {
    parallel_for(pictures.size(), 1, [&](size_t k) {
      const size_t i = pictures[k];
      agrees[i] = content_agrees(*candidates[i], folder.photos[i].path, folder.photos[candidates[i]->of].path);
    });
    return std::any_of(pictures.begin(), pictures.end(), [&](size_t i) { return agrees[i] != 0; });
  };
  std::vector<size_t> named, twins;
  for (size_t i = 0; i < n; ++i)
    if (candidates[i]) (candidates[i]->twin ? twins : named).push_back(i);
  judge(named);
  // Test a few samples first: two hundred photos in two formats are no masks.
  if (judge(spread_samples(twins))) judge(twins);
  // In a folder of masks only, transparent/b.png is no mask of b.png.
  std::vector<size_t> masks;
  for (size_t i = 0; i < n; ++i)
    if (agrees[i] && candidates[i]->role == PictureRole::Mask) masks.push_back(i);
  const auto without_mask_of_mask = [&](const std::vector<size_t>& pictures) {
    std::vector<uint8_t> of_mask(pictures.size(), 0);
    parallel_for(pictures.size(), 1, [&](size_t k) {
      of_mask[k] =
          looks_like_mask(folder.photos[candidates[pictures[k]]->of].path, {.both = false, .alpha = false, .quick = false});
    });
    bool any = false;
    for (size_t k = 0; k < pictures.size(); ++k)
      if (of_mask[k]) {
        agrees[pictures[k]] = 0;
        candidates[pictures[k]].reset();
        any = true;
      }
    return any;
  };
  if (without_mask_of_mask(spread_samples(masks))) {
    std::erase_if(masks, [&](size_t i) { return !agrees[i]; });
    without_mask_of_mask(masks);
  }
  // A mask of a mask (b_mask_small.png) belongs to the photo; two that refer to each other are both photos.
  for (size_t i = 0; i < n; ++i) {
    if (!agrees[i]) continue;
    std::set<size_t> seen{i};
    size_t of = candidates[i]->of;
    while (agrees[of] && seen.insert(of).second) of = candidates[of]->of;
    if (agrees[of])
      agrees[i] = 0;
    else
      candidates[i]->of = of;
  }
  for (size_t i = 0; i < n; ++i) {
    if (!candidates[i]) continue;
    if (agrees[i])
      folder.beside.push_back({folder.photos[i].path, folder.photos[i].source, candidates[i]->role,
                               candidates[i]->of_all ? std::string() : folder.photos[candidates[i]->of].source});
    else if (!candidates[i]->twin && !candidates[i]->of_all && !partners[i].role_is_class &&
             candidates[i]->role != PictureRole::Copy)
      folder.like_photos.push_back(folder.photos[i].source);
  }
  drop(folder.photos, agrees);
  reduced_masks(folder.beside);
}

// --- second sets of the same photos ----------------------------------------------------------------------------------------

// Whether the folder name suggests another version: undistorted photos, or their originals.
bool is_other_version(const std::string& folder) {
  for (const fs::path& part : fs::path(folder)) {
    const std::string low = lowered(part.string());
    if (low == "input" || low == "dense" || low == "distorted" || low.find("undist") != std::string::npos) return true;
  }
  return false;
}

// Lower-case stems of the photos in one folder. For duplicates, the first photo.
using Stems = std::map<std::string, size_t>;

std::vector<std::string> common_stems(const Stems& a, const Stems& b) {
  std::vector<std::string> common;
  for (const auto& entry : a)
    if (b.contains(entry.first)) common.push_back(entry.first);
  return common;
}

void leave_out_second_sets(PhotoFolder& folder) {
  std::map<std::string, Stems> folders;
  for (size_t i = 0; i < folder.photos.size(); ++i) {
    const fs::path source(folder.photos[i].source);
    folders[source.parent_path().generic_string()].try_emplace(lowered(source.stem().string()), i);
  }
  if (folders.size() < 2) return;
  std::vector<uint8_t> out(folder.photos.size(), 0);
  const auto path = [&](size_t i) { return folder.photos[i].path; };
  CopyFinder finder;
  // Whether sampled common photos of `small` are reduced copies (`shrunk`) or other versions of those of `large`.
  const auto is_version = [&](const std::vector<std::string>& common, const Stems& small, const Stems& large, bool shrunk) {
    const std::vector<std::string> samples = spread_samples(common);
    return std::all_of(samples.begin(), samples.end(), [&](const std::string& stem) {
      return finder.looks_like_copy(path(small.at(stem)), path(large.at(stem)), shrunk);
    });
  };
  for (const auto& [small_name, small] : folders)
    for (const auto& [large_name, large] : folders) {
      if (small_name == large_name) continue;
      const std::vector<std::string> common = common_stems(small, large);
      // Only whole folders: one or two photos of the same name are not enough.
      if (common.size() < 2 || 2 * common.size() < small.size()) continue;
      if (out[small.at(common[0])] || out[large.at(common[0])]) continue;
      const bool shrunk = is_version(common, small, large, true);
      const bool other =
          !shrunk && is_other_version(small_name) && !is_other_version(large_name) && is_version(common, small, large, false);
      if (!shrunk && !other) continue;
      for (const std::string& stem : common) {
        const size_t i = small.at(stem);
        out[i] = 1;
        if (shrunk)
          folder.beside.push_back({path(i), folder.photos[i].source, PictureRole::Copy, folder.photos[large.at(stem)].source});
      }
      if (other) folder.second_sets.push_back({.used = large_name, .left_out = small_name, .photos = common.size()});
    }
  // The source of a copy may itself be a copy or left out: follow the chain.
  std::map<std::string, std::string> full;
  for (const BesidePhoto& b : folder.beside)
    if (b.role == PictureRole::Copy) full[b.source] = b.of;
  for (BesidePhoto& b : folder.beside)
    for (auto next = full.find(b.of); next != full.end(); next = full.find(b.of)) b.of = next->second;
  drop(folder.photos, out);
}

}  // namespace

void sort_pictures(PhotoFolder& folder) {
  sort_by_role(folder);
  leave_out_second_sets(folder);
  std::sort(folder.beside.begin(), folder.beside.end(),
            [](const BesidePhoto& a, const BesidePhoto& b) { return a.source < b.source; });
}

}  // namespace vitrine
