#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "api/handlers/message.h"
#include "api/service/cursor.h"
#include "api/service/idempotency.h"
#include "api/service/problem.h"

namespace diaphane::api {

/// Reads the JSON object of a request strictly, field by field, and collects everything that is
/// wrong with it:
///
///   Fields in(request);
///   const std::string email = in.text("email", 3, 254);
///   if (auto wrong = in.finish()) return tl::unexpected(*wrong);
class Fields {
 public:
  /// Of an ordinary body: one for each 8 bytes of the largest, a preset of 256 KB. A value takes up
  /// to 160 bytes, so that a body costs 5 MB at most; 1 MB of "[]" without a limit takes 31 MB.
  static constexpr std::size_t kMostValues = 32'768;

  /// Also unreadable: a body that is nested more than kDeepestJson deep or has too many values.
  explicit Fields(const Request& request, std::size_t most_values = kMostValues);
  /// Of texts that came elsewhere, in the header `where`: any bytes, so their coding is checked.
  Fields(const std::string& where, const std::map<std::string, std::string>& texts);

  /// Required. `low` to `high` characters of UTF-8; no control character (a line feed in a title is
  /// a mistake, a NUL an attack).
  std::string text(const std::string& name, std::size_t low, std::size_t high);
  std::string text_or(const std::string& name, std::string fallback, std::size_t high);
  /// What others read as the name of a person or a thing: as `text`, and without what cannot be
  /// seen (common/names.h).
  std::string name(const std::string& name, std::size_t low, std::size_t high);
  /// With line feeds: a description.
  std::string prose_or(const std::string& name, std::string fallback, std::size_t high);
  /// Is it there? And is it there and null (then it counts as read)?
  bool has(const std::string& name) const { return object_.contains(name); }
  bool is_null(const std::string& name);
  /// One of `known`.
  std::string choice(const std::string& name, std::span<const std::string_view> known);
  bool boolean(const std::string& name);
  /// As it is, control characters too: passwords.
  std::string secret(const std::string& name, std::size_t high_bytes);
  std::int64_t integer(const std::string& name, std::int64_t low, std::int64_t high);
  std::int64_t integer_or(const std::string& name, std::int64_t fallback, std::int64_t low,
                          std::int64_t high);

  std::optional<std::int64_t> optional_integer(const std::string& name, std::int64_t low,
                                               std::int64_t high);
  std::optional<bool> optional_boolean(const std::string& name);

  /// Required; null when it is missing. For what has a form of its own, checked by the caller.
  /// Valid as long as these fields are.
  const nlohmann::json& any(const std::string& name);
  /// A mistake that the caller found.
  void wrong(std::string field, std::string message);

  /// kMediaType, kBadRequest (no JSON), or kInvalid with each mistake, unknown fields among them;
  /// or nothing.
  std::optional<Problem> finish();

 private:
  const nlohmann::json* take(const std::string& name, bool required);
  std::string check_text(const std::string& name, const nlohmann::json& value, std::size_t low,
                         std::size_t high);
  std::int64_t check_integer(const std::string& name, const nlohmann::json& value, std::int64_t low,
                             std::int64_t high);

  nlohmann::json object_ = nlohmann::json::object();
  std::vector<std::string> known_;
  std::vector<FieldProblem> mistakes_;
  std::optional<Problem> unreadable_;
};

/// A number from the query, or `fallback`; kInvalid names the parameter.
Outcome<int> integer_in_query(const Request& request, const std::string& name, int fallback,
                              int low, int high);

/// A text of the query, or empty; kInvalid names the parameter.
Outcome<std::string> text_in_query(const Request& request, const std::string& name,
                                   std::size_t high);
/// One of `known`, or empty.
Outcome<std::string> choice_in_query(const Request& request, const std::string& name,
                                     std::span<const std::string_view> known);

/// Where a page begins: what the page before gave as `next_cursor`, or nothing for the first.
Outcome<std::optional<Cursor>> cursor_in_query(const Request& request);

/// A time of RFC 3339 in UTC ("2026-11-22T10:00:00Z", fractions of seconds are cut), or nothing.
std::optional<std::chrono::system_clock::time_point> time_of(const std::string& text);

/// The header, or empty when absent; kInvalid for what no key may be.
Outcome<std::string> idempotency_key(const Request& request);

}  // namespace diaphane::api
