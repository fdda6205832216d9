#include "api/shared/audit.h"

#include <algorithm>
#include <stdexcept>

namespace diaphane::api {

bool is_code_word(std::string_view text) {
  return !text.empty() && text.size() <= 40 && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '.' || c == '-';
  });
}

std::string_view to_string(AuditActor actor) {
  switch (actor) {
    case AuditActor::kPerson:
      return "person";
    case AuditActor::kAdministrator:
      return "administrator";
    case AuditActor::kMachine:
      break;
  }
  return "machine";
}

std::string details_as_json(const std::vector<AuditDetail>& details) {
  std::string json = "{";
  for (const auto& [key, value] : details) {
    const auto* word = std::get_if<std::string>(&value);
    if (!is_code_word(key) || (word && !is_code_word(*word))) {
      throw std::logic_error("audit details may contain only numbers and code words");
    }
    json += (json.size() > 1 ? ",\"" : "\"") + key + "\":";
    json += word ? "\"" + *word + "\"" : std::to_string(std::get<std::int64_t>(value));
  }
  return json + "}";
}

}  // namespace diaphane::api
