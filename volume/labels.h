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
  kBone,     ///< bone with its marrow, in CT
  kLung,     ///< the air of the lungs, with their smallest vessels, in CT
  kAirway,   ///< the air of the windpipe and the large bronchi, in CT
  kVessel,   ///< vessels and chambers of the heart with contrast medium, in CT
};
inline constexpr Label kLastLabel = Label::kVessel;

/// Returns whether a voxel with this label shows the patient, and not what surrounds them.
constexpr bool is_body(std::uint8_t label) {
  return label != static_cast<std::uint8_t>(Label::kOutside) &&
         label != static_cast<std::uint8_t>(Label::kSupport);
}

/// Returns a header and run lengths. Each run is the byte of its label and its number of voxels as
/// LEB128.
std::string encode(const Labels& labels);

/// Reads what encode() returned for a volume of `size`. Returns kInvalid if the bytes are damaged,
/// have another version, contain a label above `most`, or belong to a volume of another size.
/// Allocates no more than one byte per voxel of `size`, whatever the bytes say.
Result<Labels> decode(std::string_view bytes, std::array<std::uint32_t, 3> size,
                      std::uint8_t most = static_cast<std::uint8_t>(kLastLabel));

/// Returns kInvalid if decode() would refuse the bytes as values of Label. Allocates nothing.
Result<void> check_labels(std::string_view bytes, std::array<std::uint32_t, 3> size);

/// Returns the largest possible size of encoded labels: a run of two bytes for each voxel.
std::uint64_t most_label_bytes(const Header& header);

/// Return whether the labels of a volume mark some voxels as support, or as brain.
bool has_support(const Volume& volume);
bool has_brain(const Volume& volume);

/// A part of the body that ingest finds and that is listed like a label that somebody has marked.
struct FoundPart {
  Label label;
  const char* name;                    ///< for command lines; the page has its own texts
  std::array<std::uint8_t, 3> colour;  ///< sRGB

  /// Its number among the labels of a volume, far above those that files of labels use.
  constexpr std::uint32_t number() const { return 0xFFFFFF00U + static_cast<std::uint32_t>(label); }
};
inline constexpr std::array<FoundPart, 5> kFoundParts{{
    {Label::kBrain, "brain", {222, 178, 160}},
    {Label::kBone, "bone", {236, 226, 200}},
    {Label::kLung, "lungs", {214, 170, 172}},
    {Label::kAirway, "airways", {150, 200, 232}},
    {Label::kVessel, "vessels", {196, 48, 44}},
}};
inline constexpr std::uint32_t kBrainNumber = kFoundParts[0].number();

/// Returns the part with this number, or null if the number is of a label that somebody has marked.
const FoundPart* found_part(std::uint32_t number);

/// Returns the name of a label, or that of the part that ingest has found under its number.
std::string name_of(const LabelEntry& entry);

/// Adds the parts that ingest has found to the label set, so that renderers can show them like
/// labels that somebody has marked. Voxels with such a label keep it. Parts without voxels, those
/// that are listed already and those for which the label set has no room are left out.
void list_found_labels(Volume& volume);

/// Extends bone and vessels that ingest has found by one voxel in every direction into voxels
/// without a label, for pictures. They interpolate between voxels, and so show the surface of dense
/// parts half in the voxels next to them, whose own values are low. Returns whether there are such
/// parts. Precondition: list_found_labels().
bool widen_dense_parts(Volume& volume);

/// Sets all voxels that show nothing of the patient to the volume's minimum. Without labels it
/// changes nothing. Returns kInvalid, and changes nothing, if the labels are damaged.
Result<void> hide_surroundings(Volume& volume);

}  // namespace diaphane::volume
