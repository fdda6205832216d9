#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "volume/label_set.h"

namespace diaphane::volume {

enum class Modality { kOther, kCt, kMr, kPt };

/// What distinguishes the phases of a scan, and the unit of Phase::value.
enum class PhaseKind {
  kIndex,   ///< only the order is known; the value is the index
  kTime,    ///< ms since the first phase
  kCycle,   ///< percent of a heartbeat or breath
  kEcho,    ///< echo time in ms
  kBValue,  ///< diffusion weighting in s/mm²
};

struct Phase {
  PhaseKind kind = PhaseKind::kIndex;
  double value = 0;
  bool operator==(const Phase&) const = default;
};

/// Maximum number of phases of a scan. Functional MR has several hundred.
inline constexpr std::uint32_t kMostPhases = 1000;

/// The metadata that Diaphane keeps of a scan. This is an allow-list (design: ingest, "Nothing that
/// identifies is kept").
struct Header {
  std::array<std::uint32_t, 3> size{};     ///< voxels along x, y, z
  std::array<double, 3> spacing{1, 1, 1};  ///< mm
  /// Row-major. The columns are the unit vectors of the x, y and z axes in the patient's coordinate
  /// system (LPS). Orthonormal with determinant +1: a left-handed stack is stored with one axis
  /// reversed, so that a picture is never mirrored.
  std::array<double, 9> direction{1, 0, 0, 0, 1, 0, 0, 0, 1};
  Modality modality = Modality::kOther;
  double window_center = 0;  ///< in units of the voxels
  double window_width = 0;   ///< 0 means unknown
  std::int32_t minimum = 0;
  std::int32_t maximum = 0;
  std::array<double, 8> percentiles{};  ///< percentiles 1, 10, 25, 50, 75, 90, 99 and 99.9
  std::string content_hash;             ///< empty until stored
  std::vector<std::string> repairs;     ///< corrections made by ingest, in plain language
  /// Position of the scan in the patient's space: the centre of voxel (0, 0, 0) in mm (LPS), for
  /// placing labels from other files. Absent in volumes that were stored before labels existed.
  std::optional<std::array<double, 3>> origin;
  /// Identifier of that space, stored only as a salted hash (frame_of_reference.h). Empty: unknown.
  std::string frame_of_reference;
  std::string label_hash;  ///< hash of the stored label set; empty: none
  /// Empty, or at least 2: the scan shows one region at several times, echoes or b-values.
  std::vector<Phase> phases;
  /// Number of slices that refine_slices() made of each stored one. Not stored.
  std::uint32_t interpolated = 1;

  /// Number of voxels of one phase.
  std::uint64_t voxel_count() const { return std::uint64_t{size[0]} * size[1] * size[2]; }
  std::uint32_t phase_count() const {
    return phases.empty() ? 1 : static_cast<std::uint32_t>(phases.size());
  }
  /// Number of voxels of all phases.
  std::uint64_t total_voxel_count() const { return voxel_count() * phase_count(); }
};

/// Voxel (x, y, z) is voxels[x + size[0] * (y + size[1] * z)]. Its centre is at index (x, y, z) +
/// 1/2 in the box [0, size]. Values are Hounsfield units for CT and stored units otherwise.
struct Volume {
  Header header;
  /// One phase if read() returned the volume. All phases, one after the other, as ingest builds
  /// and stores them.
  std::vector<std::int16_t> voxels;
  std::uint32_t phase = 0;  ///< index of the phase in `voxels`, if it is a single one
  std::string id;  ///< name of its directory in the store, or empty if it is not from the store
  bool surroundings_hidden = false;  ///< hide_surroundings() was called
  std::string labels;  ///< encoded Labels (labels.h), or empty: everything counts as body
  LabelSet label_set;  ///< structures that somebody has marked; empty: none
};

/// Voxels without content, such as padding or the corners next to straightened slices.
struct Filler {
  std::int16_t value = 0;
  std::uint64_t count = 0;
};

/// Computes minimum, maximum and percentiles from all voxels that the volume holds. Excludes
/// `filler.count` voxels with the value `filler.value`, or all of them if there are fewer, unless
/// `filler.count` covers all voxels.
void measure(Volume& volume, const Filler& filler = {});

/// Reads `volume.json`, one phase of `voxels.i16` and, if they exist, `labels` and `label_set` from
/// `directory`. Returns kNotFound if the volume does not exist, kInvalid if the files are malformed
/// or do not match each other or the scan has no such phase, kUnavailable if the disk cannot be
/// read, and kOutOfMemory. `verify_hash` also checks the content hash of all phases; a mismatch is
/// kInternal, because the disk must be broken.
Result<Volume> read(const std::string& directory, bool verify_hash, std::uint32_t phase = 0);
/// Like read(), with the voxels of all phases.
Result<Volume> read_all_phases(const std::string& directory, bool verify_hash);
/// Reduces a volume that holds all phases to one of them. Returns kInvalid, and changes nothing, if
/// the scan has no such phase.
Result<void> keep_phase(Volume& volume, std::uint32_t phase);
/// Returns kInvalid, with the number of phases, if the scan has no phase `phase`.
Result<void> check_phase(const Header& header, std::uint32_t phase);
/// Reads only `volume.json`. The errors are those of read().
Result<Header> read_header(const std::string& directory);

/// Returns the labels of a stored volume, still encoded, or an empty string if it has none. The
/// errors are those of read().
Result<std::string> read_labels(const std::string& directory, const Header& header);

/// Returns the label set of a stored volume, which is empty if it has none. The errors are those of
/// read().
Result<LabelSet> read_label_set(const std::string& directory, const Header& header);
/// Stores an encoded label set with a volume and replaces an earlier one. Each file is replaced in
/// one step, the header last, so that a reader that finds the new label_hash finds the new labels.
/// Returns kNotFound if there is no volume.
Result<void> write_label_set(const std::string& encoded, const std::string& directory);
/// Permanently removes the label set of a volume. Does nothing if there is none.
Result<void> remove_label_set(const std::string& directory);

/// Writes the files under a temporary name next to `directory`, syncs and renames, so that a
/// reader never sees a partial volume. Expects the voxels of all phases. Fills content_hash.
/// Returns kConflict if `directory` exists.
Result<void> write(Volume& volume, const std::string& directory);

/// Permanently replaces the volume in `directory`. Writes and syncs the new volume like write(),
/// exchanges the two in one atomic step, and then truncates and removes the old files, so that a
/// reader sees either the old or the new volume completely. Calls `about_to` before the exchange,
/// when content_hash is filled, and changes nothing if it fails. If the process ends in between,
/// sweep_unfinished() removes the rest, which has a temporary name. Returns kNotFound if there is
/// no old volume.
Result<void> replace(Volume& volume, const std::string& directory,
                     const std::function<Result<void>()>& about_to);

}  // namespace diaphane::volume
