#include "stages/sfm/features.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <map>
#include <mutex>
#include <numbers>

#include "core/foundation/base/error.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/timer.h"
#include "core/scene/camera/colmap_lens.h"
#include "stages/sfm/matcher.h"
#include "stages/sfm/sfm.h"
#include "stages/sfm/wide_photos.h"

namespace vitrine {

namespace {

// f, cx, cy and zero distortion in the order of the camera model's parameters.
std::string prior_params(const ColmapCameraType& type, double focal_px, const SfmPhoto& p) {
  std::vector<double> params(has_two_focals(type.id) ? 2 : 1, focal_px);
  params.push_back(0.5 * p.width);
  params.push_back(0.5 * p.height);
  params.resize(type.parameter_count, 0.0);
  return fmt::format("{}", fmt::join(params, ","));
}

// EXIF's focal length. COLMAP's own guess holds for pinhole lenses only: a fisheye lens shows 180 degrees across its circle, or
// across the photo's longer side.
std::optional<double> prior_focal(const ReconstructDesc& desc, std::span<const size_t> group, const ColmapCameraType& type) {
  const SfmPhoto& first = desc.photos[group[0]];
  if (first.focal_px || !is_fisheye(type.id)) return first.focal_px;
  std::vector<fs::path> pictures;
  for (const size_t i : group) pictures.push_back(desc.photos[i].picture);
  const double circle = lens_circle_px(pictures, first.width, first.height, {0.5 * first.width, 0.5 * first.height});
  return (circle > 0 ? 2 * circle : std::max(first.width, first.height)) / std::numbers::pi;
}

std::string params_text(const ColmapCamera& camera) { return fmt::format("{}", fmt::join(camera.params, ",")); }

void write_match_list(const fs::path& path, std::span<const PhotoPair> pairs, std::span<const std::vector<Match>> matches) {
  fmt::memory_buffer text;
  for (size_t i = 0; i < pairs.size(); ++i) {
    fmt::format_to(std::back_inserter(text), "{} {}\n", safe_name(pairs[i].first), safe_name(pairs[i].second));
    for (const Match& m : matches[i]) fmt::format_to(std::back_inserter(text), "{} {}\n", m.a, m.b);
    text.push_back('\n');
  }
  write_file(path, std::string_view(text.data(), text.size()));
}

// Features of the object when passes are known: between photos of two passes only these are matched.
class ObjectFeatures {
 public:
  ObjectFeatures(const ReconstructDesc& desc, std::span<const size_t> photo_of, std::span<const PhotoFeatures> features)
      : pass_of_(desc.pass_of) {
    if (pass_of_.empty()) return;
    packed_.resize(features.size()), index_.resize(features.size());
    parallel_for(features.size(), 1, [&](size_t i) {
      const std::vector<uint8_t> on_object = desc.masks->on_object(photo_of[i], features[i].xy);
      std::vector<uint8_t> descriptors;
      for (uint32_t f = 0; f < on_object.size(); ++f) {
        if (!on_object[f]) continue;
        index_[i].push_back(f);
        const auto first = features[i].descriptors.begin() + long(kDescriptorBytes * f);
        descriptors.insert(descriptors.end(), first, first + long(kDescriptorBytes));
      }
      packed_[i] = PackedDescriptors(descriptors);
    });
  }
  bool between_passes(size_t photo_a, size_t photo_b) const {
    return !pass_of_.empty() && pass_of_[photo_a] != pass_of_[photo_b];
  }
  std::vector<Match> matches(size_t a, size_t b) const {
    std::vector<Match> found = match(packed_[a], packed_[b]);
    for (Match& m : found) m = {.a = index_[a][m.a], .b = index_[b][m.b]};
    return found;
  }

 private:
  const std::vector<size_t>& pass_of_;
  std::vector<PackedDescriptors> packed_;
  std::vector<std::vector<uint32_t>> index_;  // index of the packed descriptors among all features of the photo
};

// The last lines of COLMAP's output are the best available evidence.
[[noreturn]] void throw_colmap_failed(const std::string& command, const std::string& what, const ProcessResult& result) {
  constexpr size_t kTail = 600;
  const std::string tail = result.tail.size() > kTail ? result.tail.substr(result.tail.size() - kTail) : result.tail;
  throw Error(ErrorKind::Dependency, fmt::format("COLMAP's {} {}", command, what),
              {.where = command,
               .why = fmt::format("exit code {}, signal {}; it last printed:\n{}", result.exit_code, result.signal, tail),
               .hint = "look at colmap.log in the scratch folder; 'vitrine doctor' shows which COLMAP is used",
               .code = "SFM_COLMAP_FAILED"});
}

// [i] number of the rig of photo `photo_of[i]`; empty without rigs.
std::vector<size_t> rig_of_each(const std::vector<SfmPhoto>& photos, std::span<const size_t> photo_of) {
  if (std::ranges::none_of(photos, [](const SfmPhoto& p) { return p.rig.has_value(); })) return {};
  std::map<std::string, size_t> numbers;
  std::vector<size_t> out;
  for (const size_t i : photo_of)
    out.push_back(photos[i].rig ? numbers.try_emplace(photos[i].rig->panorama, numbers.size()).first->second : photos.size() + i);
  return out;
}

}  // namespace

std::vector<std::vector<size_t>> camera_groups(const std::vector<SfmPhoto>& photos, const ColmapModel* known) {
  std::map<std::string, std::vector<size_t>> by_key;
  for (size_t i = 0; i < photos.size(); ++i) {
    const SfmPhoto& p = photos[i];
    std::string key = fmt::format("{}x{} {}{} {}", p.width, p.height, p.focal_px ? fmt::format("{:.3f}", *p.focal_px) : "-",
                                  p.rig ? " rig" : "", p.camera);
    if (known != nullptr) {
      const auto image =
          std::find_if(known->images.begin(), known->images.end(), [&](const ColmapImage& m) { return m.name == p.name; });
      if (image == known->images.end()) continue;  // photos without a pose are not used
      key = fmt::format("camera {}", image->camera_id);
    }
    by_key[key].push_back(i);
  }
  std::vector<std::vector<size_t>> groups;
  for (auto& [key, members] : by_key) groups.push_back(std::move(members));
  std::sort(groups.begin(), groups.end());
  return groups;
}

std::string safe_name(size_t index) { return fmt::format("{:06}.png", index); }

std::optional<size_t> index_of_safe_name(const std::string& name) {
  size_t index = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
  if (error != std::errc() || std::string_view(end, name.data() + name.size()) != ".png") return std::nullopt;
  return index;
}

fs::path link_pictures(const ReconstructDesc& desc) {
  const fs::path pictures = desc.work_folder / "pictures";
  make_folders(pictures);
  for (size_t i = 0; i < desc.photos.size(); ++i) link_or_copy(desc.photos[i].picture, pictures / safe_name(i));
  return pictures;
}

void extract_features(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc, const FeatureEffort& effort,
                      const fs::path& database, const ColmapModel* known) {
  const fs::path pictures = link_pictures(desc);
  colmap.run({.command = "database_creator",
              .settings = {{"database", database.string()}},
              .working_folder = desc.work_folder,
              .log = desc.work_folder / "colmap.log"});
  const bool frames = ColmapDatabase(database).has_frames();
  size_t done = 0;
  const std::vector<std::vector<size_t>> groups = camera_groups(desc.photos, known);
  for (size_t g = 0; g < groups.size(); ++g) {
    const SfmPhoto& first = desc.photos[groups[g][0]];
    std::string names;
    for (size_t i : groups[g]) names += safe_name(i) + "\n";
    const fs::path list = desc.work_folder / fmt::format("camera_{}.txt", g);
    write_file(list, names);
    std::string model = first.rig ? "SIMPLE_PINHOLE" : config.camera_model, params;
    const ColmapCameraType* type = colmap_camera_type(model);
    VITRINE_CHECK(type != nullptr, "camera model '{}' passed the option's choices", model);
    if (const auto focal = known == nullptr ? prior_focal(desc, groups[g], *type) : std::nullopt)
      params = prior_params(*type, *focal, first);
    if (known != nullptr) {
      const auto image =
          std::find_if(known->images.begin(), known->images.end(), [&](const ColmapImage& m) { return m.name == first.name; });
      const ColmapCamera& camera = *known->find_camera(image->camera_id);
      model = colmap_camera_type(camera.model_id)->name;
      params = params_text(camera);
    }
    ColmapCommand call{.command = "feature_extractor",
                       .settings = {{"database", database.string()},
                                    {"images", pictures.string()},
                                    {"image_list", list.string()},
                                    {"camera_model", model},
                                    {"single_camera", "1"},
                                    {"extract_gpu", "0"},
                                    // With rigs and frames the ids cannot be renumbered later: use one thread, which numbers them
                                    // in order.
                                    {"extract_threads", std::to_string(frames ? 1 : desc.threads)},
                                    {"max_features", std::to_string(effort.max_features)},
                                    {"peak_threshold", fmt::format("{}", effort.peak_threshold)},
                                    {"seed", std::to_string(config.seed), false}},
                       .working_folder = desc.work_folder,
                       .log = desc.work_folder / "colmap.log",
                       .on_line = [&](std::string_view line) {
                         if (line.find("Processed file") == std::string_view::npos) return;
                         ++done;
                         if (desc.progress)
                           desc.progress(double(done) / double(desc.photos.size()),
                                         fmt::format("features {}/{}", done, desc.photos.size()));
                       }};
    if (config.max_image_size > 0) call.settings.push_back({"extract_max_size", std::to_string(config.max_image_size)});
    if (!params.empty()) call.settings.push_back({"camera_params", params});
    const ProcessResult result = colmap.run(call);
    // COLMAP skips unreadable pictures with exit code 0; a group without any row means that the program failed.
    const std::vector<PhotoFeatures> found = ColmapDatabase(database).features();
    if (std::none_of(groups[g].begin(), groups[g].end(), [&](size_t i) {
          return std::any_of(found.begin(), found.end(), [&](const PhotoFeatures& f) { return f.name == safe_name(i); });
        }))
      throw_colmap_failed("feature_extractor", "left no features", result);
  }
  if (!frames) ColmapDatabase(database).renumber_by_name();
}

MatchCounts match_and_verify(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc, const fs::path& database) {
  std::vector<PhotoFeatures> features = ColmapDatabase(database).features();
  Timer timer;
  // Indices in `features` and of the photos differ when a picture could not be read.
  std::vector<size_t> photo_of;
  for (const PhotoFeatures& f : features) {
    const std::optional<size_t> photo = index_of_safe_name(f.name);
    VITRINE_CHECK(photo && *photo < desc.photos.size(), "a name in the database is not ours");
    photo_of.push_back(*photo);
  }
  std::optional<MaskEffect> effect;
  std::vector<std::vector<uint32_t>> kept_features;
  if (desc.masks != nullptr) {
    kept_features = suppress_features(*desc.masks, desc.used, photo_of, features, effect.emplace());
    if (desc.timing) desc.timing("masks", timer.seconds());
    timer.restart();
  }
  std::vector<PackedDescriptors> packed(features.size());
  parallel_for(features.size(), 1, [&](size_t i) { packed[i] = PackedDescriptors(features[i].descriptors); });
  const ObjectFeatures object(desc, photo_of, features);
  const std::vector<size_t> rigs = rig_of_each(desc.photos, photo_of);
  const std::vector<PhotoPair> pairs = candidate_pairs(
      features, {.exhaustive_limit = config.exhaustive_limit, .seed = static_cast<uint64_t>(config.seed), .rig = rigs});
  std::vector<std::vector<Match>> matches(pairs.size());
  std::atomic<size_t> done{0};
  std::mutex reporting;
  parallel_for(pairs.size(), 1, [&](size_t i) {
    throw_if_interrupted();
    const auto [a, b] = pairs[i];
    matches[i] = object.between_passes(photo_of[a], photo_of[b]) ? object.matches(a, b) : match(packed[a], packed[b]);
    if (!kept_features.empty())
      for (Match& m : matches[i]) m = {.a = kept_features[pairs[i].first][m.a], .b = kept_features[pairs[i].second][m.b]};
    const size_t n = ++done;
    if (desc.progress && (n % 50 == 0 || n == pairs.size())) {
      const std::lock_guard lock(reporting);
      desc.progress(double(n) / double(pairs.size()), fmt::format("pairs matched {}/{}", n, pairs.size()));
    }
  });
  if (desc.timing) desc.timing("match", timer.seconds());

  MatchCounts counts{
      .compared = pairs.size(), .per_photo = std::vector<size_t>(desc.photos.size(), 0), .masks = std::move(effect)};
  std::vector<PhotoPair> kept_pairs;
  std::vector<std::vector<Match>> kept;
  for (size_t i = 0; i < pairs.size(); ++i) {
    const size_t a = photo_of[pairs[i].first], b = photo_of[pairs[i].second];
    counts.per_photo[a] += matches[i].size();
    counts.per_photo[b] += matches[i].size();
    if (matches[i].size() < kMinMatches) continue;
    kept_pairs.push_back({static_cast<uint32_t>(a), static_cast<uint32_t>(b)});
    kept.push_back(std::move(matches[i]));
  }
  counts.matched = kept_pairs.size();
  if (kept_pairs.empty()) return counts;

  timer.restart();
  std::vector<size_t> sizes;
  for (const std::vector<Match>& m : kept) sizes.push_back(m.size());
  const std::vector<VerifyChunk> chunks = verify_chunks(sizes, kMinMatches);
  const fs::path slim = desc.work_folder / "verify.db";
  fs::copy_file(database, slim, fs::copy_options::overwrite_existing);
  ColmapDatabase(slim).drop_descriptors();
  ColmapDatabase target(database);
  size_t verified = 0;
  parallel_for(chunks.size(), 1, [&](size_t c) {
    std::vector<PhotoPair> chunk_pairs;
    std::vector<std::vector<Match>> chunk_matches;
    for (size_t i : chunks[c].pairs) {
      chunk_pairs.push_back(kept_pairs[i]);
      chunk_matches.push_back(kept[i]);
    }
    const fs::path list = desc.work_folder / fmt::format("matches_{}.txt", c);
    write_match_list(list, chunk_pairs, chunk_matches);
    const fs::path part = desc.work_folder / fmt::format("verify_{}.db", c);
    fs::copy_file(slim, part, fs::copy_options::overwrite_existing);
    Colmap own = colmap;  // the help cache is not shared between threads
    const ProcessResult result =
        own.run({.command = "matches_importer",
                 .settings = {{"database", part.string()},
                              {"match_list", list.string()},
                              {"match_type", "raw"},
                              {"match_gpu", "0"},
                              {"match_threads", "1"},
                              {"verify_min_inliers", std::to_string(kMinMatches), false},
                              {"verify_inlier_ratio", fmt::format("{:.4f}", chunks[c].inlier_ratio), false},
                              {"seed", std::to_string(config.seed), false}},
                 .working_folder = desc.work_folder,
                 .log = desc.work_folder / fmt::format("verify_{}.log", c)});
    if (ColmapDatabase(part).examined_pairs() != chunk_pairs.size())
      throw_colmap_failed("matches_importer", "did not examine all pairs", result);
    const std::lock_guard lock(reporting);
    target.take_geometries(part);  // rows are keyed by pair: the result does not depend on the order of arrival
    fs::remove(part);
    verified += chunk_pairs.size();
    if (desc.progress)
      desc.progress(double(verified) / double(kept_pairs.size()),
                    fmt::format("pairs verified {}/{}", verified, kept_pairs.size()));
  });
  if (desc.timing) desc.timing("verify", timer.seconds());
  return counts;
}

}  // namespace vitrine
