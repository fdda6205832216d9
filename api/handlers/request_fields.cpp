#include "api/handlers/request_fields.h"

#include <algorithm>
#include <charconv>

namespace diaphane::api {
namespace {

std::size_t characters_in(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xc0) != 0x80;
  }));
}

bool has_control(const std::string& text) {
  return std::any_of(text.begin(), text.end(),
                     [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
}

bool is_json(std::string_view content_type) {
  const std::string_view type = content_type.substr(0, content_type.find(';'));
  return type == "application/json" || type == "application/json ";
}

}  // namespace

Fields::Fields(const Request& request) {
  if (!is_json(request.header("content-type"))) {
    unreadable_ = Problem{ProblemKind::kMediaType, "The body must be application/json.", {}, {}};
    return;
  }
  object_ = nlohmann::json::parse(request.body, nullptr, false);
  if (object_.is_discarded()) {
    unreadable_ = Problem{ProblemKind::kBadRequest, "The body is not JSON.", {}, {}};
  } else if (!object_.is_object()) {
    unreadable_ = Problem{ProblemKind::kInvalid, "The body must be a JSON object.", {}, {}};
  }
  if (unreadable_) object_ = nlohmann::json::object();
}

const nlohmann::json* Fields::take(const std::string& name, bool required) {
  known_.push_back(name);
  const auto found = object_.find(name);
  if (found != object_.end()) return &*found;
  if (required) wrong(name, "is missing");
  return nullptr;
}

std::string Fields::check_text(const std::string& name, const nlohmann::json& value,
                               std::size_t low, std::size_t high) {
  if (!value.is_string()) {
    wrong(name, "must be a text");
    return {};
  }
  const auto text = value.get<std::string>();
  const std::size_t length = characters_in(text);
  if (length < low || length > high) {
    wrong(name, "must have " + std::to_string(low) + " to " + std::to_string(high) + " characters");
  } else if (has_control(text)) {
    wrong(name, "must not hold control characters");
  }
  return text;
}

std::string Fields::text(const std::string& name, std::size_t low, std::size_t high) {
  const auto* value = take(name, true);
  return value ? check_text(name, *value, low, high) : std::string();
}

nlohmann::json Fields::any(const std::string& name) {
  const auto* value = take(name, true);
  return value ? *value : nlohmann::json();
}

std::string Fields::text_or(const std::string& name, std::string fallback, std::size_t high) {
  const auto* value = take(name, false);
  return value ? check_text(name, *value, 0, high) : fallback;
}

std::string Fields::secret(const std::string& name, std::size_t high_bytes) {
  const auto* value = take(name, true);
  if (!value) return {};
  if (!value->is_string()) {
    wrong(name, "must be a text");
    return {};
  }
  auto text = value->get<std::string>();
  if (text.empty() || text.size() > high_bytes) wrong(name, "is empty or too long");
  return text;
}

std::int64_t Fields::check_integer(const std::string& name, const nlohmann::json& value,
                                   std::int64_t low, std::int64_t high) {
  const bool fits = value.is_number_unsigned()
                        ? value.get<std::uint64_t>() <= static_cast<std::uint64_t>(INT64_MAX)
                        : value.is_number_integer();
  if (!fits || value.get<std::int64_t>() < low || value.get<std::int64_t>() > high) {
    wrong(name,
          "must be a whole number from " + std::to_string(low) + " to " + std::to_string(high));
    return low;
  }
  return value.get<std::int64_t>();
}

std::int64_t Fields::integer(const std::string& name, std::int64_t low, std::int64_t high) {
  const auto* value = take(name, true);
  return value ? check_integer(name, *value, low, high) : low;
}

std::int64_t Fields::integer_or(const std::string& name, std::int64_t fallback, std::int64_t low,
                                std::int64_t high) {
  const auto* value = take(name, false);
  return value ? check_integer(name, *value, low, high) : fallback;
}

void Fields::wrong(std::string field, std::string message) {
  mistakes_.push_back({std::move(field), std::move(message)});
}

std::optional<Problem> Fields::finish() {
  if (unreadable_) return unreadable_;
  for (const auto& [name, value] : object_.items()) {
    if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
    // The name is the client's text: said back only as far as it can be a name.
    const bool plain = name.size() <= 40 && !has_control(name);
    wrong(plain ? name : "(a field)", "is not known here");
    if (mistakes_.size() > 20) break;
  }
  if (mistakes_.empty()) return std::nullopt;
  return Problem{ProblemKind::kInvalid, "A part of the request is wrong.", mistakes_, {}};
}

Outcome<int> integer_in_query(const Request& request, const std::string& name, int fallback,
                              int low, int high) {
  const auto found = request.query.find(name);
  if (found == request.query.end()) return fallback;
  const std::string& text = found->second;
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < low || value > high) {
    return refuse_field(
        name, "must be a whole number from " + std::to_string(low) + " to " + std::to_string(high));
  }
  return value;
}

Outcome<std::string> idempotency_key(const Request& request) {
  const std::string_view key = request.header("idempotency-key");
  const bool plain = key.size() <= 128 && std::all_of(key.begin(), key.end(),
                                                      [](char c) { return c > 0x20 && c < 0x7f; });
  if (!plain) return refuse_field("Idempotency-Key", "must be up to 128 visible ASCII characters");
  return std::string(key);
}

}  // namespace diaphane::api
