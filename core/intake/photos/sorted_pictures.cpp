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

// Path of a picture in lower case, split into the parts used for matching.
struct Picture {
  Parts folders;
  std::string file, stem;     // "b.jpg", "b"
  size_t role_at = SIZE_MAX;  // index of the outermost folder named like a role, else like a mask class
  std::optional<PictureRole> folder_role;
  bool role_is_class = false;
  std::string stem_as_written;
  StemKey key;
};

Picture picture_of(const std::string& source) {
  const fs::path path(source);
  Picture p{.folders = {},
            .file = lowered(path.filename().string()),
            .stem = lowered(path.stem().string()),
            .role_at = SIZE_MAX,
            .folder_role = std::nullopt,
            .role_is_class = false,
            .stem_as_written = path.stem().string(),
            .key = key_of_stem(path.stem().string())};
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
  bool twin = false;     // only the extension differs: "b.png" next to "b.jpg"
  bool of_all = false;   // for all photos in the folder
  bool by_key = false;   // found by numbers and words alone: a photo may be called so
  bool version = false;  // no word names its role
};

class Partners {
 public:
  explicit Partners(const std::vector<PhotoFile>& files) {
    for (const PhotoFile& file : files) pictures_.push_back(picture_of(file.source));
    for (size_t i = 0; i < pictures_.size(); ++i) {
      by_name_[pictures_[i].file].push_back(i);
      by_name_[pictures_[i].stem].push_back(i);
      if (!is_plain(i)) continue;
      by_rest_[pictures_[i].key.rest].push_back(i);
      if (!pictures_[i].key.number.empty()) by_number_[pictures_[i].key.number].push_back(i);
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
    return by_key(i);
  }

  // The photo whose stem this one begins with: "b-removebg-preview.png", "b copy.png". Only a cut-out may belong to it so.
  std::optional<Candidate> version_of(size_t i) const {
    const std::string& stem = pictures_[i].stem;
    for (size_t size = stem.size() - 1; size > 0; --size) {
      if (std::isalnum(static_cast<unsigned char>(stem[size]))) continue;
      if (const auto of = same_folder(i, stem.substr(0, size)))
        return Candidate{PictureRole::Cutout, *of, false, false, true, true};
    }
    return std::nullopt;
  }

 private:
  // Neither its name nor its folder names a role.
  bool is_plain(size_t i) const { return !pictures_[i].key.role && (!pictures_[i].folder_role || pictures_[i].role_is_class); }

  std::optional<Candidate> by_key(size_t i) const {
    const Picture& p = pictures_[i];
    const bool in_folder = p.folder_role && !p.role_is_class;
    const std::optional<PictureRole> role = in_folder ? p.folder_role : p.key.role;
    if (!role || *role == PictureRole::Copy) return std::nullopt;
    const auto nearest = [&](const auto& index, const std::string& key) {
      const auto found = index.find(key);
      if (key.empty() || found == index.end()) return std::optional<size_t>();
      for (size_t k : found->second)
        if (pictures_[k].folders == p.folders) return std::optional(k);
      return std::optional(found->second[0]);
    };
    auto of = nearest(by_rest_, p.key.rest);
    if (!of) of = nearest(by_number_, p.key.number);
    if (of) return Candidate{*role, *of, false, false, true};
    // Cameras for depth have a clock of their own: depth/1305031102.160.png next to rgb/1305031102.175.png.
    if (!in_folder || *role == PictureRole::Mask || *role == PictureRole::Cutout) return std::nullopt;
    for (size_t k = 0; k < pictures_.size(); ++k)
      if (is_plain(k)) return Candidate{*role, k, false, true, true};
    return std::nullopt;
  }

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
  std::map<std::string, std::vector<size_t>> by_name_, by_rest_, by_number_;  // the latter two: of plain pictures
};

bool content_agrees(const Candidate& c, const fs::path& path, const fs::path& of) {
  switch (c.role) {
    case PictureRole::Mask:
      return looks_like_mask(path, {.both = c.twin, .alpha = true, .quick = !c.twin});
    case PictureRole::Depth:
      return looks_like_depth(path, of);
    case PictureRole::Normals:
      return looks_like_normals(path);
    case PictureRole::Confidence:
      return looks_like_confidence(path, of);
    case PictureRole::Labels:
      return looks_like_labels(path);
    case PictureRole::Pass:
      return looks_like_pass(path, of);
    case PictureRole::Cutout:
      return looks_like_cutout(path, of, !c.version);
    case PictureRole::Copy:
      return CopyFinder().looks_like_copy(path, of, true);
  }
  return false;
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
  parallel_for(n, 16, [&](size_t i) {
    candidates[i] = partners.candidate(i);
    if (candidates[i]) return;
    if (const auto of = partners.version_of(i); of && picture_head(folder.photos[i].path).alpha) candidates[i] = of;
  });
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
    else if (!candidates[i]->twin && !candidates[i]->of_all && !candidates[i]->by_key && !partners[i].role_is_class &&
             candidates[i]->role != PictureRole::Copy)
      folder.like_photos.push_back(folder.photos[i].source);
  }
  drop_photos(folder.photos, agrees);
  reduced_masks(folder.beside);
}

}  // namespace

void sort_pictures(PhotoFolder& folder) {
  sort_by_role(folder);
  leave_out_second_sets(folder);
  std::sort(folder.beside.begin(), folder.beside.end(),
            [](const BesidePhoto& a, const BesidePhoto& b) { return a.source < b.source; });
}

}  // namespace vitrine
