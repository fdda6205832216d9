#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ingest/dicom/walk.h"

namespace diaphane::dicom {

/// Tag of the Frame of Reference UID. Objects with the same UID share a coordinate system.
inline constexpr std::uint32_t kFrameOfReferenceUid = 0x00200052;

// Values of a data set whose structure walk() has checked. Everything is little endian, so a big
// endian file must be refused before. A missing or malformed value is nullopt or empty.

/// Returns the first element with this tag, or null.
const DataElement* find(const DataSet& set, std::uint32_t tag);
/// Returns the items of a sequence, or none.
std::span<const DataSet> items_of(const DataSet& set, std::uint32_t tag);
/// Returns the only or first item of a sequence, or null.
const DataSet* first_item(const DataSet& set, std::uint32_t tag);

/// Returns a text without padding.
std::string text_of(const DataSet& set, std::uint32_t tag);
/// Returns decimal strings as numbers, at most `most` + 1 of them. Returns an empty vector if one
/// of them is not a finite number.
std::vector<double> decimals_of(const DataSet& set, std::uint32_t tag, std::size_t most);
/// Returns unsigned 16-bit numbers.
std::vector<std::uint16_t> shorts_of(const DataSet& set, std::uint32_t tag);
/// Returns the only unsigned 16-bit number.
std::optional<std::uint16_t> short_of(const DataSet& set, std::uint32_t tag);
/// Returns the only integer string, at least 0.
std::optional<std::uint32_t> integer_of(const DataSet& set, std::uint32_t tag);

}  // namespace diaphane::dicom
