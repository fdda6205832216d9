#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

namespace diaphane {

/// The cause of an expected failure. All programs share this small list, so that an HTTP status, a
/// gRPC status, an exit code and a sentence for the user can each be derived from it in one place.
enum class ErrorCode {
  kInvalid,          ///< the request or the data is invalid; retrying will not help
  kUnauthenticated,  ///< nobody is signed in
  kForbidden,        ///< signed in, but not allowed (never used to reveal that a thing exists)
  kNotFound,         ///< does not exist or belongs to someone else
  kConflict,         ///< conflicts with another change
  kTooLarge,         ///< exceeds a limit or a quota
  kTooMany,          ///< rate limited; retry later
  kUnsupported,      ///< well-formed, but not supported by Diaphane
  kUnavailable,      ///< a required service is unavailable; retry
  kOutcomeUnknown,   ///< the connection was lost before a change was confirmed
  kOutOfMemory,      ///< out of device or host memory
  kDeviceLost,       ///< the accelerator's context is broken
  kInternal,         ///< a bug in Diaphane
};

std::string_view to_string(ErrorCode code);

/// An expected failure as a value. `message` is a sentence for the person who caused it. It never
/// contains patient data (no name, identifier, date, description or file name of a scan).
struct Error {
  ErrorCode code = ErrorCode::kInternal;
  std::string message;
  std::string field;  ///< JSON path of the invalid parameter ("lights[2].radiance"), or empty
};

template <typename T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> fail(ErrorCode code, std::string message, std::string field = {}) {
  return tl::unexpected<Error>(Error{code, std::move(message), std::move(field)});
}

}  // namespace diaphane
