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

/// Maximum lengths of a password in a request, and of a code from an authenticator or an email.
inline constexpr std::size_t kPasswordBytes = 800;
inline constexpr std::size_t kCodeCharacters = 40;

/// Reads the JSON object of a request strictly, field by field, and collects all errors:
///
///   Fields in(request);
///   const std::string email = in.text("email", 3, 254);
///   if (auto wrong = in.finish()) return tl::unexpected(*wrong);
class Fields {
 public:
  /// Maximum number of JSON values in an ordinary body: one per 8 bytes of the largest body, a
  /// preset of 256 KB. A value takes up to 160 bytes, so a body takes at most 5 MB. Without a
  /// limit, a body of 1 MB that repeats "[]" would take 31 MB.
  static constexpr std::size_t kMostValues = 32'768;

  /// Parses the body, which may have at most kDeepestJson levels and `most_values` values.
  explicit Fields(const Request& request, std::size_t most_values = kMostValues);
  /// Takes the fields from decoded texts of the header `where`. Checks that they are valid UTF-8,
  /// because a header may contain any bytes.
  Fields(const std::string& where, const std::map<std::string, std::string>& texts);

  /// Reads a required text of `low` to `high` characters without control characters (a line feed in
  /// a title is a mistake, a NUL is an attack).
  std::string text(const std::string& name, std::size_t low, std::size_t high);
  std::string text_or(const std::string& name, std::string fallback, std::size_t high);
  /// Reads a required name that is shown to other users. Removes invisible characters
  /// (common/names.h) in addition to the checks of `text`.
  std::string name(const std::string& name, std::size_t low, std::size_t high);
  /// Reads an optional text that may contain line feeds, such as a description.
  std::string prose_or(const std::string& name, std::string fallback, std::size_t high);
  /// Return whether the field is present, or is null. A null field counts as read.
  bool has(const std::string& name) const { return object_.contains(name); }
  bool is_null(const std::string& name);
  /// Reads a required text that must be one of `known`.
  std::string choice(const std::string& name, std::span<const std::string_view> known);
  bool boolean(const std::string& name);
  /// Reads a required text, such as a password, that may contain any characters.
  std::string secret(const std::string& name, std::size_t high_bytes);
  std::int64_t integer(const std::string& name, std::int64_t low, std::int64_t high);
  std::int64_t integer_or(const std::string& name, std::int64_t fallback, std::int64_t low,
                          std::int64_t high);

  std::optional<std::int64_t> optional_integer(const std::string& name, std::int64_t low,
                                               std::int64_t high);
  std::optional<bool> optional_boolean(const std::string& name);

  /// Reads a required value whose format the caller checks, or null if it is missing. The reference
  /// is valid as long as this object.
  const nlohmann::json& any(const std::string& name);
  /// Adds an error that the caller found.
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

/// Returns a number from the query, `fallback` if it is absent, or kInvalid if it is out of range.
Outcome<int> integer_in_query(const Request& request, const std::string& name, int fallback,
                              int low, int high);

/// Returns a text from the query, an empty string if it is absent, or kInvalid if it is too long.
Outcome<std::string> text_in_query(const Request& request, const std::string& name,
                                   std::size_t high);
/// Returns one of `known` from the query, an empty string if absent, or kInvalid for another text.
Outcome<std::string> choice_in_query(const Request& request, const std::string& name,
                                     std::span<const std::string_view> known);

/// Returns the start of a page: the previous page's `next_cursor`, or nothing for the first page.
Outcome<std::optional<Cursor>> cursor_in_query(const Request& request);

/// Parses an RFC 3339 time in UTC ("2026-11-22T10:00:00Z", truncated to seconds), or returns
/// nothing.
std::optional<std::chrono::system_clock::time_point> time_of(const std::string& text);

/// Returns the Idempotency-Key, an empty string if it is absent, or kInvalid if it is malformed.
Outcome<std::string> idempotency_key(const Request& request);

}  // namespace diaphane::api
