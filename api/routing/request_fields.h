#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "api/routing/message.h"
#include "api/shared/cursor.h"
#include "api/shared/idempotency.h"
#include "api/shared/problem.h"

namespace diaphane::api {

/// Limits of a password in a request, and of a code from an authenticator or an email.
inline constexpr std::size_t kPasswordBytes = 800;
inline constexpr std::size_t kCodeCharacters = 40;

/// Reads the JSON object of a request strictly, field by field, and collects all errors:
///
///   Fields in(request);
///   const std::string email = in.text("email", 3, 254);
///   if (auto wrong = in.finish()) return tl::unexpected(*wrong);
class Fields {
 public:
  /// Maximum values of an ordinary body: one per 8 bytes of the largest body, a preset of 256 KB. A
  /// value takes up to 160 bytes, so a body takes at most 5 MB. Without a limit, 1 MB of "[]" would
  /// take 31 MB.
  static constexpr std::size_t kMostValues = 32'768;

  /// Also rejects a body that is nested more than kDeepestJson levels deep or has too many values.
  explicit Fields(const Request& request, std::size_t most_values = kMostValues);
  /// Reads texts from the header `where`. Their encoding is checked, because they may contain any
  /// bytes.
  Fields(const std::string& where, const std::map<std::string, std::string>& texts);

  /// Required. `low` to `high` characters of UTF-8 without control characters (a line feed in a
  /// title is a mistake, a NUL is an attack).
  std::string text(const std::string& name, std::size_t low, std::size_t high);
  std::string text_or(const std::string& name, std::string fallback, std::size_t high);
  /// A name that is shown to other users: like `text`, but also without invisible characters
  /// (common/names.h).
  std::string name(const std::string& name, std::size_t low, std::size_t high);
  /// Allows line feeds, for descriptions.
  std::string prose_or(const std::string& name, std::string fallback, std::size_t high);
  /// Whether the field is present, and whether it is present and null (then it counts as read).
  bool has(const std::string& name) const { return object_.contains(name); }
  bool is_null(const std::string& name);
  /// Required; must be one of `known`.
  std::string choice(const std::string& name, std::span<const std::string_view> known);
  bool boolean(const std::string& name);
  /// Returns the text unmodified, even with control characters. For passwords.
  std::string secret(const std::string& name, std::size_t high_bytes);
  std::int64_t integer(const std::string& name, std::int64_t low, std::int64_t high);
  std::int64_t integer_or(const std::string& name, std::int64_t fallback, std::int64_t low,
                          std::int64_t high);

  std::optional<std::int64_t> optional_integer(const std::string& name, std::int64_t low,
                                               std::int64_t high);
  std::optional<bool> optional_boolean(const std::string& name);

  /// Required; null if it is missing. For values with their own format, which the caller checks.
  /// Valid as long as this object.
  const nlohmann::json& any(const std::string& name);
  /// Reports an error that the caller found.
  void wrong(std::string field, std::string message);

  /// Returns kMediaType, kBadRequest (not JSON) or kInvalid with all errors, including unknown
  /// fields, or nothing if the request is valid.
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

/// Returns a number from the query, or `fallback`. kInvalid names the parameter.
Outcome<int> integer_in_query(const Request& request, const std::string& name, int fallback,
                              int low, int high);

/// Returns a text from the query, or an empty string. kInvalid names the parameter.
Outcome<std::string> text_in_query(const Request& request, const std::string& name,
                                   std::size_t high);
/// Returns one of `known`, or an empty string.
Outcome<std::string> choice_in_query(const Request& request, const std::string& name,
                                     std::span<const std::string_view> known);

/// Returns the start of a page: the previous page's `next_cursor`, or nothing for the first page.
Outcome<std::optional<Cursor>> cursor_in_query(const Request& request);

/// Parses an RFC 3339 time in UTC ("2026-11-22T10:00:00Z", truncated to seconds), or returns
/// nothing.
std::optional<std::chrono::system_clock::time_point> time_of(const std::string& text);

/// Returns the header, or an empty string if it is absent. Returns kInvalid for a malformed key.
Outcome<std::string> idempotency_key(const Request& request);

}  // namespace diaphane::api
