// Binary and text formats of COLMAP models, for colmap_model.cpp only. The readers check syntax; check_colmap_model checks
// semantics.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/scene/camera/colmap_model.h"

namespace vitrine::colmap {

// Syntax error with its byte or line; the caller adds the file name.
struct Malformed {
  std::string why;
};

std::vector<ColmapCamera> cameras_from_binary(std::string_view bytes);
std::vector<ColmapImage> images_from_binary(std::string_view bytes);
std::vector<ColmapPoint3D> points_from_binary(std::string_view bytes);
std::string binary_of(const std::vector<ColmapCamera>& cameras);
std::string binary_of(const std::vector<ColmapImage>& images);
std::string binary_of(const std::vector<ColmapPoint3D>& points);

std::vector<ColmapCamera> cameras_from_text(std::string_view text);
std::vector<ColmapImage> images_from_text(std::string_view text);
std::vector<ColmapPoint3D> points_from_text(std::string_view text);
std::string text_of(const std::vector<ColmapCamera>& cameras);
std::string text_of(const std::vector<ColmapImage>& images);
std::string text_of(const std::vector<ColmapPoint3D>& points);

// Throws Malformed for unsupported models.
const ColmapCameraType& known_camera_type(int model_id);
const ColmapCameraType& known_camera_type(std::string_view name);

}  // namespace vitrine::colmap
