#pragma once

#include <exception>
#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace diaphane::log {

/// A value in a log line. Only what a program measures or generates itself belongs here: never a
/// header, a body, a file name or a text that a user or a scan brought along.
using Value = std::variant<std::string, std::int64_t, double, bool>;
struct Field {
  std::string_view key;
  Value value;
  Field(std::string_view k, std::string v) : key(k), value(std::move(v)) {}
  Field(std::string_view k, std::string_view v) : key(k), value(std::string(v)) {}
  Field(std::string_view k, const char* v) : key(k), value(std::string(v)) {}
  Field(std::string_view k, bool v) : key(k), value(v) {}
  Field(std::string_view k, double v) : key(k), value(v) {}
  template <typename I>
  requires std::is_integral_v<I> Field(std::string_view k, I v)
      : key(k), value(static_cast<std::int64_t>(v)) {}
};

enum class Level { kDebug, kInfo, kWarning, kError };

/// Names the program in every line; `minimum` drops what is below it. Call once, before any thread
/// starts. An exception that nobody catches is logged by describe() from then on; the standard
/// library would print its text.
void start(std::string program, Level minimum = Level::kInfo);

/// One line of JSON on standard error: time (RFC 3339, UTC, ms), level, program, event, then the
/// fields and, when this thread has one, "request_id". Written by one write(2), so lines never mix.
/// A text longer than 2048 bytes is cut off.
void write(Level level, std::string_view event, std::initializer_list<Field> fields = {});

inline void debug(std::string_view e, std::initializer_list<Field> f = {}) {
  write(Level::kDebug, e, f);
}
inline void info(std::string_view e, std::initializer_list<Field> f = {}) {
  write(Level::kInfo, e, f);
}
inline void warning(std::string_view e, std::initializer_list<Field> f = {}) {
  write(Level::kWarning, e, f);
}
inline void error(std::string_view e, std::initializer_list<Field> f = {}) {
  write(Level::kError, e, f);
}

/// An exception whose text was written for the log: it quotes nothing that a person or a scan
/// brought along.
class SafeError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What a log line may say of an exception: its type, and its text only if it is a SafeError. The
/// texts of libraries quote what they choked on: a row, a piece of JSON, a header.
std::string describe(const std::exception& thrown);

/// While it lives, lines of this thread carry the request's id.
class RequestScope {
 public:
  explicit RequestScope(std::string request_id);
  ~RequestScope();
  RequestScope(const RequestScope&) = delete;
  RequestScope& operator=(const RequestScope&) = delete;

 private:
  std::string outer_;
};
std::string_view current_request_id();

}  // namespace diaphane::log
