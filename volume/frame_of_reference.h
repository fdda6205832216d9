#pragma once

#include <string>
#include <string_view>

#include "common/result.h"

namespace diaphane::volume {

/// Two files with the same frame of reference place things in the same space of one patient. The
/// identifier is on every image of an examination, so volumes keep only a salted hash of it, which
/// links neither two scans nor a scan and a hospital's records.

/// Returns a hash of the UID with a new salt, or an empty string for an empty UID. Returns
/// kUnsupported in a build without libsodium.
Result<std::string> hidden_frame_of_reference(const std::string& uid);

/// Whether a stored hash may be that of this UID. If either is empty, it is unknown and may be. The
/// page sends UIDs in disguise (disguised_uid), so both forms are compared.
bool is_frame_of_reference(const std::string& hidden, const std::string& uid);

/// Whether a text has the form of what hidden_frame_of_reference() returns.
bool is_hidden_frame_of_reference(std::string_view text);

/// Returns the UID that the page sends in place of another one: "2.25." and, as a decimal number,
/// the first 16 bytes of its SHA-256. A UID that begins with "2.25." stays.
std::string disguised_uid(const std::string& uid);

}  // namespace diaphane::volume
