// vitrine-mirror-oracle: what the held-out pictures of known mirrors would be if a mirrored ray saw the surfels of an opaque
// scene without those of the mirror, and behind them a far field that is solved from training photos. Nothing of the scene is
// trained.
#include <cstdio>
#include <exception>

#include "core/foundation/base/error.h"
#include "core/foundation/base/json.h"
#include "core/foundation/config/cli.h"
#include "tests/bench/optics/oracle/mirror_oracle.h"

namespace {

using namespace vitrine;

int run(const std::vector<std::string>& words) {
  MirrorOracleDesc desc;
  std::string sfm, objects, opaque, trained, truth;
  bool help = false;
  CommandLine cli(
      "vitrine-mirror-oracle", "--sfm DIR --objects DIR --opaque DIR [options]",
      "PSNR of held-out pixels of known mirrors: opaque surfels, trained layers, and near and far field without training.");
  cli.section("artifacts");
  cli.value("sfm", 0, "DIR", sfm, "Of the sfm stage.");
  cli.value("objects", 0, "DIR", objects, "Of the objects stage.");
  cli.value("opaque", 0, "DIR", opaque, "Of the optimize stage with layers=diffuse.");
  cli.value("trained", 0, "DIR", trained, "Of the optimize stage with all layers, to compare with.");
  cli.value("truth", 0, "DIR", truth, "truth/ of the scene: its mesh takes the place of shapes.");
  cli.section("what");
  cli.flag("trained-shapes", 0, desc.trained_shapes, "Shapes as --trained left them, not as the objects stage found them.");
  cli.value("rays", 0, "N", desc.rays, 1, "N x N rays a pixel. Default: 3.");
  cli.value("rounds", 0, "N", desc.rounds, 0, "Rounds of the solver of the far field. Default: 10; 0: none, it is black.");
  cli.value("texels", 0, "N", desc.texels, 1, "Side of the octahedral map of the far field. Default: 128.");
  cli.value("degree", 0, "N", desc.sh_degree, 0, "Degree of the spherical harmonics that mirrors see. Default: 0.");
  cli.flag("help", 'h', help, "Print this text.");
  cli.parse(words, 0);
  if (help) {
    std::fputs(cli.help().c_str(), stdout);
    return 0;
  }
  desc.sfm = sfm, desc.objects = objects, desc.opaque = opaque;
  if (!trained.empty()) desc.trained = trained;
  if (!truth.empty()) desc.truth = truth;
  const nlohmann::ordered_json figures = mirror_oracle(desc);
  std::printf("%s\n", figures.dump(1).c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run({argv + 1, argv + argc});
  } catch (const vitrine::Error& e) {
    std::fprintf(stderr, "%s\n", e.with_prefix().c_str());
    return vitrine::exit_code(e.kind());
  } catch (const std::exception& e) {
    std::fprintf(stderr, "error: %s\n", e.what());
    return 1;
  }
}
