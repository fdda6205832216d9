#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "renderd/film/part.h"

// Decides how one picture is divided among devices, and which share each device renders. Pure
// functions of measurements.

namespace diaphane::render {

/// How several devices render one picture together.
enum class Division {
  kAverage,  ///< each renders the whole picture with different samples (thesis 5.1.2)
  kTiles     ///< each renders a band of rows (thesis 8.2)
};

/// The relative costs of rows, learned from bands: the middle of a head takes longer than the air
/// above it. Independent of the height of the picture.
class RowCosts {
 public:
  static constexpr std::size_t kBins = 64;

  RowCosts() : bins_(kBins, 1.0) {}
  /// Learns from a band [first, last) of a picture of `height` rows that took `seconds` per sample
  /// on a device that takes `total_seconds` for all rows.
  void learn(std::uint32_t first, std::uint32_t last, std::uint32_t height, double seconds,
             double total_seconds);
  /// Returns the fraction of the whole picture's cost that rows [first, last) have.
  double share_of(std::uint32_t first, std::uint32_t last, std::uint32_t height) const;

 private:
  std::vector<double> bins_;  ///< costs from the top; their mean is about 1
};

/// Returns one share per device, or nullopt for a device that gets none. With kAverage, shares are
/// parts of the sequence `sequence`. With kTiles, they are bands that take equally long at these
/// speeds and contain every row once. Each device gets at least one unit of rows if there are
/// enough units. `speeds` has the speed of each device in any unit, or 0 for a device that gets no
/// share. At least one speed must be positive.
std::vector<std::optional<Share>> plan_shares(Division division, Canvas canvas,
                                              const std::vector<double>& speeds,
                                              const RowCosts& costs, std::uint64_t sequence);

/// Costs of parts whose pixels are on another GPU of the host, in seconds per part and per pixel.
/// Measured with two and with four H200 (docs/figures.md, `many`).
inline constexpr double kPartSeconds = 0.6e-3;
inline constexpr double kMergeSeconds = 0.03e-9;
/// By how much the slowest band exceeds its even share of the time, per additional device. Measured
/// like the costs above.
inline constexpr double kBandsUneven = 0.15;

/// The input of choose_division().
struct DivisionInput {
  Canvas canvas;
  double samples = 16;             ///< samples per pixel that the picture needs
  std::vector<double> speeds;      ///< pixel samples per second; the first device shows the picture
  double bytes_per_second = 1e12;  ///< throughput for all parts together
  double merge_seconds = kMergeSeconds;  ///< per pixel, on the device that shows the picture
  double part_seconds = kPartSeconds;    ///< per part, without its pixels
  /// Length of a turn of the device that shows the picture, which takes parts between its turns; 0:
  /// it takes them at once.
  double turn_seconds = 0;
  /// Division of the previous picture, which is kept unless the other one is faster.
  std::optional<Division> before;
};

struct DivisionGain {
  double seconds = 0;      ///< time until the picture has DivisionInput::samples
  double bytes_moved = 0;  ///< bytes of the parts that devices transfer to each other
};

/// Predicts the time until the devices have drawn all samples and the last part is merged.
DivisionGain predict(Division division, const DivisionInput& input);
/// Chooses tiles if they are a tenth faster. A lost device takes its band with it, which others
/// must render again; with an average only its speed is lost. Once chosen, tiles stay until an
/// average is faster, because measurements scatter and each change costs time. Chooses an average
/// while speeds are unknown.
Division choose_division(const DivisionInput& input);

/// The input of the decision whether a device delivers its part now.
struct PartInput {
  std::uint64_t held = 0;       ///< samples rendered since the last part
  std::uint64_t delivered = 0;  ///< samples of this task delivered before
  double seconds_since = 0;     ///< since the last part or the start of the task
  double seconds_cost = 0;      ///< time that the last delivery took; 0: unknown
  bool room = true;             ///< the last part was taken
};
/// Returns whether a part is due. The first pair of samples is due at once, and later parts
/// whenever the samples held are a quarter of those delivered, or after 100 ms. Deliveries take at
/// most an eighth of the time.
bool part_due(const PartInput& input);
/// Returns whether a device may continue while its part has not been taken. It stops after as many
/// samples again, because no one waits for more.
bool may_render(const PartInput& input);

}  // namespace diaphane::render
