#include "core/intake/masks/mask_classes.h"

#include <algorithm>
#include <cctype>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/config/text.h"

namespace vitrine {

namespace fs = std::filesystem;

namespace {

// Synonyms of the classes, as used by people and other programs.
const std::map<std::string, MaskClass> kWords{
    {"foreground", MaskClass::Object},
    {"fg", MaskClass::Object},
    {"subject", MaskClass::Object},
    {"obj", MaskClass::Object},
    {"item", MaskClass::Object},
    {"thing", MaskClass::Object},
    {"target", MaskClass::Object},
    {"opaque", MaskClass::Object},
    {"glass", MaskClass::Transparent},
    {"window", MaskClass::Transparent},
    {"pane", MaskClass::Transparent},
    {"transmissive", MaskClass::Transparent},
    {"transmission", MaskClass::Transparent},
    {"transparency", MaskClass::Transparent},
    {"translucent", MaskClass::Transparent},
    {"refractive", MaskClass::Transparent},
    {"clear", MaskClass::Transparent},
    {"mirror", MaskClass::Specular},
    {"metal", MaskClass::Specular},
    {"metallic", MaskClass::Specular},
    {"reflective", MaskClass::Specular},
    {"reflection", MaskClass::Specular},
    {"reflecting", MaskClass::Specular},
    {"shiny", MaskClass::Specular},
    {"gloss", MaskClass::Specular},
    {"glossy", MaskClass::Specular},
    {"chrome", MaskClass::Specular},
    {"highlight", MaskClass::Specular},
    {"background", MaskClass::Ignore},
    {"bg", MaskClass::Ignore},
    {"exclude", MaskClass::Ignore},
    {"excluded", MaskClass::Ignore},
    {"ignored", MaskClass::Ignore},
    {"dynamic", MaskClass::Ignore},
    {"moving", MaskClass::Ignore},
    {"people", MaskClass::Ignore},
    {"person", MaskClass::Ignore},
    {"human", MaskClass::Ignore},
    {"sky", MaskClass::Ignore},
    {"occluder", MaskClass::Ignore},
    {"distractor", MaskClass::Ignore},
    {"transient", MaskClass::Ignore},
    {"invalid", MaskClass::Ignore},
    {"remove", MaskClass::Ignore},
};
// Generic folders between the masks and their classes or photos.
const std::set<std::string> kContainers{"mask",  "masks",  "images", "image", "photos", "photo",  "frames",
                                        "input", "inputs", "rgb",    "png",   "output", "outputs"};

// Trimmed and in lower case.
std::string plain_word(const std::string& text) {
  const size_t begin = text.find_first_not_of(" \t"), end = text.find_last_not_of(" \t");
  std::string word = begin == std::string::npos ? std::string() : text.substr(begin, end - begin + 1);
  return lowered(word);
}

}  // namespace

MaskClassFolders::MaskClassFolders(fs::path masks, MaskClass flat, const std::vector<std::string>& photos)
    : masks_(std::move(masks)), flat_(flat), photos_known_(!photos.empty()) {
  for (const std::string& photo : photos)
    for (const fs::path& part : fs::path(photo).parent_path()) photo_folders_.insert(plain_word(part.string()));
}

std::optional<MaskClassFolders::Place> MaskClassFolders::place(const fs::path& relative) {
  std::optional<MaskClass> kind;
  fs::path name;
  std::string unknown;
  bool first = true;
  for (const fs::path& part : relative.parent_path()) {
    const std::string word = plain_word(part.string());
    // The outermost folder with a class name is the class; deeper ones may belong to the photos.
    const auto named = kind || (!first && of_photos(word)) ? std::nullopt : mask_class(word);
    const bool container = kContainers.contains(word) && !of_photos(word);
    if (container && !kind) continue;
    first = false;
    if (named) {
      kind = named;
      continue;
    }
    name /= part;
    if (!kind && !of_photos(word) && unknown.empty() && (photos_known_ || probable_mask_class(word))) unknown = part.string();
  }
  if (!kind && !unknown.empty()) {
    ++unknown_[unknown];
    return std::nullopt;
  }
  return Place{kind.value_or(flat_), name / relative.filename()};
}

void MaskClassFolders::throw_if_unknown() const {
  if (unknown_.empty()) return;
  std::string list;
  size_t files = 0;
  for (const auto& [folder, n] : unknown_) {
    list += fmt::format("{}'{}'", list.empty() ? "" : ", ", folder);
    files += n;
  }
  const std::string& first = unknown_.begin()->first;
  std::string meant;
  for (const auto& entry : unknown_)
    if (const auto kind = probable_mask_class(entry.first))
      meant += fmt::format("{}'{}' instead of '{}'", meant.empty() ? "did you mean " : ", ", name(*kind), entry.first);
  const std::string alone = fmt::format("--masks \"{}\" for masks of the class '{}'", (masks_ / first).string(), name(flat_));
  throw Error(
      ErrorKind::Input,
      unknown_.size() == 1 ? fmt::format("a folder of masks is called like no class: '{}'", first)
                           : fmt::format("folders of masks are called like no class: {}", list),
      {.where = (masks_ / first).string(),
       .why = fmt::format("{} file{} there; the classes are object, transparent, specular and ignore, and no photo lies in "
                          "a folder of that name",
                          files, files == 1 ? "" : "s"),
       .hint =
           meant.empty() ? fmt::format("call it like a class, move it elsewhere, or {}", alone) : meant + "? rename the folder",
       .code = "MASKS_UNKNOWN_CLASS"});
}

std::optional<MaskClass> probable_mask_class(const std::string& word) {
  const std::string plain = plain_word(word);
  std::vector<std::string> known;
  for (MaskClass kind : kMaskClasses) known.emplace_back(name(kind));
  const auto meaning = [&](const std::string& w) {
    const auto found = kWords.find(w);
    return found == kWords.end() ? mask_class(w) : std::optional(found->second);
  };
  if (const auto kind = meaning(plain)) return kind;
  // "glass_mask", "mask-mirrors", "windows", "glasses"
  std::string letters = plain;
  for (char& c : letters)
    if (!std::isalpha(static_cast<unsigned char>(c))) c = ' ';
  for (size_t begin = 0; (begin = letters.find_first_not_of(' ', begin)) != std::string::npos;) {
    const size_t end = std::min(letters.find(' ', begin), letters.size());
    const std::string part = letters.substr(begin, end - begin);
    for (size_t cut = 0; cut <= 2 && cut < part.size(); ++cut)
      if (cut == 0 || part.back() == 's')
        if (const auto kind = meaning(part.substr(0, part.size() - cut))) return kind;
    begin = end;
  }
  const std::string near = nearest_word(plain, known);
  return near.empty() ? std::nullopt : mask_class(near);
}

}  // namespace vitrine
