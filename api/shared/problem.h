#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

/// The errors of the REST API. They are more specific than ErrorCode, because clients act on them.
/// routing/problem_document.h turns them into RFC 9457 documents.
namespace diaphane::api {

enum class ProblemKind {
  kBadRequest,
  kInvalid,
  kUnauthenticated,
  kWrongCredentials,
  kCodeNeeded,
  kWrongCode,
  kDisabled,
  kCsrf,
  kOrigin,
  kForbidden,
  kSecondFactorRequired,
  kConsentNeeded,
  kNotFound,
  kMethodNotAllowed,
  kConflict,
  kNotReady,
  kNotAnonymised,
  kNotAligned,
  kPrecondition,
  kPreconditionRequired,
  kOffsetMismatch,
  kUploadComplete,
  kUploadExpired,
  kLinkExpired,
  kStudyClosed,
  kStudyFull,
  kParticipationEnded,
  kLocked,
  kChecksumMismatch,
  kTusVersion,
  kOverQuota,
  kTooManyDataSets,
  kRenderTimeSpent,
  kUploadTooLarge,
  kBodyTooLarge,
  kStorageFull,
  kMediaType,
  kIdempotencyKeyReused,
  kTooMany,
  kTooManyAttempts,
  kArchiveUnreachable,
  kArchiveRefused,
  kArchiveFaulty,
  kNoWorker,
  kBusy,
  kUnavailable,
  kOutcomeUnknown,
  kInternal,
};

/// One invalid part of a request: a JSON path, or the name of a header or query parameter.
struct FieldProblem {
  std::string field;
  std::string message;
};

struct Problem {
  ProblemKind kind = ProblemKind::kInternal;
  std::string detail;  ///< a sentence for the user, never with data from a scan
  std::vector<FieldProblem> fields;
  std::chrono::seconds retry_after{0};  ///< 0 omits the header
};

template <typename T>
using Outcome = tl::expected<T, Problem>;

inline tl::unexpected<Problem> refuse(ProblemKind kind, std::string detail,
                                      std::chrono::seconds retry_after = {}) {
  return tl::unexpected<Problem>(Problem{kind, std::move(detail), {}, retry_after});
}
/// Returns kInvalid with a single field.
tl::unexpected<Problem> refuse_field(std::string field, std::string message);

/// Converts an expected failure of an adapter for which no more specific kind is known.
Problem from_error(const Error& error);
inline tl::unexpected<Problem> refuse(const Error& error) {
  return tl::unexpected<Problem>(from_error(error));
}

}  // namespace diaphane::api
