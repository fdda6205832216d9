#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/result.h"

namespace diaphane::volume {

enum class Modality { kOther, kCt, kMr, kPt };

/// What is kept of a scan: an allow-list (design: ingest, "Nothing that identifies is kept").
struct Header {
  std::array<std::uint32_t, 3> size{};     ///< voxels along x, y, z
  std::array<double, 3> spacing{1, 1, 1};  ///< mm
  /// Row-major; columns are the unit axes of x, y, z in the patient's space (LPS). Orthonormal,
  /// determinant +1: a left-handed stack is stored with one axis reversed, so a picture is never
  /// mirrored.
  std::array<double, 9> direction{1, 0, 0, 0, 1, 0, 0, 0, 1};
  Modality modality = Modality::kOther;
  double window_center = 0;
  double window_width = 0;  ///< 0: unknown
  std::int32_t minimum = 0;
  std::int32_t maximum = 0;
  std::array<double, 8> percentiles{};  ///< at 1, 10, 25, 50, 75, 90, 99, 99.9 %
  std::string content_hash;             ///< empty until stored
  std::vector<std::string> repairs;     ///< in plain words

  std::uint64_t voxel_count() const { return std::uint64_t{size[0]} * size[1] * size[2]; }
};

/// Voxel (x, y, z) is voxels[x + size[0] * (y + size[1] * z)]; its centre is at index (x, y, z) +
/// 1/2 of the box [0, size]; values are Hounsfield units for CT, stored units otherwise.
struct Volume {
  Header header;
  std::vector<std::int16_t> voxels;
  std::string id;  ///< the name of its directory in the store; empty when it is from elsewhere
};

/// Voxels that stand for nothing: a picture's padding, the corners beside straightened slices.
struct Filler {
  std::int16_t value = 0;
  std::uint64_t count = 0;
};

/// Fills minimum, maximum and percentiles from the voxels, leaving out `filler.count` of those that
/// have `filler.value` (all there are, if they are fewer).
void measure(Volume& volume, const Filler& filler = {});

/// Reads `volume.json` and `voxels.i16` from `directory`; refuses what does not fit together.
/// `verify_hash` recomputes the content hash (a wrong one is kInternal: the disk is broken).
Result<Volume> read(const std::string& directory, bool verify_hash);
Result<Header> read_header(const std::string& directory);

/// Writes both files under a temporary name beside `directory`, syncs and renames, so that a reader
/// never sees half a volume. Fills content_hash. kConflict when `directory` exists.
Result<void> write(Volume& volume, const std::string& directory);

/// Puts `volume` in the place of the one that is in `directory`, for good: written and synced as
/// by write(), exchanged with the old one in one step, then the old one's files are emptied and
/// removed. A reader sees either the old or the new one whole. Before the exchange `about_to` is
/// asked, with content_hash filled; when it fails nothing is changed. Ended in between, what is
/// left over lies under a temporary name, for sweep_unfinished(). kNotFound when there is no old
/// one.
Result<void> replace(Volume& volume, const std::string& directory,
                     const std::function<Result<void>()>& about_to);

}  // namespace diaphane::volume
