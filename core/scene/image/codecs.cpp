#include "core/scene/image/codecs.h"

#include <dlfcn.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/scene/image/camera_codecs.h"

namespace vitrine {

namespace {

// The table `name` of a library. `built`: its path.
const void* load(const fs::path& built, const char* name) {
  // Next to the executable, else in the build folder (for executables elsewhere).
  const fs::path installed = fs::read_symlink("/proc/self/exe").parent_path() / built.filename();
  std::error_code none;
  const fs::path path = fs::exists(installed, none) ? installed : built;
  void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  const void* const found = library ? dlsym(library, name) : nullptr;
  if (!found) {
    const char* const why = dlerror();
    throw Error(ErrorKind::Dependency, "the codecs of pictures cannot be loaded",
                {.where = path.string(),
                 .why = why ? why : "",
                 .hint = "build vitrine anew (cmake --build); its programs and this library belong together",
                 .code = "NO_CODECS"});
  }
  return found;
}

}  // namespace

const Codecs& codecs() {
  static const auto* const loaded = static_cast<const Codecs*>(load(VITRINE_CODECS, "vitrine_codecs"));
  return *loaded;
}

const CameraCodecs& camera_codecs() {
  static const auto* const loaded = static_cast<const CameraCodecs*>(load(VITRINE_CAMERA_CODECS, "vitrine_camera_codecs"));
  return *loaded;
}

}  // namespace vitrine
