#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "api/shared/problem.h"
#include "api/shared/secrets.h"

/// The rules of tus 1.0 (https://tus.io/protocols/resumable-upload; core, creation, checksum) for
/// one request, as pure functions. They decide what to do, and Uploads carries it out.
namespace diaphane::api::tus {

inline constexpr std::string_view kVersion = "1.0.0";
inline constexpr std::string_view kExtensions = "creation,checksum,expiration,termination";
inline constexpr std::string_view kChecksums = "sha1,sha256";
inline constexpr std::int64_t kMaxPartBytes = 8 * 1024 * 1024;

/// A POST request. Absent headers are empty.
struct CreationRequest {
  std::string_view length;    ///< Upload-Length
  std::string_view metadata;  ///< Upload-Metadata
};

struct Creation {
  std::int64_t length = 0;  ///< at least 1
  /// Decoded metadata with arbitrary bytes. Information about the client's file, especially its
  /// name, is parsed here but never stored. The caller uses only the keys that it knows.
  std::map<std::string, std::string, std::less<>> metadata;
};

/// Parses the headers. Returns kInvalid for a malformed header or a deferred length: the size is
/// checked before the first byte, so creation-defer-length is not supported.
Outcome<Creation> plan_creation(const CreationRequest& request);

/// The progress of an upload.
struct UploadProgress {
  std::int64_t length = 0;  ///< announced
  std::int64_t received = 0;
  bool taken = false;  ///< complete and queued, or cancelled; accepts no more data
  bool expired = false;
};

/// A PATCH request. Absent headers are empty.
struct PartRequest {
  std::string_view offset;    ///< Upload-Offset
  std::string_view checksum;  ///< Upload-Checksum
  std::int64_t bytes = 0;     ///< of the body
};

struct Checksum {
  DigestKind kind = DigestKind::kSha1;
  std::string digest;  ///< raw bytes
};

/// An accepted part: its body is written at `offset` if it matches `checksum` (if present).
struct Part {
  std::int64_t offset = 0;
  std::optional<Checksum> checksum;
  bool completes = false;
};

/// Checks a part. Returns kInvalid (a malformed header or a body beyond the announced length),
/// kOffsetMismatch, kUploadExpired, kUploadComplete or kBodyTooLarge. An empty part at the end of a
/// complete upload is accepted, because a client sends it again if the last response was lost.
Outcome<Part> plan_part(const UploadProgress& progress, const PartRequest& request);

/// Returns kInvalid unless the header is `<algorithm> <base64>` with an algorithm in kChecksums.
Outcome<Checksum> parse_checksum(std::string_view header);
bool fits(const Checksum& checksum, std::string_view bytes);

}  // namespace diaphane::api::tus
