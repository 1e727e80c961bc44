// Exhaustive descriptor matching as one fused matrix product: for two photos with n1 and n2 SIFT descriptors (128 bytes each) it
// forms the n1 x n2 inner products block by block and keeps only the best two of every row and column.
//
// Same rules as COLMAP's brute-force matcher, so that its thresholds apply: descriptors have length 512, the distance is the
// angle d = acos(min(1, <a, b> / 512^2)); a match is kept when d1 <= kMaxMatchAngle and d1 < kMaxMatchRatio * d2 (d2 = second
// best, pi/2 when there is none), for the row and for the column, and each is the best match of the other (cross-check). Ties go
// to the lower index. All sums are integers: AVX2, AVX-512 VNNI and the scalar rule give bit-identical matches.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace vitrine {

inline constexpr size_t kDescriptorBytes = 128;

struct Match {
  uint32_t a = 0, b = 0;  // indices of descriptors in photo a and photo b
  bool operator==(const Match&) const = default;
};

inline constexpr double kMaxMatchRatio = 0.8;  // of angles, best over second best; lower is stricter
inline constexpr double kMaxMatchAngle = 0.7;  // between two matching descriptors, radians

enum class MatchKernel { Automatic, Avx2, Avx512Vnni };
bool available(MatchKernel kernel);  // on this machine

// Descriptors in the memory layout of the kernels. Build once per photo, use for every pair.
class PackedDescriptors {
 public:
  PackedDescriptors() = default;
  explicit PackedDescriptors(std::span<const uint8_t> descriptors, MatchKernel kernel = MatchKernel::Automatic);  // [n * 128]
  size_t size() const { return count_; }

 private:
  friend std::vector<Match> match(const PackedDescriptors&, const PackedDescriptors&);
  size_t count_ = 0, padded_ = 0;  // padded to whole panels with zero descriptors
  MatchKernel kernel_ = MatchKernel::Avx2;
  std::vector<int8_t> signed_rows_;         // VNNI: descriptor - 128, row by row
  std::vector<uint8_t> panels_;             // VNNI: [vector of 16][32 quads][16 columns][4 bytes]
  std::vector<int32_t> offsets_;            // VNNI: 128 * sum of a column's bytes, compensates for the -128 of the rows
  std::vector<int16_t> rows16_, panels16_;  // AVX2: rows, and [vector of 8][64 pairs][8 columns][2 values]
};

// Matches in the order of `a`. Both must have been packed for the same kernel.
std::vector<Match> match(const PackedDescriptors& a, const PackedDescriptors& b);

}  // namespace vitrine
