#pragma once

#include <string>
#include <string_view>

#include "api/handlers/message.h"
#include "api/service/problem.h"

namespace diaphane::api {

/// How a kind of problem looks on the wire: the one table from kinds to HTTP statuses.
struct ProblemForm {
  std::string_view slug;  ///< after "urn:diaphane:problem:"
  int status;
  std::string_view title;
};
ProblemForm form_of(ProblemKind kind);

/// The RFC 9457 document, with Retry-After when the problem says when.
Response problem_response(const Problem& problem, const std::string& request_id);

}  // namespace diaphane::api
