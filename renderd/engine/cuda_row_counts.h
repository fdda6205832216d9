#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace diaphane::render::cuda {

/// How many samples the rows of a film have. Launches go from the top down and may be stopped
/// between two, so upper rows can be ahead: a staircase that falls from the top, flat when a batch
/// is whole. Pure.
class RowCounts {
 public:
  /// Rows [first, last) and what they need next.
  struct Piece {
    std::uint32_t first_row, last_row;
    std::uint64_t film_sample;  ///< that they have
    std::uint32_t samples;      ///< to be added
  };

  explicit RowCounts(std::uint32_t rows = 1) : steps_{{rows, 0}} {}

  std::uint32_t rows() const { return steps_.back().last_row; }
  /// That all rows have.
  std::uint64_t least() const { return steps_.back().samples; }
  bool flat() const { return steps_.size() == 1; }
  std::uint64_t of(std::uint32_t row) const {
    return std::find_if(steps_.begin(), steps_.end(), [row](Step s) { return row < s.last_row; })
        ->samples;
  }

  /// What brings the lowest rows nearer to `target` > least(), by at most `most`: never beyond the
  /// rows above, so that no sample of a pixel is taken twice.
  Piece next(std::uint64_t target, std::uint32_t most) const {
    const std::uint64_t have = least();
    std::uint64_t wanted = std::min<std::uint64_t>(target - have, most);
    std::uint32_t first = 0;
    if (!flat()) {
      const Step& above = steps_[steps_.size() - 2];
      first = above.last_row;
      wanted = std::min(wanted, above.samples - have);
    }
    return {first, steps_.back().last_row, have, static_cast<std::uint32_t>(wanted)};
  }

  /// The first `rows` rows of `piece`, which is what next() said, are done.
  void done(const Piece& piece, std::uint32_t rows) {
    const std::uint32_t last_row = std::min(piece.first_row + rows, piece.last_row);
    const std::uint64_t samples = piece.film_sample + piece.samples;
    const Step below = steps_.back();
    steps_.pop_back();
    if (!steps_.empty() && steps_.back().samples == samples) {
      steps_.back().last_row = last_row;
    } else {
      steps_.push_back({last_row, samples});
    }
    if (last_row != below.last_row) steps_.push_back(below);
  }

 private:
  struct Step {
    std::uint32_t last_row;
    std::uint64_t samples;
  };
  std::vector<Step> steps_;  ///< from the top, samples strictly falling
};

}  // namespace diaphane::render::cuda
