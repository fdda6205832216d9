#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

namespace diaphane::kube {

/// Readers for untrusted JSON. A missing value, or one of another type, yields the fallback.
inline const nlohmann::json& part(const nlohmann::json& object, const char* key) {
  static const nlohmann::json none = nlohmann::json::object();
  if (!object.is_object()) return none;
  const auto found = object.find(key);
  return found == object.end() ? none : *found;
}

inline std::string text(const nlohmann::json& object, const char* key, std::string fallback = {}) {
  const nlohmann::json& value = part(object, key);
  return value.is_string() ? value.get<std::string>() : std::move(fallback);
}

template <typename T>
T number(const nlohmann::json& object, const char* key, T fallback) {
  const nlohmann::json& value = part(object, key);
  return value.is_number() ? value.get<T>() : fallback;
}

}  // namespace diaphane::kube
