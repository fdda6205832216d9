#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "operator/kube/transport.h"

namespace diaphane::kube {

/// Precondition of a write, which protects another object of the same name, and an object that has
/// changed since it was read.
struct Precondition {
  std::string uid;
  std::string version;  ///< empty: any
};

/// The verbs of the Kubernetes API, with objects as JSON. The `field` of an error is the reason
/// that the API gave ("AlreadyExists", "Conflict", "Forbidden", ...).
///
/// Calls return kConflict if the object already exists or has changed, kNotFound if it does not
/// exist, kUnauthenticated or kForbidden if the operator lacks the permission, kInvalid or
/// kTooLarge if the object was rejected, and kTooMany or kUnavailable if a retry may help.
/// Thread-safe.
class Api {
 public:
  using Json = nlohmann::json;
  Api(Transport& transport, std::string manager)
      : transport_(transport), manager_(std::move(manager)) {}

  /// Each function that returns Json returns the object as the API server has it now.
  Result<Json> get(const std::string& path);
  Result<Json> create(const std::string& collection, const Json& object);
  /// Server-side apply, which takes ownership of all fields in `object`. Its metadata contains uid
  /// and resourceVersion. `part` is appended to the name of the field manager, so that separate
  /// parts of an object can be applied separately.
  Result<Json> apply(const std::string& path, const Json& object, const std::string& part = "");
  /// Replaces the object. `object` contains the resourceVersion that was read.
  Result<Json> replace(const std::string& path, const Json& object);
  /// Applies a JSON merge patch (RFC 7386).
  Result<Json> merge(const std::string& path, const Json& patch);
  /// Deletes the object. Returns kConflict if the precondition does not hold.
  Result<void> remove(const std::string& path, const Precondition& precondition);

 private:
  Result<Json> send(const Request& request);
  Transport& transport_;
  const std::string manager_;
};

/// Converts a Status object that came with HTTP status `status` to an error.
Error error_of(int status, const nlohmann::json& body);

/// Formats and parses RFC 3339 in UTC with microseconds. time_of returns nullopt for invalid text.
std::string time_text(double seconds_since_epoch);
std::optional<double> time_of(const std::string& text);

}  // namespace diaphane::kube
