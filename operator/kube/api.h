#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "operator/kube/transport.h"

namespace diaphane::kube {

/// What a write is held against, so that nothing is done to another object of the same name, nor to
/// one that changed since it was looked at.
struct Precondition {
  std::string uid;
  std::string version;  ///< empty: any
};

/// Verbs of the Kubernetes API on JSON. Errors have the API's reason ("AlreadyExists", "Conflict",
/// "Forbidden", ...) as their `field`.
///
/// kConflict: AlreadyExists, or it changed since. kNotFound. kForbidden. kInvalid: refused for what
/// it is. kTooMany and kUnavailable: later. A thread may call it with others.
class Api {
 public:
  using Json = nlohmann::json;
  Api(Transport& transport, std::string manager)
      : transport_(transport), manager_(std::move(manager)) {}

  Result<Json> get(const std::string& path);
  Result<Json> create(const std::string& collection, const Json& object);
  /// Server-side apply: what is in `object` is ours, whoever changed it before. Its metadata names
  /// uid and resourceVersion. `part` is a part of our manager's name, for what is applied apart.
  Result<Json> apply(const std::string& path, const Json& object, const std::string& part = "");
  /// `object` with the resourceVersion that was read.
  Result<Json> replace(const std::string& path, const Json& object);
  Result<Json> merge(const std::string& path, const Json& patch);
  Result<void> remove(const std::string& path, const Precondition& precondition);

 private:
  Result<Json> send(const Request& request);
  Transport& transport_;
  const std::string manager_;
};

/// What a Status says that came with `status`.
Error error_of(int status, const nlohmann::json& body);

/// RFC 3339 in UTC with microseconds, and back; nothing for what is none.
std::string time_text(double seconds_since_epoch);
std::optional<double> time_of(const std::string& text);

}  // namespace diaphane::kube
