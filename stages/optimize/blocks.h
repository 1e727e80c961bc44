// A capture that is split by place (optimize.blocks), for scenes that outgrow the memory of one training.
//
// The plan is divided into cells by vertical planes: the cameras are halved at a right angle to the direction in which they are
// spread the most, until there are as many cells as blocks. Outer cells are unbounded. A block is trained on all photos that see
// enough of its cell, with what else they see; of its surfels those whose centre lies in the cell remain. The surfels of all
// cells are the scene. Splitting by place, with photos assigned by what they see: Lin et al., "VastGaussian" (CVPR 2024).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "stages/optimize/optimize.h"

namespace vitrine {

class BlockCells {
 public:
  // `centres`: of the cameras, scene units. Throws Error{Usage} if they do not fall into `blocks` places.
  BlockCells(std::span<const Vec3d> centres, int blocks);
  size_t size() const { return count_; }
  size_t cell_of(const Vec3d& position) const;

 private:
  struct Cut {
    Vec2d direction;            // horizontal, unit
    double offset = 0;          // below: first
    int first = 0, second = 0;  // >= 0: a cut; else ~cell
  };
  int split(std::span<const Vec3d> centres, std::vector<uint32_t> cameras, int blocks);
  std::vector<Cut> cuts_;
  int root_ = 0;
  size_t count_ = 0;
};

struct Block {
  std::vector<uint8_t> photos;  // [view] 1: trains the block
  size_t photo_count = 0;
  double photo_share = 0;  // of all training photos
  double point_share = 0;  // of all sparse points, those that its photos see
};

struct BlockPlan {
  BlockCells cells;
  std::vector<Block> blocks;
};

// `train`: training views of the whole capture. Throws Error{Usage} if a block gets too few photos, Error{Input} without sparse
// points.
BlockPlan planned_blocks(const ViewSet& views, std::span<const uint32_t> train, int blocks);

// Steps and surfels of one block: a photo is looked at as often, and surfels are as dense, as in a training of the whole.
OptimizeConfig config_of_block(const OptimizeConfig& whole, const Block& block);

// Options that blocks exclude; empty: none.
std::string blocks_problem(const OptimizeConfig& config);

void train_in_blocks(const OptimizeConfig& config, StageContext& context);

}  // namespace vitrine
