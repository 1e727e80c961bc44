#include "stages/stage_cli.h"

#include <algorithm>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/process.h"
#include "core/foundation/config/text.h"

namespace vitrine {

namespace {

const StageInput& declared(const StageInfo& info, const std::string& name) {
  std::vector<std::string> names;
  for (const StageInput& input : info.inputs) {
    if (input.name == name) return input;
    names.push_back(input.name);
  }
  const std::string near = nearest_word(name, names);
  throw Error(ErrorKind::Usage, fmt::format("stage '{}' has no input '{}'", info.name, name),
              {.where = "--input",
               .why = fmt::format("its inputs are: {}", fmt::join(names, ", ")),
               .hint = near.empty() ? fmt::format("vitrine-{} --help", info.name) : fmt::format("--input {}=PATH", near),
               .code = "BAD_INPUT_NAME"});
}

ResolvedInput resolve_artifact(const StageInfo& info, const std::string& name, fs::path path, DigestCache& digests) {
  if (const auto key = current_key(path, name)) path = store_of(path) / name / *key;
  const fs::path manifest_file = path / kManifestName;
  if (!fs::exists(manifest_file)) return {path, digests.digest_tree(path)};
  const Manifest manifest = manifest_from_json(read_file(manifest_file), manifest_file.string());
  if (manifest.stage != name)
    throw Error(ErrorKind::Input,
                fmt::format("input '{}' of stage '{}' is an artifact of stage '{}'", name, info.name, manifest.stage),
                {.where = path.string(), .hint = fmt::format("give the artifact of '{}'", name), .code = "WRONG_ARTIFACT"});
  ArtifactStore store(path.parent_path().parent_path());
  if (const std::string damage = store.damage(path); !damage.empty())
    throw Error(ErrorKind::Input, fmt::format("the artifact of stage '{}' is damaged", name),
                {.where = path.string(),
                 .why = damage,
                 .hint = fmt::format("run the pipeline again: '{}' is computed anew", name),
                 .code = "DAMAGED_ARTIFACT"});
  return {path, manifest.content_digest};
}

// The digest of a path, and of the files that it refers to, by their paths from its folder.
std::string external_digest(const StageInput& input, const fs::path& path, DigestCache& digests) {
  const std::vector<fs::path> also = input.also != nullptr ? input.also(path) : std::vector<fs::path>{};
  if (also.empty()) return digests.digest_tree(path);
  std::vector<OutputFile> files{{path.filename().generic_string(), 0, digests.digest_tree(path)}};
  for (const fs::path& file : also)
    files.push_back({file.lexically_relative(path.parent_path()).generic_string(), 0, digests.digest(file)});
  return content_digest_of(files);
}

}  // namespace

std::map<std::string, ResolvedInput> resolve_inputs(const StageInfo& info, const std::vector<std::string>& words,
                                                    DigestCache& digests) {
  std::map<std::string, ResolvedInput> inputs;
  for (const std::string& word : words) {
    const size_t equals = word.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == word.size())
      throw Error(
          ErrorKind::Usage, fmt::format("expected NAME=PATH, got \"{}\"", word),
          {.where = "--input", .hint = fmt::format("vitrine-{} --help lists the names", info.name), .code = "BAD_INPUT_NAME"});
    const StageInput& input = declared(info, word.substr(0, equals));
    const std::string& name = input.name;
    fs::path path = fs::absolute(word.substr(equals + 1)).lexically_normal();
    if (input.meant != nullptr) path = input.meant(path);
    std::error_code ec;
    if (!fs::exists(path, ec))
      throw Error(ErrorKind::Input, fmt::format("input '{}' of stage '{}' does not exist", name, info.name),
                  {.where = path.string(), .why = input.doc, .hint = "check the path", .code = "MISSING_INPUT"});
    if (inputs.contains(name))
      throw Error(ErrorKind::Usage, fmt::format("input '{}' is given twice", name),
                  {.where = "--input", .hint = "leave one of them out", .code = "BAD_INPUT_NAME"});
    inputs[name] =
        input.artifact ? resolve_artifact(info, name, path, digests) : ResolvedInput{path, external_digest(input, path, digests)};
  }
  for (const StageInput& input : info.inputs)
    if (!input.optional && !inputs.contains(input.name))
      throw Error(ErrorKind::Usage, fmt::format("stage '{}' needs the input '{}'", info.name, input.name),
                  {.why = input.doc, .hint = fmt::format("--input {}=PATH", input.name), .code = "MISSING_INPUT"});
  return inputs;
}

}  // namespace vitrine
