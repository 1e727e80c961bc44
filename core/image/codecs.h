// OpenCV's codecs, in a library of their own that is loaded with the first picture. They bring GDAL and 120 more libraries with
// them, whose symbols take 0.15 s of CPU time to find; most starts of a program (for keys, descriptions, help) see no picture.
#pragma once

#include <string>
#include <vector>

namespace cv {
class Mat;
}

namespace vitrine {

// Both give what went wrong, or nothing. `flags`, `parameters`: cv::ImreadModes, cv::ImwriteFlags.
struct Codecs {
  std::string (*decode)(const std::string& bytes, int flags, cv::Mat& out);  // out is empty where no codec knows the data
  std::string (*encode)(const std::string& extension, const cv::Mat& mat, const std::vector<int>& parameters, std::string& bytes);
};

// Throws Error{Dependency} when the library cannot be loaded.
const Codecs& codecs();

}  // namespace vitrine
