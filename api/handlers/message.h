#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// HTTP as the handlers see it: plain values, no library's types.
namespace diaphane::api {

/// What is known before the body: names of headers in lower case, repeated ones joined by ", ".
struct Head {
  std::string method;
  std::string target;  ///< path and query as they came, undecoded
  std::map<std::string, std::string> headers;

  /// Empty when absent.
  std::string_view header(std::string_view lower_case_name) const {
    const auto found = headers.find(std::string(lower_case_name));
    return found == headers.end() ? std::string_view() : std::string_view(found->second);
  }
};

struct Request : Head {
  std::map<std::string, std::string> parameters;  ///< of the path: "{data_set_id}"
  std::map<std::string, std::string> query;       ///< decoded
  std::string body;
  std::string request_id;
  std::string address;  ///< of the client, as the edge says

  const std::string& parameter(const std::string& name) const { return parameters.at(name); }
};

struct Response {
  int status = 200;
  std::vector<std::pair<std::string, std::string>> headers;
  std::string content_type;  ///< empty: no body
  std::string body;

  Response& with(std::string name, std::string value) &;
  Response&& with(std::string name, std::string value) &&;
};

}  // namespace diaphane::api
