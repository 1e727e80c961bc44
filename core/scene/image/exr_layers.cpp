#include "core/foundation/base/file.h"
#include "core/scene/image/exr.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

namespace vitrine {

namespace {

std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words(1);
  for (const char c : lowered(text)) {
    if (c == '.' || c == ':' || c == '/' || c == ' ' || c == '_' || c == '-')
      words.emplace_back();
    else
      words.back() += c;
  }
  return words;
}

bool among(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

struct ExrLayer {
  size_t part = 0;
  std::string name;                             // prefix, or name of the part
  bool plain = false;                           // channels have no prefix
  std::map<std::string, std::string> channels;  // base name -> channel
  int rank = 0, view = 0;

  bool has(std::initializer_list<const char*> bases) const {
    return std::all_of(bases.begin(), bases.end(), [&](const char* b) { return channels.contains(b); });
  }
  bool coloured() const { return has({"R", "G", "B"}); }
  // Luminance; not if X and Z exist too (then Y is a coordinate).
  bool grey() const { return (has({"Y"}) && !has({"X"}) && !has({"Z"})) || (has({"R"}) && !has({"G"}) && !has({"B"})); }
};

constexpr int kNamedRanks = 4;  // ranks below are names of main layers

int rank_of(const ExrLayer& layer, const std::vector<std::string>& words) {
  if (among(words, "combined")) return among(words, "composite") ? 0 : 1;
  if (among(words, "beauty")) return 2;
  if (among(words, "rgba")) return 3;
  if (layer.plain) return kNamedRanks;
  const bool cryptomatte = std::any_of(words.begin(), words.end(), [](const std::string& w) { return w.starts_with("crypto"); });
  return cryptomatte ? kNamedRanks + 2 : kNamedRanks + 1;
}

std::vector<ExrLayer> layers_of(const std::vector<ExrPart>& parts, const std::vector<std::string>& views) {
  std::vector<ExrLayer> layers;
  for (size_t p = 0; p < parts.size(); ++p) {
    if (parts[p].deep) continue;
    std::map<std::string, ExrLayer> of_part;
    for (const std::string& channel : parts[p].channels) {
      const std::string base = exr_base_name(channel), prefix = exr_layer_name(channel);
      if (base.empty()) continue;
      ExrLayer& layer = of_part[prefix];
      layer.part = p;
      layer.plain = prefix.empty();
      layer.name = prefix.empty() ? parts[p].name : prefix;
      layer.channels.emplace(base, channel);
    }
    for (auto& [prefix, layer] : of_part) {
      std::vector<std::string> words = words_of(parts[p].name);
      const std::vector<std::string> more = words_of(prefix);
      words.insert(words.end(), more.begin(), more.end());
      layer.rank = rank_of(layer, words);
      for (size_t v = 0; v < views.size(); ++v)
        if (parts[p].view == views[v] ||
            fmt::format(".{}.", lowered(prefix)).find(fmt::format(".{}.", lowered(views[v]))) != std::string::npos)
          layer.view = static_cast<int>(v);
      layers.push_back(layer);
    }
  }
  return layers;
}

std::string called(const ExrLayer& layer) { return layer.name.empty() ? "without a name" : fmt::format("\"{}\"", layer.name); }

}  // namespace

std::string exr_layer_name(const std::string& channel) {
  const size_t dot = channel.rfind('.');
  return dot == std::string::npos ? std::string() : channel.substr(0, dot);
}

std::string exr_base_name(const std::string& channel) {
  const std::string base = lowered(channel.substr(channel.rfind('.') + 1));
  for (const auto& [name, written] : {std::pair{"R", "r"},
                                      {"R", "red"},
                                      {"G", "g"},
                                      {"G", "green"},
                                      {"B", "b"},
                                      {"B", "blue"},
                                      {"A", "a"},
                                      {"A", "alpha"},
                                      {"Y", "y"},
                                      {"Y", "luminance"},
                                      {"RY", "ry"},
                                      {"BY", "by"},
                                      {"X", "x"},
                                      {"Z", "z"}})
    if (base == written) return name;
  return {};
}

std::string exr_channel_list(const std::vector<std::string>& channels) {
  constexpr size_t kShown = 12;
  std::string text;
  for (size_t i = 0; i < std::min(channels.size(), kShown); ++i) text += fmt::format("{}{}", i == 0 ? "" : ", ", channels[i]);
  if (channels.size() > kShown) text += fmt::format(" and {} more", channels.size() - kShown);
  return text;
}

ExrColors exr_colors(const std::vector<ExrPart>& parts, const std::vector<std::string>& given_views) {
  ExrColors out;
  std::vector<std::string> views = given_views;
  if (views.empty()) views = {"left", "right"};
  std::vector<ExrLayer> layers = layers_of(parts, views);
  const bool colours = std::any_of(layers.begin(), layers.end(), [](const ExrLayer& l) { return l.coloured(); });
  std::erase_if(layers, [&](const ExrLayer& l) { return colours ? !l.coloured() : !l.grey(); });
  if (layers.empty()) {
    std::vector<std::string> names;
    bool deep = false;
    for (const ExrPart& part : parts) {
      deep |= part.deep;
      names.insert(names.end(), part.channels.begin(), part.channels.end());
    }
    out.refusal = deep && std::all_of(parts.begin(), parts.end(), [](const ExrPart& p) { return p.deep; })
                      ? "it is a deep EXR (several samples per pixel): export it flattened"
                      : fmt::format("it has no colours (channels R, G, B, or Y) but {}: export the combined (beauty) picture",
                                    exr_channel_list(names));
    return out;
  }
  std::stable_sort(layers.begin(), layers.end(),
                   [](const ExrLayer& a, const ExrLayer& b) { return std::pair(a.rank, a.view) < std::pair(b.rank, b.view); });
  const ExrLayer& best = layers.front();
  std::vector<std::string> rivals;  // equally ranked by name
  size_t other_views = 0;
  for (size_t i = 1; i < layers.size(); ++i) {
    other_views += layers[i].view != best.view;
    if (layers[i].rank == best.rank && layers[i].view == best.view) rivals.push_back(called(layers[i]));
  }
  if (best.rank > kNamedRanks && !rivals.empty()) {
    rivals.insert(rivals.begin(), called(best));
    out.refusal = fmt::format("it has colours in {} layers ({}), and none of them is called combined, beauty or rgba: export one",
                              rivals.size(), exr_channel_list(rivals));
    return out;
  }
  if (!rivals.empty())
    out.notes.push_back(fmt::format("an EXR with {} pictures: {} is read", rivals.size() + 1, called(best)));
  else if (layers.size() > 1 && other_views < layers.size() - 1)
    out.notes.push_back(
        fmt::format("an EXR of several layers: the one {}{} is read", best.name.empty() ? "" : "called ", called(best)));
  if (other_views > 0) out.notes.push_back(fmt::format("an EXR of several views: \"{}\" is read", views[size_t(best.view)]));
  out.part = best.part;
  if (best.coloured())
    out.channels = {best.channels.at("R"), best.channels.at("G"), best.channels.at("B")};
  else if (best.has({"Y", "RY", "BY"}))
    out.channels = {best.channels.at("Y"), best.channels.at("RY"), best.channels.at("BY")}, out.luminance_chroma = true;
  else
    out.channels = {best.channels.contains("Y") ? best.channels.at("Y") : best.channels.at("R")};
  if (best.channels.contains("A")) out.alpha = best.channels.at("A");
  return out;
}

}  // namespace vitrine
