#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "api/service/problem.h"
#include "api/service/secrets.h"

/// What tus 1.0 (https://tus.io/protocols/resumable-upload, core, creation, checksum) says about
/// one request, as pure functions: what to do is decided here, done in uploads.cpp.
namespace diaphane::api::tus {

inline constexpr std::string_view kVersion = "1.0.0";
inline constexpr std::string_view kExtensions = "creation,checksum,expiration,termination";
inline constexpr std::string_view kChecksums = "sha1,sha256";
inline constexpr std::int64_t kMaxPartBytes = 8 * 1024 * 1024;

/// A POST as it came; absent headers are empty.
struct CreationRequest {
  std::string_view length;    ///< Upload-Length
  std::string_view metadata;  ///< Upload-Metadata
};

struct Creation {
  std::int64_t length = 0;  ///< at least 1
  /// Decoded; any bytes. What a client says of its file (its name above all) is read here and kept
  /// nowhere: the caller takes what it knows.
  std::map<std::string, std::string, std::less<>> metadata;
};

/// kInvalid: a header is malformed, or the length is left for later (creation-defer-length is not
/// spoken: size and quota are checked before the first byte).
Outcome<Creation> plan_creation(const CreationRequest& request);

/// Where an upload stands.
struct Standing {
  std::int64_t length = 0;  ///< announced
  std::int64_t received = 0;
  bool taken = false;  ///< complete and handed on, or never to be: nothing is appended any more
  bool expired = false;
};

/// A PATCH as it came; absent headers are empty.
struct PartRequest {
  std::string_view offset;    ///< Upload-Offset
  std::string_view checksum;  ///< Upload-Checksum
  std::int64_t bytes = 0;     ///< of the body
};

struct Checksum {
  DigestKind kind = DigestKind::kSha1;
  std::string digest;  ///< raw bytes
};

/// Write the body at `offset`, if `checksum` (when there is one) fits it.
struct Part {
  std::int64_t offset = 0;
  std::optional<Checksum> checksum;
  bool completes = false;
};

/// kInvalid (a header is malformed, the body goes beyond the announced length), kOffsetMismatch,
/// kUploadExpired, kUploadComplete, kBodyTooLarge. A part that starts and ends at the end of a
/// complete upload is granted: it is what a client sends again that never got the last answer.
Outcome<Part> plan_part(const Standing& standing, const PartRequest& request);

/// kInvalid: not of the form `<algorithm> <base64>`, or an algorithm that is not in kChecksums.
Outcome<Checksum> parse_checksum(std::string_view header);
bool fits(const Checksum& checksum, std::string_view bytes);

}  // namespace diaphane::api::tus
