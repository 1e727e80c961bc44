#include "stages/inspect/findings.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/math/median.h"
#include "stages/inspect/gps_finding.h"

namespace vitrine {

namespace {

// Minimum number of photos for a closed ring, and for any model.
constexpr size_t kFewPhotos = 15, kLeastPhotos = 3;
constexpr size_t kPhotosOfPanorama = 3;                      // that one panorama counts for
constexpr double kTinySide = 500, kSmallSide = 900;          // pixels of the longest side
constexpr double kSoftSet = 3.0, kSoftPhoto = 2.0;           // px of blur at kBlurSide: of the median, of one photo
constexpr double kMotionRatio = 1.6;                         // blur of the worst direction over that of the best
constexpr double kFewCorners = 0.05, kHardlyCorners = 0.02;  // share of cells with a corner
constexpr double kClippedHigh = 0.08, kClippedLow = 0.25;    // share of pixels
constexpr double kExposureStep = 0.4;                        // EV between the photos of a set of fixed exposure
// A photo against its neighbours: a multiple of the usual deviation in the set, within bounds (log2).
constexpr double kJump = 4;
struct Bounds {
  double low, high;
};
constexpr Bounds kBrightnessJump{1.0, 2.0}, kWhiteBalanceJump{0.5, 1.2};
constexpr double kFocalStep = 1.03;  // focus breathing changes the focal length by less

// "1 photo is", "3 photos are".
std::string photos(size_t n, const char* one, const char* several) {
  return fmt::format("{} {}", n, n == 1 ? std::string("photo") + one : std::string("photos") + several);
}

class Judge {
 public:
  Judge(const PhotoFolder& folder, const std::vector<PhotoFacts>& photos, double soft_ratio)
      : folder_(folder), photos_(photos), soft_ratio_(soft_ratio) {
    for (size_t i = 0; i < photos.size(); ++i)
      if (photos[i].usable()) usable_.push_back(i);
    out_.figures.usable = usable_.size();
  }

  Findings judged() {
    files();
    count();
    if (!usable_.empty()) {
      size();
      cameras();
      colors();
      sharpness();
      texture();
      exposure();
      clipping();
      duplicates();
      contents();
      if (auto gps = gps_finding(photos_)) add(std::move(*gps));
    }
    worst_first(out_.list);
    return std::move(out_);
  }

 private:
  template <class F>
  std::vector<double> all(F&& f) const {
    std::vector<double> v;
    for (size_t i : usable_) v.push_back(f(photos_[i]));
    return v;
  }
  template <class F>
  std::vector<size_t> those(F&& f) const {
    std::vector<size_t> v;
    for (size_t i : usable_)
      if (f(photos_[i])) v.push_back(i);
    return v;
  }
  bool many(const std::vector<size_t>& photos) const { return 2 * photos.size() > usable_.size(); }
  void add(Finding finding) { out_.list.push_back(std::move(finding)); }

  void files() {
    std::vector<size_t> broken;
    for (size_t i = 0; i < photos_.size(); ++i)
      if (!photos_[i].usable()) broken.push_back(i);
    if (!broken.empty())
      add({"unreadable_photos", Severity::Problem, fmt::format("{} of {} photos cannot be read", broken.size(), photos_.size()),
           photos_[broken[0]].failure, "copy them from the camera again, or take them out of the folder", broken});
    for (const FolderNote& note : notes_of(folder_)) {
      const std::string code = note.code == "PHOTO_TYPES_NOT_READ" ? "types_not_read" : lowered(note.code);
      add({code, note.warning ? Severity::Warning : Severity::Note, note.what, note.why, note.hint, {}});
    }
  }

  void count() {
    const size_t panoramas = those([](const PhotoFacts& p) { return p.panorama; }).size();
    if (usable_.size() + (kPhotosOfPanorama - 1) * panoramas >= kFewPhotos) return;
    const bool hopeless = usable_.size() < kLeastPhotos;
    add({"few_photos",
         hopeless ? Severity::Problem : Severity::Warning,
         usable_.size() == 1 ? std::string("there is one photo") : fmt::format("there are {} photos", usable_.size()),
         hopeless ? "depth needs the same thing seen from three places" : "every part should be seen by four photos",
         "take 20 to 60: a ring or two around the object, in steps of 10 to 15 degrees",
         {}});
  }

  void size() {
    const double side = upper_median(all([](const PhotoFacts& p) { return p.longest(); }));
    if (side >= kSmallSide) return;
    add({"small_photos",
         side < kTinySide ? Severity::Problem : Severity::Warning,
         fmt::format("the photos are small: {:.0f} pixels on the longest side", side),
         side < kTinySide ? "too few pixels to find the same points again" : "fine structure is lost",
         "use the photos as the camera wrote them, not previews",
         {}});
  }

  void cameras() {
    std::map<std::string, size_t> models;
    std::map<std::pair<int, int>, size_t> sizes;
    for (size_t i : usable_) {
      ++models[photos_[i].camera];
      ++sizes[std::minmax(photos_[i].width, photos_[i].height)];
    }
    if (models.size() > 1) {
      std::string list;
      for (const auto& [model, n] : models)
        list += fmt::format("{}{} x {}", list.empty() ? "" : ", ", n, model.empty() ? "unknown" : model);
      add({"mixed_cameras",
           Severity::Warning,
           fmt::format("the photos are from {} cameras", models.size()),
           list,
           "each camera is solved for by itself: that works with 10 photos of each or more; one camera is safer",
           {}});
    }
    if (sizes.size() > 1) {
      std::string list;
      for (const auto& [s, n] : sizes) list += fmt::format("{}{} x {}x{}", list.empty() ? "" : ", ", n, s.second, s.first);
      add({"mixed_sizes",
           Severity::Warning,
           fmt::format("the photos have {} sizes", sizes.size()),
           list,
           "do not crop; use one setting of the camera",
           {}});
    }
    const size_t known =
        size_t(std::ranges::count_if(usable_, [&](size_t i) { return photos_[i].focal_px || photos_[i].panorama; }));
    zoom();
    if (known > 0 && known < usable_.size())
      add({"focal_missing", Severity::Note, photos(usable_.size() - known, " has no focal length", " have no focal length"),
           "their EXIF data was removed or is incomplete", "use the photos as the camera wrote them",
           those([](const PhotoFacts& p) { return !p.focal_px && !p.panorama; })});
  }

  // Focal lengths of each camera: relative to the picture size, else in millimetres.
  void zoom() {
    using Range = std::optional<std::pair<double, double>>;
    std::map<std::string, std::pair<Range, Range>> cameras;
    const auto widen = [](Range& range, double f) {
      range = range ? std::pair(std::min(range->first, f), std::max(range->second, f)) : std::pair(f, f);
    };
    for (size_t i : usable_) {
      auto& [by_size, in_mm] = cameras[photos_[i].camera];
      if (photos_[i].focal_px) widen(by_size, *photos_[i].focal_px / photos_[i].longest());
      if (photos_[i].zoom) widen(in_mm, *photos_[i].zoom);
    }
    const auto changes = [](const Range& range) { return range && range->second > kFocalStep * range->first; };
    for (const auto& [model, ranges] : cameras) {
      const auto& [by_size, in_mm] = ranges;
      if (!changes(by_size) && !changes(in_mm)) continue;
      add({"mixed_focal",
           Severity::Warning,
           fmt::format("the focal length changes{}", model.empty() ? "" : " (" + model + ")"),
           changes(by_size)
               ? fmt::format("{:.2f} to {:.2f} times the longest side: a zoom was used", by_size->first, by_size->second)
               : fmt::format("{:.4g} to {:.4g} mm with digital zoom: a zoom was used", in_mm->first, in_mm->second),
           "leave the zoom where it is; walk instead",
           {}});
    }
  }

  void colors() {
    std::vector<const ColorFacts*> facts;
    for (const PhotoFacts& p : photos_) facts.push_back(p.usable() ? &p.color : nullptr);
    for (ColorNote& note : color_notes(facts))
      add({note.finding, note.warning_code.empty() ? Severity::Note : Severity::Warning, std::move(note.what),
           std::move(note.why), std::move(note.hint), std::move(note.photos)});
  }

  // Files with several pictures, or with values outside the range of pictures: reports what is read.
  void contents() {
    std::map<std::string, std::vector<size_t>> by_note;
    for (size_t i : usable_)
      for (const std::string& note : photos_[i].notes) by_note[note].push_back(i);
    for (auto& [note, of] : by_note) {
      std::string what = of.size() == 1 ? fmt::format("{} is {}", photos_[of[0]].name, note)
                                        : fmt::format("{} photos are each {}", of.size(), note);
      add({"photo_content", Severity::Note, std::move(what), "this is how ingest reads it",
           "export the picture alone if another one is meant", std::move(of)});
    }
  }

  void sharpness() {
    std::vector<double> blurs;
    for (size_t i : usable_)
      if (const auto b = photos_[i].blur()) blurs.push_back(*b);
    if (blurs.empty()) return;
    const double typical = upper_median(blurs);
    out_.figures.blur = typical;
    if (typical > kSoftSet) {
      add({"soft_set",
           Severity::Problem,
           fmt::format("most photos are soft: edges are smeared over {:.1f} pixels", typical),
           fmt::format("at {:.0f} pixels a side; below {:.1f} is usual", kBlurSide, kSoftPhoto),
           "tripod or more light; focus on the object and keep the focus there",
           {}});
      return;
    }
    // Compared with the previous and next photos, which show similar content.
    std::vector<size_t> soft;
    size_t moved = 0;
    constexpr size_t kNeighbours = 3;
    for (size_t k = 0; k < usable_.size(); ++k) {
      const PhotoFacts& p = photos_[usable_[k]];
      const auto blur = p.blur();
      if (!blur) continue;
      std::vector<double> near;
      for (size_t n = k > kNeighbours ? k - kNeighbours : 0; n < std::min(usable_.size(), k + kNeighbours + 1); ++n)
        if (const auto b = photos_[usable_[n]].blur(); b && n != k) near.push_back(*b);
      const double expected = near.empty() ? typical : std::min(upper_median(near), typical);
      if (*blur < std::max(kSoftPhoto, soft_ratio_ * std::max(expected, 0.5))) continue;
      soft.push_back(usable_[k]);
      moved += p.measures.blur_ratio > kMotionRatio;
    }
    if (soft.empty()) return;
    add({"soft_photos", 4 * soft.size() > usable_.size() ? Severity::Problem : Severity::Warning,
         photos(soft.size(), " is less sharp than its neighbours", " are less sharp than their neighbours"),
         moved == 0 ? "out of focus, or too small an aperture"
                    : fmt::format("{} of them smeared in one direction: the camera moved", moved),
         "take them again, or take them out", soft});
  }

  void texture() {
    out_.figures.texture = upper_median(all([](const PhotoFacts& p) { return p.measures.texture; }));
    const double t = out_.figures.texture;
    if (t < kFewCorners) {
      add({"low_texture",
           t < kHardlyCorners ? Severity::Problem : Severity::Warning,
           fmt::format("only {:.0f} % of a picture holds anything to recognise", 100 * t),
           "poses come from points that are found again in other photos",
           "put a printed pattern or newspaper under the object; keep the room in the picture",
           {}});
      return;
    }
    const std::vector<size_t> bare = those([](const PhotoFacts& p) { return p.measures.texture < kHardlyCorners; });
    if (!bare.empty())
      add({"bare_photos", Severity::Warning, photos(bare.size(), " shows hardly any texture", " show hardly any texture"),
           "such photos seldom get a pose", "keep more of the surroundings in the picture", bare});
  }

  // Photos whose value deviates from the median of the two previous and two next photos.
  template <class F>
  std::vector<size_t> jumps(const Bounds& bounds, F&& figure) const {
    std::vector<double> off;  // [usable]
    for (size_t k = 0; k < usable_.size(); ++k) {
      std::vector<double> near;
      for (long d : {-2L, -1L, 1L, 2L}) {
        const long n = long(k) + d;
        if (n >= 0 && n < long(usable_.size())) near.push_back(figure(photos_[usable_[size_t(n)]]));
      }
      off.push_back(near.size() >= 2 ? std::abs(figure(photos_[usable_[k]]) - upper_median(near)) : 0);
    }
    const double step = std::clamp(kJump * upper_median(off), bounds.low, bounds.high);
    std::vector<size_t> out;
    for (size_t k = 0; k < usable_.size(); ++k)
      if (off[k] > step) out.push_back(usable_[k]);
    return out;
  }

  void exposure() {
    const auto range = [](const std::vector<double>& v) {
      const auto [low, high] = std::minmax_element(v.begin(), v.end());
      return *high - *low;
    };
    std::vector<double> ev;
    for (size_t i : usable_)
      if (photos_[i].exposure_ev) ev.push_back(*photos_[i].exposure_ev);
    const std::vector<double> bright = all([](const PhotoFacts& p) { return p.measures.brightness_ev; });
    out_.figures.brightness_range_ev = range(bright);
    if (!ev.empty()) out_.figures.exposure_range_ev = range(ev);
    const std::vector<size_t> jumped = jumps(kBrightnessJump, [](const PhotoFacts& p) { return p.measures.brightness_ev; });
    const double least = ev.empty() ? 0 : range(ev);
    if (least > kExposureStep || !jumped.empty()) {
      const bool severe = 4 * jumped.size() >= usable_.size() && !jumped.empty();
      add({"mixed_exposure", severe ? Severity::Problem : Severity::Warning,
           least > kExposureStep ? fmt::format("the exposure changes by {:.1f} EV", least)
                                 : photos(jumped.size(), " is much brighter or darker than its neighbours",
                                          " are much brighter or darker than their neighbours"),
           jumped.empty() ? "the camera chose it for every photo; gains are measured and taken out, highlights may clip"
                          : fmt::format("mean brightness ranges over {:.1f} EV", out_.figures.brightness_range_ev),
           "manual exposure: one time, one aperture, one ISO for all photos", jumped});
    }
    std::vector<size_t> tinted = jumps(kWhiteBalanceJump, [](const PhotoFacts& p) { return p.measures.red_green; });
    for (size_t i : jumps(kWhiteBalanceJump, [](const PhotoFacts& p) { return p.measures.blue_green; })) tinted.push_back(i);
    std::sort(tinted.begin(), tinted.end());
    tinted.erase(std::unique(tinted.begin(), tinted.end()), tinted.end());
    out_.figures.white_balance_range = std::max(range(all([](const PhotoFacts& p) { return p.measures.red_green; })),
                                                range(all([](const PhotoFacts& p) { return p.measures.blue_green; })));
    if (!tinted.empty())
      add({"mixed_white_balance", Severity::Warning, "the colour balance jumps in " + photos(tinted.size(), "", ""),
           fmt::format("red or blue against green ranges over {:.1f} stops", *out_.figures.white_balance_range),
           "fixed white balance, no mixed lamps", tinted});
  }

  void clipping() {
    out_.figures.clipped_high = upper_median(all([](const PhotoFacts& p) { return p.measures.clipped_high; }));
    out_.figures.clipped_low = upper_median(all([](const PhotoFacts& p) { return p.measures.clipped_low; }));
    const std::vector<size_t> high = those([](const PhotoFacts& p) { return p.measures.clipped_high > kClippedHigh; });
    const std::vector<size_t> low = those([](const PhotoFacts& p) { return p.measures.clipped_low > kClippedLow; });
    if (!high.empty())
      add({"clipped_highlights", many(high) ? Severity::Warning : Severity::Note,
           "highlights are clipped in " + photos(high.size(), "", ""),
           fmt::format("more than {:.0f} % of their pixels are at the end of the scale", 100 * kClippedHigh),
           "expose one stop less: clipped light cannot be measured", high});
    if (!low.empty())
      add({"black_shadows", many(low) ? Severity::Warning : Severity::Note,
           "large parts are black in " + photos(low.size(), "", ""),
           fmt::format("more than {:.0f} % of their pixels", 100 * kClippedLow),
           "more light; and do not cut the object out: the surroundings carry the poses", low});
  }

  void duplicates() {
    std::vector<size_t> again;
    bool bytes = false;
    for (size_t b = 1; b < usable_.size(); ++b)
      for (size_t a = 0; a < b; ++a) {
        const PhotoFacts &first = photos_[usable_[a]], &second = photos_[usable_[b]];
        const bool same = first.digest == second.digest;
        if (!same && likeness(first.measures, second.measures) < kSamePicture) continue;
        bytes |= same;
        again.push_back(usable_[b]);
        break;
      }
    if (again.empty()) return;
    const size_t different = usable_.size() - again.size();
    add({"near_duplicates", many(again) || different < kLeastPhotos ? Severity::Problem : Severity::Warning,
         photos(again.size(), " repeats another", " repeat others") + fmt::format(": {} different ones remain", different),
         bytes ? "some are the same file again" : "the same view again tells nothing new",
         "move between photos; take the copies out", again});
  }

  const PhotoFolder& folder_;
  const std::vector<PhotoFacts>& photos_;
  double soft_ratio_;
  std::vector<size_t> usable_;
  Findings out_;
};

}  // namespace

std::string_view name(Severity s) { return s == Severity::Problem ? "problem" : s == Severity::Warning ? "warning" : "note"; }

void worst_first(std::vector<Finding>& list) {
  std::stable_sort(list.begin(), list.end(), [](const Finding& a, const Finding& b) { return a.severity > b.severity; });
}

Findings findings_of(const PhotoFolder& folder, const std::vector<PhotoFacts>& photos, double soft_ratio) {
  return Judge(folder, photos, soft_ratio).judged();
}

}  // namespace vitrine
