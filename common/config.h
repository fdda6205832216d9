#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace diaphane {

/// Exit codes of every program (sysexits.h).
inline constexpr int kExitUsage = 64;   ///< bad command line
inline constexpr int kExitConfig = 78;  ///< bad or missing setting

/// Reads the settings of a program from the environment variable DIAPHANE_<NAME> or from the option
/// `--name VALUE` or `--name=VALUE`, which takes precedence. It collects all mistakes, so that an
/// operator sees them at once.
///
///   ConfigReader in(argc, argv);
///   options.port = in.port("api-port", "port of the REST API");
///   options.redis = in.text("redis", "Redis address");
///   if (auto done = in.finish("diaphane-api: the REST API server")) return *done;
class ConfigReader {
 public:
  ConfigReader(int argc, const char* const* argv);
  /// For tests, which pass the environment as a map.
  ConfigReader(std::vector<std::string> arguments, std::map<std::string, std::string> environment);

  std::string text(std::string_view name, std::string_view help,
                   std::optional<std::string> fallback = std::nullopt);
  std::int64_t integer(std::string_view name, std::string_view help, std::int64_t low,
                       std::int64_t high, std::optional<std::int64_t> fallback = std::nullopt);
  std::uint16_t port(std::string_view name, std::string_view help,
                     std::optional<std::uint16_t> fallback = std::nullopt);
  std::string one_of(std::string_view name, std::string_view help,
                     const std::vector<std::string>& choices,
                     std::optional<std::string> fallback = std::nullopt);
  /// A directory that must exist and be accessible.
  std::string directory(std::string_view name, std::string_view help);
  bool flag(std::string_view name, std::string_view help);
  /// The positional arguments ("migrate up").
  const std::vector<std::string>& words() const { return words_; }
  void mistake(std::string text) { mistakes_.push_back(std::move(text)); }

  /// Returns nothing if the program should run. Otherwise prints the help to standard output or the
  /// mistakes to standard error, and returns the exit code.
  std::optional<int> finish(std::string_view about);
  const std::vector<std::string>& mistakes() const { return mistakes_; }

 private:
  std::optional<std::string> take(std::string_view name, std::string_view help,
                                  const std::optional<std::string>& fallback);
  void parse(std::vector<std::string> arguments);

  std::map<std::string, std::string> options_;
  std::map<std::string, std::string> environment_;
  bool environment_from_process_ = false;
  std::vector<std::string> words_;
  std::vector<std::string> known_;
  std::vector<std::string> mistakes_;
  std::string help_;
  bool help_requested_ = false;
};

}  // namespace diaphane
