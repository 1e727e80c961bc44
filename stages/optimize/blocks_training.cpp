// Trains the blocks one after the other, each with its own checkpoint, and joins what remains of them. A finished block is a file
// of surfels in the scratch folder, and is not trained again after an interruption.
#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/process.h"
#include "core/render/model/layered_model.h"
#include "core/render/picture/part_labels.h"
#include "core/render/picture/trained_scene.h"
#include "core/scene/image/exr.h"
#include "stages/optimize/blocks.h"
#include "stages/optimize/outputs.h"
#include "stages/optimize/plane_inpainting.h"
#include "stages/optimize/surroundings.h"
#include "stages/optimize/training_part.h"

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;

// What remains of a block. `facts`: its row in the report.
struct TrainedBlock {
  SplatLayer surfels;
  size_t unseen = 0;  // the last surfels: guesses about what no photo of the block shows
  Json facts;
};

// Throws Error{Usage} for captures of an object whose surroundings move: they have no places.
void check_stands_still(const OptimizeConfig& config, const StageContext& context) {
  const Passes passes = read_passes(context.input("sfm"));
  std::error_code none;
  const auto masks = context.optional_input("masks");
  const bool object = masks && fs::is_directory(*masks / "masks/object", none);
  if (passes.size() < 2 && (!object || config.surroundings == WantedSurroundings::Train)) return;
  throw Error(ErrorKind::Usage, "an object that is photographed by itself is not split into blocks",
              {.why = passes.size() > 1 ? fmt::format("{}: the surroundings stand elsewhere in each", passes_text(passes))
                                        : "there are masks of an object, whose surroundings may move",
               .hint = passes.size() > 1 ? "leave out --blocks"
                                         : "leave out --blocks, or --set optimize.surroundings=train if all stands still",
               .code = "BLOCKS_OF_OBJECT"});
}

// The surfels of the cell, without the guesses; then the guesses.
TrainedBlock inside_cell(const Trainer& trainer, const BlockCells& cells, size_t block) {
  const SplatLayer& all = trainer.scene().diffuse;
  std::vector<uint8_t> inside(all.size());
  TrainedBlock out;
  for (size_t i = 0; i < all.size(); ++i) {
    const float* m = all.at(Attribute::Mean, i);
    inside[i] = cells.cell_of({m[0], m[1], m[2]}) == block;
    out.unseen += inside[i] && i >= all.size() - trainer.unseen_surfels();
  }
  out.surfels = kept_surfels(all, inside);
  return out;
}

TrainedBlock trained_block(const OptimizeConfig& whole, const BlockPlan& plan, size_t b, const fs::path& folder,
                           StageContext& context) {
  const Block& block = plan.blocks[b];
  const OptimizeConfig config = config_of_block(whole, block);
  const Capture capture = load_part(context.input("sfm"), whole.max_side, whole.holdout_every, block.photos);
  const auto normals = context.optional_input("normals");
  Targets targets = load_targets(capture, context.optional_input("masks"),
                                 LabelledObjects::trusted(context.optional_input("objects")), normals);
  for (const TargetProblem& problem : targets.warnings)
    context.warning(problem.code, fmt::format("block {}: {}", b + 1, problem.text));
  const bool layered = chosen_layers(whole.layers, targets.any(MaskClass::Specular), targets.any(MaskClass::Transparent)).any();
  targets.forget(MaskClass::Object);
  check_memory(config, capture, context);
  LazyDepth depth(config, capture, known_depth_of(capture, targets, normals), context);
  const ShapeSet no_shapes;
  const TrainerSetup setup{
      .config = config, .capture = capture, .targets = targets, .shapes = no_shapes, .glass = no_shapes, .layers = {}};
  const double share = 1 / double(plan.blocks.size());
  const TrainingPart part{fmt::format("block {} of {}, ", b + 1, plan.blocks.size()), double(b) * share, share,
                          folder / "checkpoint.bin"};
  const std::unique_ptr<Trainer> trainer = started(setup, part.checkpoint, depth, context);
  depth.forget();
  train(config, capture, *trainer, part, context);
  TrainedBlock out = inside_cell(*trainer, plan.cells, b);
  out.facts = {{"train_photos", capture.train.size()},
               {"iterations", trainer->step_index()},
               {"initial_surfels", trainer->initial_surfels()},
               {"max_surfels", config.max_gaussians},
               {"trained_surfels", trainer->scene().diffuse.size()},
               {"surfels", out.surfels.size()},
               {"unseen_surfels", out.unseen},
               {"glass_or_mirrors", layered}};
  return out;
}

// nullopt if the block is not finished, or its file is damaged.
std::optional<TrainedBlock> finished_block(const fs::path& folder, StageContext& context) {
  std::error_code none;
  if (!fs::exists(folder / "block.json", none)) return std::nullopt;
  try {
    TrainedBlock block{.surfels = read_layer(folder / "surfels.ply"), .facts = Json::parse(read_file(folder / "block.json"))};
    block.unseen = block.facts.at("unseen_surfels").get<size_t>();
    if (block.surfels.size() == block.facts.at("surfels").get<size_t>() && block.unseen <= block.surfels.size()) return block;
    context.warning("CHECKPOINT_IGNORED", fmt::format("{} has another number of surfels", folder.string()));
  } catch (const std::exception& e) {
    context.warning("CHECKPOINT_IGNORED", fmt::format("{}: {}", folder.string(), e.what()));
  }
  return std::nullopt;
}

TrainedBlock block_of(const OptimizeConfig& config, const BlockPlan& plan, size_t b, StageContext& context) {
  const fs::path folder = context.scratch() / fmt::format("block_{}", b + 1);
  if (auto finished = finished_block(folder, context)) return std::move(*finished);
  make_folders(folder);
  TrainedBlock block = trained_block(config, plan, b, folder, context);
  write_layer(folder / "surfels.ply", block.surfels);
  write_file(folder / "block.json", block.facts.dump() + "\n");  // last: with it the block is finished
  fs::remove(folder / "checkpoint.bin");
  context.checkpoint(double(b + 1) / double(plan.blocks.size()));
  return block;
}

// All surfels that photos show, block by block, before all guesses (PaneOptions::mirrored).
SplatLayer joined_blocks(const OptimizeConfig& config, const std::vector<TrainedBlock>& blocks) {
  size_t size = 0;
  for (const TrainedBlock& b : blocks) size += b.surfels.size();
  SplatLayer out(LayerKind::Diffuse, config.sh_degree, size);
  size_t to = 0;
  for (const bool guesses : {false, true})
    for (const TrainedBlock& b : blocks) {
      const size_t seen = b.surfels.size() - b.unseen;
      for (size_t i = guesses ? seen : 0; i < (guesses ? b.surfels.size() : seen); ++i, ++to)
        for (const AttributeRow& row : kAttributes) std::copy_n(b.surfels.at(row.id, i), out.width(row.id), out.at(row.id, to));
    }
  return out;
}

ImageOptions options_of(const OptimizeConfig& config, const Capture& cameras, size_t seen) {
  ImageOptions options = PhaseClock(config.phases, {}, 1).image_options(config.shading, config.backend, config.sh_degree);
  options.diffuse.near_z = cameras.near_z;
  if (config.fill_unseen) options.panes.mirrored = seen;
  return options;
}

// PSNR of every held-out photo, read one after the other, and a preview of the middle one.
std::vector<PhotoQuality> measured(const OptimizeConfig& config, const SplatScene& scene, const ImageOptions& options,
                                   const Capture& cameras, StageContext& context) {
  const LayeredModel model{options};
  std::vector<PhotoQuality> result;
  Frame frame;
  frame.differentiable = false;
  std::vector<float> target;
  const uint32_t shown = cameras.heldout.empty() ? 0 : cameras.heldout[cameras.heldout.size() / 2];
  for (uint32_t v : cameras.heldout) {
    throw_if_interrupted();
    const View& view = cameras.view_set.views[v];
    const PhotoPyramid photo = make_photo(view, read_exr_rgb(linear_image_path(context.input("sfm"), view)), config.max_side);
    model.forward(scene, photo.levels[0].view, options, frame);
    decode(photo.levels[0], target);
    result.push_back({v, frame_psnr(frame, target)});
    if (v == shown) write_preview(context.output() / "optimize/previews/joined.png", frame, target);
  }
  return result;
}

void label_objects(const Capture& cameras, SplatScene& scene, const StageContext& context) {
  std::vector<View> seen;
  for (uint32_t v : cameras.train) seen.push_back(cameras.view_set.views[v]);
  const LabelledObjects known = LabelledObjects::known(context.optional_input("objects"));
  assign_objects(known.objects(), labelled_views(known, seen), cameras.near_z, scene.diffuse, scene.transmittance);
}

}  // namespace

void train_in_blocks(const OptimizeConfig& config, StageContext& context) {
  check_stands_still(config, context);
  const Capture cameras = load_cameras(context.input("sfm"), config.holdout_every);
  const BlockPlan plan = planned_blocks(cameras.view_set, cameras.train, config.blocks);
  std::vector<TrainedBlock> blocks;
  BlocksReport report{.config = config, .cameras = cameras};
  bool layered = false;
  for (size_t b = 0; b < plan.blocks.size(); ++b) {
    log_info("block {} of {}: {} of {} photos", b + 1, plan.blocks.size(), plan.blocks[b].photo_count, cameras.train.size());
    blocks.push_back(block_of(config, plan, b, context));
    report.blocks.push_back(blocks.back().facts);
    report.unseen += blocks.back().unseen;
    layered = layered || blocks.back().facts.value("glass_or_mirrors", false);
  }
  if (layered)
    context.warning("BLOCKS_ARE_OPAQUE",
                    "glass and mirrors are trained as opaque: layers of blocks cannot be joined yet (leave out --blocks)");
  SplatScene scene{.diffuse = joined_blocks(config, blocks)};
  blocks.clear();
  report.surfels = scene.diffuse.size();
  const ImageOptions options = options_of(config, cameras, report.surfels - report.unseen);
  make_folders(context.output() / "optimize/previews");
  report.heldout = measured(config, scene, options, cameras, context);
  label_objects(cameras, scene, context);
  write_layer(context.output() / "gaussians/diffuse.ply", scene.diffuse);
  write_image_options(context.output() / "optimize/model.json", options);
  write_views(context.output() / "optimize/views.json", config, cameras, false);
  write_report(context.output() / "optimize/report.json", report);
  context.metric("surfels", double(report.surfels));
  std::string text = fmt::format("{} blocks, {:.0f}k surfels", plan.blocks.size(), double(report.surfels) / 1000);
  if (!report.heldout.empty()) {
    context.metric("heldout_psnr", mean_psnr(report.heldout));
    text += fmt::format(", held-out PSNR {:.2f} dB", mean_psnr(report.heldout));
  }
  context.summary(text);
}

}  // namespace vitrine
