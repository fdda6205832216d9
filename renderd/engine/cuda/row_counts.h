#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace diaphane::render::cuda {

/// The number of samples of each row of a film. Launches go from top to bottom and may stop before
/// the last row, so upper rows can have more samples. The numbers never increase from top to
/// bottom, and are equal after a whole batch.
class RowCounts {
 public:
  /// Rows [first, last) and the samples that they need next.
  struct Piece {
    std::uint32_t first_row, last_row;
    std::uint64_t film_sample;  ///< number of samples that the rows have
    std::uint32_t samples;      ///< number of samples to add
  };

  explicit RowCounts(std::uint32_t rows = 1) : steps_{{rows, 0}} {}

  std::uint32_t rows() const { return steps_.back().last_row; }
  /// Returns the number of samples of the rows with the fewest.
  std::uint64_t least() const { return steps_.back().samples; }
  bool flat() const { return steps_.size() == 1; }
  std::uint64_t of(std::uint32_t row) const {
    return std::find_if(steps_.begin(), steps_.end(), [row](Step s) { return row < s.last_row; })
        ->samples;
  }

  /// Returns the work that brings the lowest rows nearer to `target` > least(), by at most `most`
  /// samples. The rows never overtake those above them, so no pixel gets a sample twice.
  Piece next(std::uint64_t target, std::uint32_t most) const {
    const std::uint64_t have = least();
    std::uint64_t samples = std::min<std::uint64_t>(target - have, most);
    std::uint32_t first = 0;
    if (!flat()) {
      const Step& above = steps_[steps_.size() - 2];
      first = above.last_row;
      samples = std::min(samples, above.samples - have);
    }
    return {first, steps_.back().last_row, have, static_cast<std::uint32_t>(samples)};
  }

  /// Records that the first `rows` rows of `piece`, a result of next(), are done.
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
  std::vector<Step> steps_;  ///< from the top, with strictly decreasing samples
};

}  // namespace diaphane::render::cuda
