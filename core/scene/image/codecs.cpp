#include "core/scene/image/codecs.h"

#include <dlfcn.h>
#include <sys/resource.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/scene/image/camera_codecs.h"

namespace vitrine {

namespace {

// Whether the dynamic linker found no memory, or no address space (RLIMIT_AS), for a library.
bool lacks_memory(const std::string& reason) {
  rlimit space{};
  const bool limited = getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY;
  return reason.find("annot allocate memory") != std::string::npos || (limited && reason.find(" map ") != std::string::npos);
}

// The table `name` of a library. `built`: its path.
const void* load(const fs::path& built, const char* name) {
  // Next to the executable, else in the build folder (for executables elsewhere).
  const fs::path installed = fs::read_symlink("/proc/self/exe").parent_path() / built.filename();
  std::error_code none;
  const fs::path path = fs::exists(installed, none) ? installed : built;
  void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  const void* const found = library ? dlsym(library, name) : nullptr;
  if (!found) {
    const char* const reason = dlerror();
    const std::string why = reason ? reason : "";
    if (lacks_memory(why))
      throw Error(ErrorKind::Resource, "there is not enough memory for the codecs of pictures",
                  {.where = path.string(),
                   .why = why,
                   .hint = "allow more address space (ulimit -v unlimited), or end other programs",
                   .code = "OUT_OF_MEMORY"});
    throw Error(ErrorKind::Dependency, "the codecs of pictures cannot be loaded",
                {.where = path.string(),
                 .why = why,
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
