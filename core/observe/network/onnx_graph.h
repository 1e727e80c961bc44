// What an ONNX file says of itself, read without running it: which operators its graph uses. OpenCV's importer crashes on some
// operators and computes others wrongly without a word, so a network is taken only if all of its operators are known to be right.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace vitrine {

// Operators of the graph. Throws Error{Input} naming `where` when the bytes are not a whole ONNX model with a graph.
std::set<std::string> onnx_operators(std::string_view model, const std::string& where);
// Those that OpenCV 4.6 does not compute, or not rightly.
std::vector<std::string> unsupported_operators(const std::set<std::string>& operators);

}  // namespace vitrine
