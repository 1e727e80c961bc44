// What a reader has to say about a file that it could use: assumptions, and what it left out. A stage makes warnings of them,
// `vitrine inspect` prints them.
#pragma once

#include <string>
#include <vector>

namespace vitrine {

struct Note {
  std::string code;  // stable machine word of a warning; empty: for information only
  std::string text;  // a sentence
};
using Notes = std::vector<Note>;

}  // namespace vitrine
