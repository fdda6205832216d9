#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

/// What the REST side refuses, and why: finer than ErrorCode, because a program on the other side
/// acts on it. handlers/problem_document.h makes RFC 9457 documents of it.
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
  kNotFound,
  kMethodNotAllowed,
  kConflict,
  kNotReady,
  kNotAnonymised,
  kPrecondition,
  kPreconditionRequired,
  kOffsetMismatch,
  kUploadComplete,
  kUploadExpired,
  kLinkExpired,
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
  kNoWorker,
  kBusy,
  kUnavailable,
  kOutcomeUnknown,
  kInternal,
};

/// One wrong part of a request: a JSON path, or the name of a header or query parameter.
struct FieldProblem {
  std::string field;
  std::string message;
};

struct Problem {
  ProblemKind kind = ProblemKind::kInternal;
  std::string detail;  ///< a sentence for the person; never anything of a scan
  std::vector<FieldProblem> fields;
  std::chrono::seconds retry_after{0};  ///< 0: not said
};

template <typename T>
using Outcome = tl::expected<T, Problem>;

inline tl::unexpected<Problem> refuse(ProblemKind kind, std::string detail,
                                      std::chrono::seconds retry_after = {}) {
  return tl::unexpected<Problem>(Problem{kind, std::move(detail), {}, retry_after});
}
/// kInvalid with one field named.
tl::unexpected<Problem> refuse_field(std::string field, std::string message);

/// The problem that an adapter's expected failure becomes, where nothing finer is known.
Problem from_error(const Error& error);
inline tl::unexpected<Problem> refuse(const Error& error) {
  return tl::unexpected<Problem>(from_error(error));
}

}  // namespace diaphane::api
