#pragma once

#include <string>
#include <string_view>

#include "api/routing/message.h"
#include "api/shared/problem.h"

namespace diaphane::api {

/// The wire form of a problem kind. This is the only table from kinds to HTTP statuses.
struct ProblemForm {
  std::string_view slug;  ///< the part after "urn:diaphane:problem:"
  int status;
  std::string_view title;
};
ProblemForm form_of(ProblemKind kind);

/// Returns the RFC 9457 document, with Retry-After if the problem has one.
Response problem_response(const Problem& problem, const std::string& request_id);

}  // namespace diaphane::api
