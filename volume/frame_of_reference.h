#pragma once

#include <string>
#include <string_view>

#include "common/result.h"

namespace diaphane::volume {

/// Files with the same frame of reference use the same coordinates of one patient. The identifier
/// is on every image of an examination, so volumes keep only a salted hash of it, which links
/// neither two scans nor a scan and a hospital's records.

/// Returns a hash of the UID with a new salt, or an empty string for an empty UID. Returns
/// kUnsupported in a build without libsodium.
Result<std::string> hidden_frame_of_reference(const std::string& uid);

/// Returns whether a stored hash may be that of this UID, which is true if either is empty
/// (unknown). The page sends UIDs in disguise (disguised_uid), so both forms are compared.
bool is_frame_of_reference(const std::string& hidden, const std::string& uid);

/// Returns whether a text has the form of a result of hidden_frame_of_reference().
bool is_hidden_frame_of_reference(std::string_view text);

/// Returns the UID that the page sends in place of another one: "2.25." and, as a decimal number,
/// the first 16 bytes of its SHA-256. A UID that begins with "2.25." is not changed.
std::string disguised_uid(const std::string& uid);

}  // namespace diaphane::volume
