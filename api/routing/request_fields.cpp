#include "api/routing/request_fields.h"

#include <algorithm>
#include <charconv>
#include <ctime>
#include <regex>

#include "common/bounded_json.h"
#include "common/names.h"
#include "common/utf8.h"

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

std::string must_be_one_of(std::span<const std::string_view> known) {
  std::string listed;
  for (const std::string_view choice : known) {
    if (!choice.empty()) listed += (listed.empty() ? "" : ", ") + std::string(choice);
  }
  return "must be one of: " + listed;
}

bool is_json(std::string_view content_type) {
  const std::string_view type = content_type.substr(0, content_type.find(';'));
  return type == "application/json" || type == "application/json ";
}

Problem problem_of(JsonFault fault, std::size_t most_values) {
  const auto bad = [](std::string detail) {
    return Problem{ProblemKind::kBadRequest, std::move(detail), {}, {}};
  };
  switch (fault) {
    case JsonFault::kTooDeep:
      return bad("The body is nested more than " + std::to_string(kDeepestJson) + " levels deep.");
    case JsonFault::kTooManyValues:
      return bad("The body has more than " + std::to_string(most_values) +
                 " JSON values; send fewer.");
    case JsonFault::kMalformed:
      break;
  }
  return bad("The body is not valid JSON.");
}

}  // namespace

Fields::Fields(const Request& request, std::size_t most_values) {
  if (!is_json(request.header("content-type"))) {
    unreadable_ = Problem{ProblemKind::kMediaType, "The body must be application/json.", {}, {}};
    return;
  }
  auto body = parse_json(request.body, {most_values});
  if (!body) {
    unreadable_ = problem_of(body.error(), most_values);
  } else if (!body->is_object()) {
    unreadable_ = Problem{ProblemKind::kInvalid, "The body must be a JSON object.", {}, {}};
  } else {
    object_ = *std::move(body);
  }
}

Fields::Fields(const std::string& where, const std::map<std::string, std::string>& texts) {
  for (const auto& [name, text] : texts) {
    const bool sound = is_utf8(text);
    if (!sound) wrong(where, "contains a " + name + " that is not valid UTF-8");
    object_[name] = sound ? text : std::string();
  }
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
    wrong(name, "must be a string");
    return {};
  }
  const auto text = value.get<std::string>();
  const std::size_t length = characters_in(text);
  if (length < low || length > high) {
    wrong(name, "must have " + std::to_string(low) + " to " + std::to_string(high) + " characters");
  } else if (has_control(text)) {
    wrong(name, "must not contain control characters");
  }
  return text;
}

std::string Fields::text(const std::string& name, std::size_t low, std::size_t high) {
  const auto* value = take(name, true);
  return value ? check_text(name, *value, low, high) : std::string();
}

std::string Fields::name(const std::string& name, std::size_t low, std::size_t high) {
  std::string typed = text(name, low, high);
  std::string clean = clean_name(typed, high);
  if (clean.empty() && !typed.empty() && low > 0) wrong(name, "must contain visible characters");
  return clean;
}

const nlohmann::json& Fields::any(const std::string& name) {
  static const nlohmann::json missing;
  const auto* value = take(name, true);
  return value ? *value : missing;
}

std::string Fields::text_or(const std::string& name, std::string fallback, std::size_t high) {
  const auto* value = take(name, false);
  return value ? check_text(name, *value, 0, high) : fallback;
}

std::string Fields::prose_or(const std::string& name, std::string fallback, std::size_t high) {
  const auto* value = take(name, false);
  if (!value) return fallback;
  if (!value->is_string()) {
    wrong(name, "must be a string");
    return fallback;
  }
  auto text = value->get<std::string>();
  auto shown = text;
  std::erase(shown, '\n');
  if (characters_in(text) > high) {
    wrong(name, "must have at most " + std::to_string(high) + " characters");
  } else if (has_control(shown)) {
    wrong(name, "must not contain control characters");
  }
  return text;
}

bool Fields::is_null(const std::string& name) {
  return object_.contains(name) && take(name, false)->is_null();
}

std::string Fields::choice(const std::string& name, std::span<const std::string_view> known) {
  const auto* value = take(name, true);
  if (!value) return {};
  auto text = value->is_string() ? value->get<std::string>() : std::string();
  if (std::find(known.begin(), known.end(), text) == known.end()) {
    wrong(name, must_be_one_of(known));
  }
  return text;
}

bool Fields::boolean(const std::string& name) {
  const auto* value = take(name, true);
  if (value && !value->is_boolean()) wrong(name, "must be true or false");
  return value && value->is_boolean() && value->get<bool>();
}

std::string Fields::secret(const std::string& name, std::size_t high_bytes) {
  const auto* value = take(name, true);
  if (!value) return {};
  if (!value->is_string()) {
    wrong(name, "must be a string");
    return {};
  }
  auto text = value->get<std::string>();
  if (text.empty() || text.size() > high_bytes) wrong(name, "must not be empty or too long");
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

std::optional<std::int64_t> Fields::optional_integer(const std::string& name, std::int64_t low,
                                                     std::int64_t high) {
  const auto* value = take(name, false);
  if (!value) return std::nullopt;
  return check_integer(name, *value, low, high);
}

std::optional<bool> Fields::optional_boolean(const std::string& name) {
  const auto* value = take(name, false);
  if (!value) return std::nullopt;
  if (value->is_boolean()) return value->get<bool>();
  wrong(name, "must be true or false");
  return std::nullopt;
}

void Fields::wrong(std::string field, std::string message) {
  mistakes_.push_back({std::move(field), std::move(message)});
}

std::optional<Problem> Fields::finish() {
  if (unreadable_) return unreadable_;
  for (const auto& [name, value] : object_.items()) {
    if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
    // The name is client input, so it is returned only if it can be a name.
    const bool plain = name.size() <= 40 && !has_control(name);
    wrong(plain ? name : "(a field)", "is unknown");
    if (mistakes_.size() > 20) break;
  }
  if (mistakes_.empty()) return std::nullopt;
  return Problem{ProblemKind::kInvalid, "The request contains invalid values.", mistakes_, {}};
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

Outcome<std::optional<Cursor>> cursor_in_query(const Request& request) {
  const auto found = request.query.find("cursor");
  if (found == request.query.end()) return std::nullopt;
  auto cursor = decode_cursor(found->second);
  if (!cursor) return refuse_field("cursor", cursor.error().message);
  return *std::move(cursor);
}

Outcome<std::string> text_in_query(const Request& request, const std::string& name,
                                   std::size_t high) {
  const auto found = request.query.find(name);
  if (found == request.query.end()) return std::string();
  if (characters_in(found->second) > high || has_control(found->second) ||
      !is_utf8(found->second)) {
    return refuse_field(name, "must have at most " + std::to_string(high) + " valid characters");
  }
  return found->second;
}

Outcome<std::string> choice_in_query(const Request& request, const std::string& name,
                                     std::span<const std::string_view> known) {
  const auto found = request.query.find(name);
  if (found == request.query.end()) return std::string();
  if (std::find(known.begin(), known.end(), found->second) == known.end()) {
    return refuse_field(name, must_be_one_of(known));
  }
  return found->second;
}

std::optional<std::chrono::system_clock::time_point> time_of(const std::string& text) {
  static const std::regex form(R"((\d{4})-(\d\d)-(\d\d)[Tt](\d\d):(\d\d):(\d\d)(\.\d{1,9})?[Zz])");
  std::smatch found;
  if (text.size() > 40 || !std::regex_match(text, found, form)) return std::nullopt;
  std::tm utc{};
  utc.tm_year = std::stoi(found[1]) - 1900;
  utc.tm_mon = std::stoi(found[2]) - 1;
  utc.tm_mday = std::stoi(found[3]);
  utc.tm_hour = std::stoi(found[4]);
  utc.tm_min = std::stoi(found[5]);
  utc.tm_sec = std::stoi(found[6]);
  // A 64-bit clock with nanoseconds ends in 2262.
  constexpr int kFirstYear = 1970, kLastYear = 2200;
  if (utc.tm_year < kFirstYear - 1900 || utc.tm_year > kLastYear - 1900) return std::nullopt;
  const std::tm given = utc;
  const std::time_t seconds =
      timegm(&utc);  // normalises an invalid date, such as the 31st of February
  if (utc.tm_mday != given.tm_mday || utc.tm_mon != given.tm_mon || given.tm_sec > 59 ||
      utc.tm_hour != given.tm_hour || utc.tm_min != given.tm_min) {
    return std::nullopt;
  }
  return std::chrono::system_clock::from_time_t(seconds);
}

Outcome<std::string> idempotency_key(const Request& request) {
  const std::string_view key = request.header("idempotency-key");
  const bool plain = key.size() <= 128 && std::all_of(key.begin(), key.end(),
                                                      [](char c) { return c > 0x20 && c < 0x7f; });
  if (!plain) return refuse_field("Idempotency-Key", "must be 1 to 128 visible ASCII characters");
  return std::string(key);
}

}  // namespace diaphane::api
