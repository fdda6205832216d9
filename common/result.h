#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

namespace diaphane {

/// Why an expected failure happened. One small list for all programs, so that an HTTP status, a
/// gRPC status, an exit code and a sentence for the user can each be derived from it in one place.
enum class ErrorCode {
  kInvalid,          ///< the request or the data is wrong; trying again will not help
  kUnauthenticated,  ///< nobody is signed in
  kForbidden,        ///< signed in, but not allowed (never used to reveal that a thing exists)
  kNotFound,         ///< does not exist, or is somebody else's
  kConflict,         ///< another change came first
  kTooLarge,         ///< over a limit or a quota
  kTooMany,          ///< rate limited; try later
  kUnsupported,      ///< well-formed, but not something that Diaphane does
  kUnavailable,      ///< a part that is needed is away; try again
  kOutcomeUnknown,   ///< a part went away before it confirmed a change: it may have been made
  kOutOfMemory,      ///< device or host memory
  kDeviceLost,       ///< the accelerator's context is broken
  kInternal,         ///< a defect of ours
};

std::string_view to_string(ErrorCode code);

/// An expected failure as a value. `message` is a sentence for the person who caused it; it never
/// holds patient data (no name, identifier, date, description, file name of a scan).
struct Error {
  ErrorCode code = ErrorCode::kInternal;
  std::string message;
  std::string field;  ///< which parameter is wrong, as a JSON path ("lights[2].radiance"), or empty
};

template <typename T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> fail(ErrorCode code, std::string message, std::string field = {}) {
  return tl::unexpected<Error>(Error{code, std::move(message), std::move(field)});
}

}  // namespace diaphane
