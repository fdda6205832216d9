#include "operator/kube/api.h"

#include <cmath>
#include <cstdio>
#include <ctime>

#include "common/try.h"
#include "operator/kube/fields.h"

namespace diaphane::kube {
namespace {

using nlohmann::json;

/// A call takes milliseconds; one that takes longer than this is tried again.
constexpr std::chrono::milliseconds kTimeout{5000};

ErrorCode code_of(int status) {
  switch (status) {
    case 400:
    case 405:
    case 406:
    case 415:
    case 422:
      return ErrorCode::kInvalid;
    case 401:
      return ErrorCode::kUnauthenticated;
    case 403:
      return ErrorCode::kForbidden;
    case 404:
      return ErrorCode::kNotFound;
    case 409:
    case 410:
      return ErrorCode::kConflict;
    case 413:
      return ErrorCode::kTooLarge;
    case 429:
      return ErrorCode::kTooMany;
    default:
      return status >= 500 ? ErrorCode::kUnavailable : ErrorCode::kInternal;
  }
}

}  // namespace

Error error_of(int status, const json& body) {
  Error error;
  error.code = code_of(status);
  error.message = text(body, "message");
  if (error.message.empty())
    error.message = "the API server responded with status " + std::to_string(status);
  error.field = text(body, "reason");
  return error;
}

Result<json> Api::send(const Request& request) {
  auto answer = transport_.call(request, kTimeout);
  DIAPHANE_TRY(answer);
  json body = json::parse(answer->body, nullptr, false);
  if (answer->status < 200 || answer->status >= 300) {
    return tl::unexpected(error_of(answer->status, body));
  }
  if (!body.is_object()) {
    return fail(ErrorCode::kUnavailable, "the response of the API server is not valid JSON");
  }
  return body;
}

Result<json> Api::get(const std::string& path) { return send({.path = path}); }

Result<json> Api::create(const std::string& collection, const json& object) {
  return send({"POST", collection, "fieldManager=" + manager_, object.dump(), "application/json"});
}

Result<json> Api::apply(const std::string& path, const json& object, const std::string& part) {
  const std::string manager = part.empty() ? manager_ : manager_ + "-" + part;
  return send({"PATCH", path, "fieldManager=" + manager + "&force=true", object.dump(),
               "application/apply-patch+yaml"});
}

Result<json> Api::replace(const std::string& path, const json& object) {
  return send({"PUT", path, "fieldManager=" + manager_, object.dump(), "application/json"});
}

Result<json> Api::merge(const std::string& path, const json& patch) {
  return send(
      {"PATCH", path, "fieldManager=" + manager_, patch.dump(), "application/merge-patch+json"});
}

Result<void> Api::remove(const std::string& path, const Precondition& precondition) {
  json options = {{"apiVersion", "v1"},
                  {"kind", "DeleteOptions"},
                  {"propagationPolicy", "Background"},
                  {"preconditions", {{"uid", precondition.uid}}}};
  if (!precondition.version.empty()) {
    options["preconditions"]["resourceVersion"] = precondition.version;
  }
  const auto done = send({"DELETE", path, "", options.dump(), "application/json"});
  DIAPHANE_TRY(done);
  return {};
}

std::string time_text(double seconds_since_epoch) {
  const double whole_seconds = std::floor(seconds_since_epoch);
  auto seconds = static_cast<std::time_t>(whole_seconds);
  auto micro = std::lround((seconds_since_epoch - whole_seconds) * 1e6);
  if (micro >= 1000000) {
    micro -= 1000000;
    ++seconds;
  }
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  char day[32], text[64];
  std::strftime(day, sizeof day, "%Y-%m-%dT%H:%M:%S", &parts);
  std::snprintf(text, sizeof text, "%s.%06ldZ", day, micro);
  return text;
}

std::optional<double> time_of(const std::string& text) {
  std::tm parts{};
  const char* rest = strptime(text.c_str(), "%Y-%m-%dT%H:%M:%S", &parts);
  if (!rest) return std::nullopt;
  double fraction = 0;
  if (*rest == '.') {
    double digit = 0.1;
    for (++rest; *rest >= '0' && *rest <= '9'; ++rest, digit /= 10)
      fraction += digit * (*rest - '0');
  }
  long offset = 0;
  if (*rest == '+' || *rest == '-') {
    int hours = 0, minutes = 0;
    if (std::sscanf(rest + 1, "%2d:%2d", &hours, &minutes) != 2) return std::nullopt;
    offset = (hours * 60L + minutes) * 60 * (*rest == '-' ? -1 : 1);
  } else if (*rest != 'Z') {
    return std::nullopt;
  }
  return static_cast<double>(timegm(&parts) - offset) + fraction;
}

}  // namespace diaphane::kube
