// Notes of file readers: assumptions and omissions. A stage reports them as warnings; `vitrine inspect` prints them.
#pragma once

#include <string>
#include <vector>

namespace vitrine {

struct Note {
  std::string code;  // stable warning identifier; empty: information only
  std::string text;  // one sentence
};
using Notes = std::vector<Note>;

}  // namespace vitrine
