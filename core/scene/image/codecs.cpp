#include "core/scene/image/codecs.h"

#include <dlfcn.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"

namespace vitrine {

namespace {

const Codecs* load() {
  // Next to the executable, else in the build folder (for executables elsewhere).
  const fs::path built = VITRINE_CODECS, installed = fs::read_symlink("/proc/self/exe").parent_path() / built.filename();
  std::error_code none;
  const fs::path path = fs::exists(installed, none) ? installed : built;
  void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  const void* const found = library ? dlsym(library, "vitrine_codecs") : nullptr;
  if (!found) {
    const char* const why = dlerror();
    throw Error(ErrorKind::Dependency, "the codecs of pictures cannot be loaded",
                {.where = path.string(),
                 .why = why ? why : "",
                 .hint = "build vitrine anew (cmake --build); its programs and this library belong together",
                 .code = "NO_CODECS"});
  }
  return static_cast<const Codecs*>(found);
}

}  // namespace

const Codecs& codecs() {
  static const Codecs* const loaded = load();
  return *loaded;
}

}  // namespace vitrine
