// Text files as people's editors leave them: a UTF-8 byte order mark is skipped, other encodings are named.
#pragma once

#include <filesystem>
#include <string>

namespace vitrine {

// The text without its byte order mark. Throws Error{Input}: unreadable, or UTF-16 or UTF-32.
std::string read_text_file(const std::filesystem::path& path);

}  // namespace vitrine
