// What the command line of vitrine-optics lists: seeds of scenes, and arms = ways of training that are compared.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace vitrine {

// An arm is a name and the options in which it differs from the others. Beside `stage.option` there are `input.masks` and
// `input.poses`: `truth` (the default) or `none`; masks can be `marks`, too: those of the scene's marks.yaml.
struct Arm {
  std::string name;
  std::map<std::string, std::string> options;

  std::string source(const std::string& input) const;  // of "masks" or "poses": truth, marks or none
};

// "1-12", "1,2,7", "1-3,101-112": in this order, each once. Error{Usage} names `flag`.
std::vector<int> seed_list(std::string_view text, std::string_view flag);

// "diffuse,full,layers,auto,NAME:stage.option=value;stage.option=value". The first four are known names: optimize.layers=diffuse,
// optimize.layers=auto, the same without an opaque twin, and training without masks. A known name with options has both. Commas
// in brackets or quotes belong to a value. Error{Usage} for an unknown name without options, a name twice, or a name that is no
// folder name.
std::vector<Arm> arm_list(std::string_view text);

}  // namespace vitrine
