#include "api/handlers/problem_document.h"

#include <nlohmann/json.hpp>

namespace diaphane::api {

ProblemForm form_of(ProblemKind kind) {
  switch (kind) {
    case ProblemKind::kBadRequest:
      return {"bad-request", 400, "The request cannot be read"};
    case ProblemKind::kInvalid:
      return {"invalid", 422, "The request is wrong"};
    case ProblemKind::kUnauthenticated:
      return {"unauthenticated", 401, "Not signed in"};
    case ProblemKind::kWrongCredentials:
      return {"wrong-credentials", 401, "Wrong address or password"};
    case ProblemKind::kCodeNeeded:
      return {"code-needed", 401, "A code is needed, too"};
    case ProblemKind::kWrongCode:
      return {"wrong-code", 401, "Wrong code"};
    case ProblemKind::kDisabled:
      return {"disabled", 403, "Account switched off"};
    case ProblemKind::kCsrf:
      return {"csrf", 403, "Token missing or wrong"};
    case ProblemKind::kOrigin:
      return {"origin", 403, "From another page"};
    case ProblemKind::kForbidden:
      return {"forbidden", 403, "Not allowed"};
    case ProblemKind::kSecondFactorRequired:
      return {"second-factor-required", 403, "A second factor is needed first"};
    case ProblemKind::kNotFound:
      return {"not-found", 404, "Not found"};
    case ProblemKind::kMethodNotAllowed:
      return {"method-not-allowed", 405, "Method not allowed"};
    case ProblemKind::kConflict:
      return {"conflict", 409, "Another change came first"};
    case ProblemKind::kNotReady:
      return {"not-ready", 409, "Not ready"};
    case ProblemKind::kNotAnonymised:
      return {"not-anonymised", 409, "Not made anonymous yet"};
    case ProblemKind::kPrecondition:
      return {"precondition", 412, "It was changed meanwhile"};
    case ProblemKind::kPreconditionRequired:
      return {"precondition-required", 428, "If-Match is needed"};
    case ProblemKind::kOffsetMismatch:
      return {"offset-mismatch", 409, "The upload stands elsewhere"};
    case ProblemKind::kUploadComplete:
      return {"upload-complete", 409, "The upload is complete"};
    case ProblemKind::kUploadExpired:
      return {"upload-expired", 410, "The upload has expired"};
    case ProblemKind::kLinkExpired:
      return {"link-expired", 410, "The link has expired"};
    case ProblemKind::kLocked:
      return {"locked", 423, "In use"};
    case ProblemKind::kChecksumMismatch:
      return {"checksum-mismatch", 460, "The checksum does not fit"};
    case ProblemKind::kTusVersion:
      return {"tus-version", 412, "Another version of tus"};
    case ProblemKind::kOverQuota:
      return {"over-quota", 413, "Over the quota"};
    case ProblemKind::kTooManyDataSets:
      return {"too-many-data-sets", 409, "Too many scans"};
    case ProblemKind::kRenderTimeSpent:
      return {"render-time-spent", 403, "No picture time left"};
    case ProblemKind::kUploadTooLarge:
      return {"upload-too-large", 413, "The upload is too large"};
    case ProblemKind::kBodyTooLarge:
      return {"body-too-large", 413, "The body is too large"};
    case ProblemKind::kStorageFull:
      return {"storage-full", 507, "The server's disk is full"};
    case ProblemKind::kMediaType:
      return {"media-type", 415, "Another media type is needed"};
    case ProblemKind::kIdempotencyKeyReused:
      return {"idempotency-key-reused", 422, "The key was used for something else"};
    case ProblemKind::kTooMany:
      return {"too-many", 429, "Too many"};
    case ProblemKind::kTooManyAttempts:
      return {"too-many-attempts", 429, "Too many attempts"};
    case ProblemKind::kNoWorker:
      return {"no-worker", 503, "No render worker is free"};
    case ProblemKind::kBusy:
      return {"busy", 503, "Busy"};
    case ProblemKind::kUnavailable:
      return {"unavailable", 503, "A part is away"};
    case ProblemKind::kOutcomeUnknown:
      return {"outcome-unknown", 503, "The change may or may not have been saved"};
    case ProblemKind::kInternal:
      break;
  }
  return {"internal", 500, "A fault of ours"};
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
