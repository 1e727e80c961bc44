// Reads the operators of an ONNX graph without running it. OpenCV's importer crashes on some operators and computes others
// wrongly without an error, so only networks whose operators are all known to be correct are accepted.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace vitrine {

// Throws Error{Input} naming `where` when the bytes are not a complete ONNX model with a graph.
std::set<std::string> onnx_operators(std::string_view model, const std::string& where);
// The operators that OpenCV 4.6 does not support or computes wrongly.
std::vector<std::string> unsupported_operators(const std::set<std::string>& operators);

}  // namespace vitrine
