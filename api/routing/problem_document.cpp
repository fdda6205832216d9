#include "api/routing/problem_document.h"

#include <nlohmann/json.hpp>

namespace diaphane::api {

ProblemForm form_of(ProblemKind kind) {
  switch (kind) {
    case ProblemKind::kBadRequest:
      return {"bad-request", 400, "Malformed request"};
    case ProblemKind::kInvalid:
      return {"invalid", 422, "Invalid request"};
    case ProblemKind::kUnauthenticated:
      return {"unauthenticated", 401, "Not signed in"};
    case ProblemKind::kWrongCredentials:
      return {"wrong-credentials", 401, "Incorrect email address or password"};
    case ProblemKind::kCodeNeeded:
      return {"code-needed", 401, "Authentication code required"};
    case ProblemKind::kWrongCode:
      return {"wrong-code", 401, "Incorrect code"};
    case ProblemKind::kDisabled:
      return {"disabled", 403, "Account disabled"};
    case ProblemKind::kCsrf:
      return {"csrf", 403, "CSRF token missing or incorrect"};
    case ProblemKind::kOrigin:
      return {"origin", 403, "Origin not allowed"};
    case ProblemKind::kForbidden:
      return {"forbidden", 403, "Not allowed"};
    case ProblemKind::kConsentNeeded:
      return {"consent-needed", 403, "Consent needed"};
    case ProblemKind::kSecondFactorRequired:
      return {"second-factor-required", 403, "Two-factor authentication required"};
    case ProblemKind::kNotFound:
      return {"not-found", 404, "Not found"};
    case ProblemKind::kMethodNotAllowed:
      return {"method-not-allowed", 405, "Method not allowed"};
    case ProblemKind::kConflict:
      return {"conflict", 409, "Conflict"};
    case ProblemKind::kNotReady:
      return {"not-ready", 409, "Not ready"};
    case ProblemKind::kNotAnonymised:
      return {"not-anonymised", 409, "Not anonymised yet"};
    case ProblemKind::kNotAligned:
      return {"not-aligned", 409, "Not aligned yet"};
    case ProblemKind::kPrecondition:
      return {"precondition", 412, "Changed in the meantime"};
    case ProblemKind::kPreconditionRequired:
      return {"precondition-required", 428, "If-Match required"};
    case ProblemKind::kOffsetMismatch:
      return {"offset-mismatch", 409, "Wrong upload offset"};
    case ProblemKind::kUploadComplete:
      return {"upload-complete", 409, "Upload already complete"};
    case ProblemKind::kUploadExpired:
      return {"upload-expired", 410, "Upload expired"};
    case ProblemKind::kLinkExpired:
      return {"link-expired", 410, "Link expired"};
    case ProblemKind::kStudyClosed:
      return {"study-closed", 410, "Study closed"};
    case ProblemKind::kStudyFull:
      return {"study-full", 410, "Study full"};
    case ProblemKind::kParticipationEnded:
      return {"participation-ended", 410, "Participation ended"};
    case ProblemKind::kLocked:
      return {"locked", 423, "In use"};
    case ProblemKind::kChecksumMismatch:
      return {"checksum-mismatch", 460, "Checksum mismatch"};
    case ProblemKind::kTusVersion:
      return {"tus-version", 412, "Unsupported tus version"};
    case ProblemKind::kOverQuota:
      return {"over-quota", 413, "Storage quota exceeded"};
    case ProblemKind::kTooManyDataSets:
      return {"too-many-data-sets", 409, "Too many scans"};
    case ProblemKind::kRenderTimeSpent:
      return {"render-time-spent", 403, "No rendering time left"};
    case ProblemKind::kUploadTooLarge:
      return {"upload-too-large", 413, "Upload too large"};
    case ProblemKind::kBodyTooLarge:
      return {"body-too-large", 413, "Request body too large"};
    case ProblemKind::kStorageFull:
      return {"storage-full", 507, "Server storage full"};
    case ProblemKind::kMediaType:
      return {"media-type", 415, "Unsupported media type"};
    case ProblemKind::kIdempotencyKeyReused:
      return {"idempotency-key-reused", 422, "Idempotency-Key already used"};
    case ProblemKind::kTooMany:
      return {"too-many", 429, "Too many"};
    case ProblemKind::kTooManyAttempts:
      return {"too-many-attempts", 429, "Too many attempts"};
    case ProblemKind::kArchiveUnreachable:
      return {"archive-unreachable", 502, "The archive does not respond"};
    case ProblemKind::kArchiveRefused:
      return {"archive-refused", 502, "The archive refused the request"};
    case ProblemKind::kArchiveFaulty:
      return {"archive-faulty", 502, "The archive sent an invalid response"};
    case ProblemKind::kNoWorker:
      return {"no-worker", 503, "No render worker available"};
    case ProblemKind::kBusy:
      return {"busy", 503, "Busy"};
    case ProblemKind::kUnavailable:
      return {"unavailable", 503, "Service unavailable"};
    case ProblemKind::kOutcomeUnknown:
      return {"outcome-unknown", 503, "The change may or may not have been saved"};
    case ProblemKind::kInternal:
      break;
  }
  return {"internal", 500, "Internal error"};
}

Response problem_response(const Problem& problem, const std::string& request_id) {
  const ProblemForm form = form_of(problem.kind);
  nlohmann::ordered_json document;
  document["type"] = "urn:diaphane:problem:" + std::string(form.slug);
  document["title"] = form.title;
  document["status"] = form.status;
  if (!problem.detail.empty()) document["detail"] = problem.detail;
  document["request_id"] = request_id;
  if (!problem.fields.empty()) {
    auto& errors = document["errors"] = nlohmann::ordered_json::array();
    for (const FieldProblem& field : problem.fields) {
      errors.push_back({{"field", field.field}, {"message", field.message}});
    }
  }
  Response response;
  response.status = form.status;
  response.content_type = "application/problem+json";
  response.body = document.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  response.with("Cache-Control", "no-store");
  if (problem.retry_after.count() > 0) {
    response.with("Retry-After", std::to_string(problem.retry_after.count()));
  }
  return response;
}

}  // namespace diaphane::api
