#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "renderd/film/part.h"

// Who renders what of one picture, and by which of the two ways it is divided. Pure: what was
// measured goes in, shares come out.

namespace diaphane::render {

/// How several devices make one picture.
enum class Division {
  kAverage,  ///< each the whole picture, of samples of its own (thesis 5.1.2)
  kTiles     ///< each a band of rows (thesis 8.2)
};

/// What rows cost against each other, learned from bands: a head's middle takes longer than the air
/// above it. Kept for a picture of any height.
class RowCosts {
 public:
  static constexpr std::size_t kBins = 64;

  RowCosts() : bins_(kBins, 1.0) {}
  /// A band [first, last) of `height` rows took `seconds` (of one sample per pixel) on a device
  /// that needs `whole` for all rows.
  void learn(std::uint32_t first, std::uint32_t last, std::uint32_t height, double seconds,
             double whole);
  /// The part of the whole picture's cost that rows [first, last) are.
  double share_of(std::uint32_t first, std::uint32_t last, std::uint32_t height) const;

 private:
  std::vector<double> bins_;  ///< from the top; their mean is about 1
};

/// One share for each device, nothing for one that is left without. Averaging: parts of the
/// sequence `sequence`. Tiles: bands that take equally long at these speeds, all with a unit of
/// rows at least while there are units; every row is in one of them. `speeds`: of the devices in
/// any unit; 0 is one that takes no part. At least one takes part.
std::vector<std::optional<Share>> plan_shares(Division division, Canvas canvas,
                                              const std::vector<double>& speeds,
                                              const RowCosts& costs, std::uint64_t sequence);

/// What parts cost where their pixels lie on another GPU of the host, measured with two and with
/// four H200 (docs/figures.md, `many`): seconds of each part, and of each of its pixels.
inline constexpr double kPartSeconds = 0.6e-3;
inline constexpr double kMergeSeconds = 0.03e-9;
/// There too: how much longer than its even share the slowest band takes, for each further device.
inline constexpr double kBandsUneven = 0.15;

/// What decides between the two.
struct DivisionQuestion {
  Canvas canvas;
  double samples = 16;             ///< per pixel, that the picture needs
  std::vector<double> speeds;      ///< pixels' samples a second; the first device shows the picture
  double bytes_per_second = 1e12;  ///< of what parts come over, all together
  double merge_seconds = kMergeSeconds;  ///< of one pixel, on the device that shows the picture
  double part_seconds = kPartSeconds;    ///< of one part, beside its pixels
  /// Parts are taken between the turns of the device that shows the picture, each so long; 0: at
  /// once.
  double turn_seconds = 0;
  /// How the picture before was divided: kept unless the other way is faster.
  std::optional<Division> before;
};

struct DivisionGain {
  double seconds = 0;  ///< to a picture of so many samples
  double bytes_moved = 0;
};

/// The time until the devices together have drawn the samples and the last of them are merged.
DivisionGain predict(Division division, const DivisionQuestion& question);
/// Tiles where they are a tenth faster: a device that is lost takes a band with it, which others
/// must render again, and costs an average nothing but its speed. Once taken they stay until an
/// average is faster: measurements scatter, and each change costs. Unknown speeds: an average.
Division choose_division(const DivisionQuestion& question);

/// Whether a device hands its part over now.
struct PartQuestion {
  std::uint64_t held = 0;       ///< samples that it has drawn since the last part
  std::uint64_t delivered = 0;  ///< of this task before
  double seconds_since = 0;     ///< since the last part or the task's begin
  double seconds_cost = 0;      ///< what handing one over took last; 0: unknown
  bool room = true;             ///< the last part was taken
};
/// The first pair at once; then with each fourth of what was delivered, but never so often that
/// more than an eighth of the time goes into it; at least each 100 ms.
bool part_due(const PartQuestion& question);
/// A device whose part is not taken goes on until it has as much again: nobody waits for more.
bool may_render(const PartQuestion& question);

}  // namespace diaphane::render
