#include "common/log.h"

#include <cxxabi.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>
#include <system_error>
#include <typeinfo>

namespace diaphane::log {
namespace {

/// Maximum bytes per text. A line has only a few fields, so it stays well below the 16 KiB at which
/// container runtimes split lines, whatever a library puts into an exception's text.
constexpr std::size_t kMaxTextBytes = 2048;

std::string g_program = "diaphane";
Level g_minimum = Level::kInfo;
thread_local std::string t_request_id;

std::string now_rfc3339() {
  const auto now = std::chrono::system_clock::now();
  const auto ms =
      std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count() % 1000;
  const std::time_t seconds = std::chrono::system_clock::to_time_t(now);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[80];
  std::snprintf(text, sizeof text, "%04d-%02d-%02dT%02d:%02d:%02d.%03dZ", utc.tm_year + 1900,
                utc.tm_mon + 1, utc.tm_mday, utc.tm_hour, utc.tm_min, utc.tm_sec,
                static_cast<int>(ms));
  return text;
}

const char* name_of(Level level) {
  switch (level) {
    case Level::kDebug:
      return "debug";
    case Level::kInfo:
      return "info";
    case Level::kWarning:
      return "warning";
    case Level::kError:
      return "error";
  }
  return "error";
}

/// Truncates `text` after kMaxTextBytes and appends an ellipsis. This may split a character, which
/// dump() replaces.
std::string bounded(std::string text) {
  if (text.size() > kMaxTextBytes) text.replace(kMaxTextBytes, std::string::npos, "…");
  return text;
}

[[noreturn]] void log_and_abort() {
  try {
    if (const auto thrown = std::current_exception()) std::rethrow_exception(thrown);
    write(Level::kError, "terminated");
  } catch (const std::exception& thrown) {
    write(Level::kError, "terminated", {{"reason", describe(thrown)}});
  } catch (...) {
    write(Level::kError, "terminated", {{"reason", "unknown exception type"}});
  }
  std::abort();
}

}  // namespace

void start(std::string program, Level minimum) {
  g_program = std::move(program);
  g_minimum = minimum;
  std::set_terminate(log_and_abort);
}

std::string describe(const std::exception& thrown) {
  if (dynamic_cast<const SafeError*>(&thrown)) return thrown.what();
  const char* const raw = typeid(thrown).name();
  int status = 0;
  const std::unique_ptr<char, decltype(&std::free)> name(
      abi::__cxa_demangle(raw, nullptr, nullptr, &status), &std::free);
  std::string text = status == 0 ? name.get() : raw;
  if (const auto* system = dynamic_cast<const std::system_error*>(&thrown)) {
    text += std::string(", ") + system->code().category().name() + " " +
            std::to_string(system->code().value());
  }
  return text;
}

void write(Level level, std::string_view event, std::initializer_list<Field> fields) {
  if (level < g_minimum) return;
  nlohmann::ordered_json line;
  line["time"] = now_rfc3339();
  line["level"] = name_of(level);
  line["program"] = g_program;
  line["event"] = std::string(event);
  if (!t_request_id.empty()) line["request_id"] = t_request_id;
  for (const Field& field : fields) {
    if (const auto* text = std::get_if<std::string>(&field.value)) {
      line[std::string(field.key)] = bounded(*text);
      continue;
    }
    std::visit([&](const auto& value) { line[std::string(field.key)] = value; }, field.value);
  }
  // Bytes that are not UTF-8 are replaced, so a line is always valid JSON.
  const std::string text =
      line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text.data(), text.size());
}

RequestScope::RequestScope(std::string request_id)
    : outer_(std::exchange(t_request_id, std::move(request_id))) {}
RequestScope::~RequestScope() { t_request_id = std::move(outer_); }
std::string_view current_request_id() { return t_request_id; }

}  // namespace diaphane::log
