// OpenCV codecs, in the library that core/scene/image/codecs.cpp loads.
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/scene/image/codecs/codecs_here.h"

namespace vitrine {
namespace {

std::string decode_other(const std::string& bytes, int flags, cv::Mat& out) {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // errors are reported once, by our Error
  try {
    out = cv::imdecode(cv::Mat(1, int(bytes.size()), CV_8U, const_cast<char*>(bytes.data())), flags);
  } catch (const cv::Exception& e) {
    return e.what();
  }
  return {};
}

std::string encode(const std::string& extension, const cv::Mat& mat, const std::vector<int>& parameters, std::string& bytes) {
  std::vector<uchar> encoded;
  try {
    if (!cv::imencode(extension, mat, encoded, parameters)) return "there is no encoder";
  } catch (const cv::Exception& e) {
    return e.what();
  }
  bytes.assign(encoded.begin(), encoded.end());
  return {};
}

}  // namespace
}  // namespace vitrine

extern "C" __attribute__((visibility("default"))) const vitrine::Codecs vitrine_codecs{
    vitrine::decode_jpeg, vitrine::decode_png, vitrine::decode_tiff, vitrine::decode_other, vitrine::encode};
