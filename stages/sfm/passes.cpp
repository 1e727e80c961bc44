#include "stages/sfm/passes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "core/foundation/math/quantile.h"
#include "core/intake/poses/colmap_repair.h"

namespace vitrine {

namespace {

constexpr size_t kAgree = 15, kContradict = 25;  // matches
// Distance from the epipolar line, relative to the longest side: 4 pixels of 1000. The poses come from the same matches.
constexpr double kFits = 0.004;
constexpr double kMostAgree = 0.5, kFewAgree = 0.3;
constexpr double kSameDirectionDeg = 20, kSameRollDeg = 30;
constexpr size_t kHardlyAMatch = 4, kEnoughFeatures = 40;
constexpr size_t kFewestContradicting = 3;  // pairs
constexpr double kMovedDeg = 5;

double degrees(double cosine) { return std::acos(std::clamp(cosine, -1.0, 1.0)) * 57.29577951308232; }
double turn_deg(const Mat3d& r) { return degrees((r.c0.x + r.c1.y + r.c2.z - 1) / 2); }

enum Side { kSurroundings = 0, kObject = 1 };

struct PairEvidence {
  size_t a = 0, b = 0;
  std::array<AgreementCount, 2> of;  // [side]
  bool same_view = false;
  double apart_deg = 0;

  bool agrees(int side) const { return of[size_t(side)].agree >= kAgree && of[size_t(side)].share() >= kMostAgree; }
};

// Matches of one side; a match between the two sides belongs to neither.
std::vector<PhotoMatches> matches_of(const FoundMatches& matches, std::span<const std::vector<uint8_t>> on_object, int side) {
  std::vector<PhotoMatches> out;
  for (size_t p = 0; p < matches.pairs.size(); ++p) {
    const auto [a, b] = matches.photos[p];
    PhotoMatches& m = out.emplace_back(PhotoMatches{matches.pairs[p].a, matches.pairs[p].b, {}, {}});
    for (size_t k = 0; k < matches.features[p].size(); ++k) {
      const auto [fa, fb] = matches.features[p][k];
      if (on_object[a][fa] != side || on_object[b][fb] != side) continue;
      m.in_a.push_back(matches.pairs[p].in_a[k]);
      m.in_b.push_back(matches.pairs[p].in_b[k]);
    }
  }
  return out;
}

class PassSearch {
 public:
  PassSearch(const ColmapModel& poses, const FoundMatches& matches, std::span<const std::vector<uint8_t>> on_object)
      : count_(on_object.size()), names_(on_object.size()), features_(on_object.size()) {
    for (size_t i = 0; i < count_; ++i) {
      const auto inside = size_t(std::count(on_object[i].begin(), on_object[i].end(), 1));
      features_[i] = {on_object[i].size() - inside, inside};
    }
    std::map<std::string, const ColmapImage*> image_of;
    for (const ColmapImage& image : poses.images) image_of[image.name] = &image;
    std::map<std::pair<std::string, std::string>, size_t> index;
    for (size_t p = 0; p < matches.pairs.size(); ++p) {
      const auto a = image_of.find(matches.pairs[p].a), b = image_of.find(matches.pairs[p].b);
      if (a == image_of.end() || b == image_of.end()) continue;
      const Mat3d ra = a->second->cam_from_world().rotation, rb = b->second->cam_from_world().rotation;
      const Vec3d forward_a = transposed_times(ra, Vec3d{0, 0, 1}), forward_b = transposed_times(rb, Vec3d{0, 0, 1});
      PairEvidence& e = pairs_.emplace_back();
      std::tie(e.a, e.b) = matches.photos[p];
      names_[e.a] = a->first, names_[e.b] = b->first;
      e.apart_deg = degrees(dot(forward_a, forward_b));
      e.same_view = e.apart_deg < kSameDirectionDeg && turn_deg(rb * transposed(ra)) < kSameRollDeg;
      index[{a->first, b->first}] = pairs_.size() - 1;
    }
    for (int side : {kSurroundings, kObject})
      for (const PairAgreement& pair : matches_agreement(poses, matches_of(matches, on_object, side), kFits).pairs)
        if (const auto found = index.find({pair.a, pair.b}); found != index.end())
          pairs_[found->second].of[size_t(side)] = pair.count;
  }

  bool contradicts(const PairEvidence& e, int side) const {
    if (!e.agrees(1 - side)) return false;
    const AgreementCount& n = e.of[size_t(side)];
    if (n.tests >= kContradict && n.share() < kFewAgree) return true;
    return e.same_view && n.agree < kHardlyAMatch &&
           std::min(features_[e.a][size_t(side)], features_[e.b][size_t(side)]) >= kEnoughFeatures;
  }

  // Groups the photos by agreement on one side, pairs with the most matches first. An accidentally agreeing pair does not join
  // two groups with more contradicting pairs between them.
  std::vector<size_t> groups_by(int side) const {
    std::vector<const PairEvidence*> order;
    for (const PairEvidence& e : pairs_)
      if (e.agrees(side)) order.push_back(&e);
    std::stable_sort(order.begin(), order.end(), [side](const PairEvidence* a, const PairEvidence* b) {
      return a->of[size_t(side)].agree > b->of[size_t(side)].agree;
    });
    std::vector<size_t> group(count_);
    std::iota(group.begin(), group.end(), size_t{0});
    for (const PairEvidence* e : order) {
      const std::pair<size_t, size_t> both = std::minmax(group[e->a], group[e->b]);
      if (both.first == both.second) continue;
      size_t agree = 0, contradict = 0;
      for (const PairEvidence& other : pairs_)
        if (std::pair<size_t, size_t>(std::minmax(group[other.a], group[other.b])) == both)
          agree += other.agrees(side), contradict += contradicts(other, side);
      if (contradict > agree) continue;
      std::replace(group.begin(), group.end(), both.second, both.first);
    }
    return group;
  }

  // Passes of one side: groups of at least kSmallestPass photos with contradicting pairs between them. Empty: fewer than two.
  Passes passes(int side, size_t& contradicting) const {
    const std::vector<size_t> group = groups_by(side);
    std::vector<size_t> size(count_, 0);
    for (size_t i = 0; i < count_; ++i) size[group[i]] += !names_[i].empty();
    std::map<std::pair<size_t, size_t>, size_t> against;
    for (const PairEvidence& e : pairs_)
      if (group[e.a] != group[e.b] && contradicts(e, side)) ++contradicting, ++against[std::minmax(group[e.a], group[e.b])];
    std::set<size_t> proven;
    for (const auto& [pair, n] : against)
      if (n >= kFewestContradicting && std::min(size[pair.first], size[pair.second]) >= kSmallestPass)
        proven.insert({pair.first, pair.second});
    if (proven.size() < 2) return {};
    // Other photos join the group of their nearest neighbours in name order.
    std::vector<size_t> of = group;
    for (size_t i = 0; i < count_; ++i)
      for (size_t apart = 1; !proven.contains(of[i]) && apart < count_; ++apart)
        for (const size_t other : {i - apart, i + apart})
          if (other < count_ && !proven.contains(of[i])) of[i] = group[other];
    std::map<size_t, std::vector<std::string>> named;
    for (size_t i = 0; i < count_; ++i)
      if (!names_[i].empty()) named[of[i]].push_back(names_[i]);
    Passes out;
    for (auto& [representative, photos] : named) out.push_back(std::move(photos));
    std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
    return out;
  }

  double furthest_match() const {
    std::vector<double> apart;
    for (const PairEvidence& e : pairs_)
      if (e.agrees(kObject)) apart.push_back(e.apart_deg);
    return apart.empty() ? 0 : quantile_of(apart, 0.9);
  }

 private:
  size_t count_;
  std::vector<std::string> names_;               // [photo] empty: no pose
  std::vector<std::array<size_t, 2>> features_;  // [photo][side]
  std::vector<PairEvidence> pairs_;
};

struct StandingGroups {
  Passes passes;                 // groups of photos with equal orientation of the object; empty: no motion
  size_t photos = 0, alone = 0;  // photos with poses in both models; of these in no group
};

StandingGroups standing_groups(const ColmapModel& object, std::span<const ColmapModel> surroundings) {
  std::map<std::string, Mat3d> object_turn;
  for (const ColmapImage& image : object.images) object_turn[image.name] = image.cam_from_world().rotation;
  StandingGroups out;
  bool moved = false;
  std::set<std::string> placed;  // COLMAP's models may share photos
  for (const ColmapModel& model : surroundings) {
    std::vector<Mat3d> stands;  // [group] surroundings_from_object of its first photo
    Passes groups;
    for (const ColmapImage& image : model.images) {
      const auto turn = object_turn.find(image.name);
      if (turn == object_turn.end() || placed.contains(image.name)) continue;
      const Mat3d surroundings_from_object = transposed(image.cam_from_world().rotation) * turn->second;
      size_t group = 0;
      while (group < stands.size() && turn_deg(transposed(stands[group]) * surroundings_from_object) > kMovedDeg) ++group;
      if (group == stands.size()) stands.push_back(surroundings_from_object), groups.emplace_back();
      groups[group].push_back(image.name);
      ++out.photos;
    }
    for (const std::vector<std::string>& photos : groups) out.alone += photos.size() < kSmallestPass ? photos.size() : 0;
    std::erase_if(groups, [](const std::vector<std::string>& photos) { return photos.size() < kSmallestPass; });
    moved |= groups.size() > 1;
    for (const std::vector<std::string>& photos : groups) placed.insert(photos.begin(), photos.end());
    out.passes.insert(out.passes.end(), groups.begin(), groups.end());
  }
  if (!moved) out.passes.clear();
  std::stable_sort(out.passes.begin(), out.passes.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return out;
}

}  // namespace

MotionEvidence motion_evidence(const ColmapModel& poses, const FoundMatches& matches,
                               std::span<const std::vector<uint8_t>> on_object) {
  const PassSearch search(poses, matches, on_object);
  MotionEvidence out;
  // The poses follow one of the two sides; the other one contradicts them.
  for (int side : {kObject, kSurroundings}) {
    size_t contradicting = 0;
    Passes found = search.passes(side, contradicting);
    if (found.size() > out.passes.size()) out.passes = std::move(found), out.pairs = contradicting;
  }
  out.furthest_match = search.furthest_match();
  return out;
}

Passes passes_by_motion(const ColmapModel& object, std::span<const ColmapModel> surroundings) {
  return standing_groups(object, surroundings).passes;
}

bool turns_in_most_photos(const ColmapModel& object, std::span<const ColmapModel> surroundings) {
  const StandingGroups groups = standing_groups(object, surroundings);
  return 2 * groups.alone > groups.photos;
}

ColmapModel restricted(const ColmapModel& model, const std::vector<std::string>& photos) {
  std::set<uint32_t> others;
  for (const ColmapImage& image : model.images)
    if (std::find(photos.begin(), photos.end(), image.name) == photos.end()) others.insert(image.id);
  return without_images(model, others);
}

}  // namespace vitrine
