// A parser of binary PLY files of floats that shares no code with the writer.
#pragma once

#include <cstring>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/foundation/base/file.h"

namespace vitrine::test {

// Every property of a binary PLY of floats, by name.
struct FloatPly {
  std::vector<std::string> comments, properties;
  std::vector<std::vector<float>> rows;
  float value(size_t row, const std::string& property) const {
    for (size_t i = 0; i < properties.size(); ++i)
      if (properties[i] == property) return rows.at(row)[i];
    ADD_FAILURE() << "no property " << property;
    return 0;
  }
};

inline FloatPly parsed_ply(const fs::path& path) {
  const std::string bytes = read_file(path);
  std::istringstream in(bytes);
  std::string line, word;
  FloatPly ply;
  size_t count = 0;
  std::getline(in, line);
  EXPECT_EQ(line, "ply");
  while (std::getline(in, line) && line != "end_header") {
    std::istringstream words(line);
    words >> word;
    if (word == "comment") ply.comments.push_back(line.substr(8));
    if (word == "format") {
      EXPECT_EQ(line, "format binary_little_endian 1.0");
    }
    if (word == "element") words >> word >> count;
    if (word == "property") {
      std::string type, name;
      words >> type >> name;
      EXPECT_EQ(type, "float");
      ply.properties.push_back(name);
    }
  }
  const size_t start = size_t(in.tellg()), width = ply.properties.size();
  EXPECT_EQ(bytes.size(), start + count * width * 4);
  ply.rows.assign(count, std::vector<float>(width));
  for (size_t i = 0; i < count; ++i) std::memcpy(ply.rows[i].data(), bytes.data() + start + i * width * 4, width * 4);
  return ply;
}

}  // namespace vitrine::test
