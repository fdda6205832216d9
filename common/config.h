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

/// Settings of a program: the environment variable DIAPHANE_<NAME>, or `--name VALUE` /
/// `--name=VALUE`, which wins. Every mistake is collected, so that an operator sees them all at
/// once.
///
///   ConfigReader in(argc, argv);
///   options.port = in.port("api-port", "REST, 127.0.0.1 only");
///   options.redis = in.text("redis", "host:port");
///   if (auto done = in.finish("diaphane-api: what it is")) return *done;   // --help, or mistakes
class ConfigReader {
 public:
  ConfigReader(int argc, const char* const* argv);
  /// For tests: environment given as a map.
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
  /// An existing directory that can be entered.
  std::string directory(std::string_view name, std::string_view help);
  bool flag(std::string_view name, std::string_view help);
  /// Words that are no options ("migrate up").
  const std::vector<std::string>& words() const { return words_; }
  void mistake(std::string text) { mistakes_.push_back(std::move(text)); }

  /// Nothing when all is well; else the exit code, after --help was printed on standard output or
  /// the mistakes on standard error.
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
  bool help_wanted_ = false;
};

}  // namespace diaphane
