#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/result.h"
#include "volume/label_set.h"
#include "volume/volume.h"

namespace diaphane::volume {

/// What a voxel of a scan shows, as ingest finds it.
enum class Label : std::uint8_t {
  kOutside,  ///< air around the patient
  kBody,     ///< the patient, with a margin of air that interpolation at the skin needs
  kSupport,  ///< table, headrest, frame or straps
  kMetal,    ///< metal inside the body
  kBrain,    ///< the brain, with the fluid around it, in MR
};

/// Returns a header and run lengths. Each run is the byte of its label and its number of voxels as
/// LEB128.
std::string encode(const Labels& labels);

/// Reads what encode() returned for a volume of `size`. Returns kInvalid if the bytes are damaged,
/// have another version, contain a label above `most`, or belong to a volume of another size.
/// Allocates no more than one byte per voxel of `size`, whatever the bytes say.
Result<Labels> decode(std::string_view bytes, std::array<std::uint32_t, 3> size,
                      std::uint8_t most = static_cast<std::uint8_t>(Label::kBrain));

/// Returns kInvalid if decode() would refuse the bytes as values of Label. Allocates nothing.
Result<void> check_labels(std::string_view bytes, std::array<std::uint32_t, 3> size);

/// Returns the largest possible size of encoded labels: a run of two bytes for each voxel.
std::uint64_t most_label_bytes(const Header& header);

/// Return whether the labels of a volume mark some voxels as support, or as brain.
bool has_support(const Volume& volume);
bool has_brain(const Volume& volume);

/// Number of the brain among the labels of a volume, far above those that files of labels use.
inline constexpr std::uint32_t kBrainNumber =
    0xFFFFFF00U + static_cast<std::uint32_t>(Label::kBrain);

/// Adds the brain that ingest has found to the label set, so that renderers can show it like a
/// label that somebody has marked. Voxels with such a label keep it. Does nothing if there is no
/// brain, or if the label set is full.
void list_found_labels(Volume& volume);

/// Sets all voxels that show nothing of the patient to the volume's minimum. Without labels it
/// changes nothing. Returns kInvalid, and changes nothing, if the labels are damaged.
Result<void> hide_surroundings(Volume& volume);

}  // namespace diaphane::volume
