#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/shared/client.h"

/// HTTP messages as plain values, so that the handlers are independent of the HTTP library.
namespace diaphane::api {

/// The head of a request. Header names are in lower case; repeated headers are joined with ", ".
struct Head {
  std::string method;
  std::string target;  ///< raw path and query, not decoded
  std::map<std::string, std::string> headers;

  /// Returns an empty string if the header is absent.
  std::string_view header(std::string_view lower_case_name) const {
    const auto found = headers.find(std::string(lower_case_name));
    return found == headers.end() ? std::string_view() : std::string_view(found->second);
  }
};

struct Request : Head {
  std::map<std::string, std::string> parameters;  ///< path parameters, such as "{data_set_id}"
  std::map<std::string, std::string> query;       ///< decoded
  std::string body;
  std::string request_id;
  Client client;

  const std::string& parameter(const std::string& name) const { return parameters.at(name); }
};

struct Response {
  int status = 200;
  std::vector<std::pair<std::string, std::string>> headers;
  std::string content_type;  ///< empty means no body
  std::string body;

  Response& with(std::string name, std::string value) &;
  Response&& with(std::string name, std::string value) &&;
};

}  // namespace diaphane::api
