#include "api/shared/problem.h"

namespace diaphane::api {
namespace {

ProblemKind kind_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalid:
      return ProblemKind::kInvalid;
    case ErrorCode::kUnauthenticated:
      return ProblemKind::kUnauthenticated;
    case ErrorCode::kForbidden:
      return ProblemKind::kForbidden;
    case ErrorCode::kNotFound:
      return ProblemKind::kNotFound;
    case ErrorCode::kConflict:
      return ProblemKind::kConflict;
    case ErrorCode::kTooLarge:
      return ProblemKind::kOverQuota;
    case ErrorCode::kTooMany:
      return ProblemKind::kTooMany;
    case ErrorCode::kUnsupported:
      return ProblemKind::kInvalid;
    case ErrorCode::kUnavailable:
    case ErrorCode::kOutOfMemory:
    case ErrorCode::kDeviceLost:
      return ProblemKind::kUnavailable;
    case ErrorCode::kOutcomeUnknown:
      return ProblemKind::kOutcomeUnknown;
    case ErrorCode::kInternal:
      return ProblemKind::kInternal;
  }
  return ProblemKind::kInternal;
}

}  // namespace

tl::unexpected<Problem> refuse_field(std::string field, std::string message) {
  return tl::unexpected<Problem>(Problem{ProblemKind::kInvalid,
                                         "The request contains invalid values.",
                                         {{std::move(field), std::move(message)}},
                                         {}});
}

Problem from_error(const Error& error) {
  Problem problem{kind_of(error.code), error.message, {}, {}};
  if (problem.kind == ProblemKind::kInternal) {
    problem.detail = "Something went wrong on our side. The error has been logged.";
  }
  if (problem.kind == ProblemKind::kUnavailable || problem.kind == ProblemKind::kOutcomeUnknown) {
    problem.retry_after = std::chrono::seconds(2);
  }
  if (problem.kind == ProblemKind::kTooMany) problem.retry_after = std::chrono::seconds(10);
  if (!error.field.empty()) problem.fields.push_back({error.field, error.message});
  return problem;
}

}  // namespace diaphane::api
