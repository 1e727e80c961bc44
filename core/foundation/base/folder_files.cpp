#include "core/foundation/base/folder_files.h"

#include <algorithm>
#include <set>

namespace vitrine {

namespace fs = std::filesystem;

namespace {

// Lower case.
constexpr std::string_view kJunk[] = {
    "@eadir",       "#recycle",  "#snapshot",   "@tmp",        "@recycle",   "@recently-snapshot",
    "@__thumb",     "thumbs.db", "ehthumbs.db", "desktop.ini", "picasa.ini", "zbthumbnail.info",
    "$recycle.bin", "recycler",  "recycled",    "__macosx",    "lost+found", "system volume information",
    "icon\r",       "found.000",
};
constexpr std::string_view kJunkBeginnings[] = {"synofile_thumb_", "synophoto_thumb_"};

class Walk {
 public:
  Walk(const fs::path& root, ReachedTwice twice) : root_(root), twice_(twice) {}

  FolderFiles all(std::error_code& error) {
    const fs::path real = fs::canonical(root_, error);
    if (error) return {};
    enter({}, real, {}, error);
    if (error) return {};
    // Links are processed after all folders: a folder keeps its own name.
    while (!links_.empty()) {
      const std::string link = *links_.begin();
      links_.erase(links_.begin());
      std::error_code ec;
      const fs::path target = fs::canonical(root_ / link, ec);
      if (ec)
        out_.unreadable.push_back(link);
      else if (lies_in(real, target))
        out_.circles.push_back(link);
      else
        enter_or_note(link, target, {real});
    }
    for (const fs::path& link : file_links_) {
      std::error_code ec;
      if (real_files_.contains(fs::canonical(root_ / link, ec)))
        out_.repeated.push_back(link.generic_string());
      else
        out_.files.push_back(link);
    }
    const auto by_name = [](const fs::path& a, const fs::path& b) { return a.generic_string() < b.generic_string(); };
    std::sort(out_.files.begin(), out_.files.end(), by_name);
    for (auto* list : {&out_.dangling, &out_.circles, &out_.repeated, &out_.unreadable}) std::sort(list->begin(), list->end());
    return std::move(out_);
  }

 private:
  void enter_or_note(const fs::path& name, const fs::path& real, const std::vector<fs::path>& above) {
    std::error_code ec;
    enter(name, real, above, ec);
    if (ec) out_.unreadable.push_back(name.generic_string());
  }

  // `name`: relative to the root; `real`: links resolved; `above`: real ancestor folders.
  void enter(const fs::path& name, const fs::path& real, std::vector<fs::path> above, std::error_code& error) {
    if (!seen_.insert(real).second && twice_ == ReachedTwice::Once) {
      out_.repeated.push_back(name.generic_string());
      return;
    }
    std::vector<fs::path> names;
    fs::directory_iterator it(real, error);
    for (; !error && it != fs::directory_iterator(); it.increment(error)) names.push_back(it->path().filename());
    if (error) return;
    std::sort(names.begin(), names.end());
    above.push_back(real);
    for (const fs::path& entry : names) {
      const std::string word = entry.string();
      if (is_system_junk(word)) {
        ++out_.junk;
      } else if (word.starts_with('.')) {
        ++out_.hidden;
      } else {
        take(name / entry, real / entry, above);
      }
    }
  }

  void take(const fs::path& name, const fs::path& real, const std::vector<fs::path>& above) {
    std::error_code ec;
    const bool link = fs::is_symlink(real, ec);
    const fs::file_status status = fs::status(real, ec);
    if (link && !fs::exists(status)) {
      out_.dangling.push_back(name.generic_string());
    } else if (fs::is_regular_file(status)) {
      if (twice_ == ReachedTwice::Once) {
        if (link) {
          file_links_.push_back(name);
          return;
        }
        real_files_.insert(real);
      }
      out_.files.push_back(name);
    } else if (fs::is_directory(status)) {
      if (!link) {
        enter_or_note(name, real, above);
      } else if (twice_ == ReachedTwice::Once) {
        links_.insert(name.generic_string());
      } else {
        const fs::path target = fs::canonical(real, ec);
        const bool circle = std::any_of(above.begin(), above.end(), [&](const fs::path& a) { return lies_in(a, target); });
        if (circle)
          out_.circles.push_back(name.generic_string());
        else
          enter_or_note(name, target, above);
      }
    }
  }

  fs::path root_;
  ReachedTwice twice_;
  FolderFiles out_;
  std::set<fs::path> seen_, real_files_;
  std::vector<fs::path> file_links_;
  std::set<std::string> links_;
};

}  // namespace

FolderFiles files_below(const fs::path& folder, ReachedTwice twice, std::error_code& error) {
  error.clear();
  return Walk(folder, twice).all(error);
}

bool is_system_junk(std::string_view name) {
  std::string low(name);
  for (char& c : low)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return std::find(std::begin(kJunk), std::end(kJunk), low) != std::end(kJunk) ||
         std::any_of(std::begin(kJunkBeginnings), std::end(kJunkBeginnings),
                     [&](std::string_view beginning) { return low.starts_with(beginning); });
}

bool stays_below(const std::filesystem::path& name) {
  return !name.empty() && !name.is_absolute() && name.native().find('\0') == std::string::npos &&
         std::none_of(name.begin(), name.end(), [](const std::filesystem::path& part) { return part == ".."; });
}

namespace {

std::filesystem::path real_path(const std::filesystem::path& path) {
  std::error_code ec;
  const std::filesystem::path whole = std::filesystem::absolute(path, ec);
  std::filesystem::path real = std::filesystem::weakly_canonical(whole, ec);
  if (ec) real = whole.lexically_normal();
  return real.has_filename() ? real : real.parent_path();  // "a/b/" becomes "a/b"
}

}  // namespace

bool lies_in(const std::filesystem::path& path, const std::filesystem::path& folder) {
  const std::filesystem::path inner = real_path(path), outer = real_path(folder);
  return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

}  // namespace vitrine
