#pragma once

#include <string>
#include <string_view>

#include "api/routing/request_fields.h"
#include "common/utf8.h"
#include "tests/fuzz/must.h"

/// Helpers shared by the fuzzers of the API's bodies.
namespace diaphane::fuzz {

inline api::Request request_of(std::string_view content_type, std::string_view body) {
  api::Request request;
  request.headers["content-type"] = content_type;
  request.body = body;
  return request;
}

/// Returns the number of levels of objects and arrays, without recursion.
inline int depth_of(const nlohmann::json& value) {
  int deepest = 0;
  std::vector<std::pair<const nlohmann::json*, int>> open{{&value, 1}};
  while (!open.empty()) {
    const auto [one, depth] = open.back();
    open.pop_back();
    if (!one->is_structured()) continue;
    deepest = std::max(deepest, depth);
    for (const nlohmann::json& part : *one) open.emplace_back(&part, depth + 1);
  }
  return deepest;
}

}  // namespace diaphane::fuzz
