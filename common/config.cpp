#include "common/config.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

namespace diaphane {
namespace {

std::string variable_of(std::string_view name) {
  std::string variable = "DIAPHANE_";
  for (const char c : name) {
    variable += c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  return variable;
}

}  // namespace

ConfigReader::ConfigReader(int argc, const char* const* argv) : environment_from_process_(true) {
  parse(std::vector<std::string>(argv + std::min(argc, 1), argv + argc));
}

ConfigReader::ConfigReader(std::vector<std::string> arguments,
                           std::map<std::string, std::string> environment)
    : environment_(std::move(environment)) {
  parse(std::move(arguments));
}

void ConfigReader::parse(std::vector<std::string> arguments) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& word = arguments[i];
    if (word == "--help" || word == "-h") {
      help_requested_ = true;
    } else if (word.starts_with("--")) {
      const std::size_t equals = word.find('=');
      if (equals != std::string::npos) {
        options_[word.substr(2, equals - 2)] = word.substr(equals + 1);
      } else if (i + 1 < arguments.size() && !arguments[i + 1].starts_with("--")) {
        options_[word.substr(2)] = arguments[i + 1];
        ++i;
      } else {
        options_[word.substr(2)] = "true";
      }
    } else {
      words_.push_back(word);
    }
  }
}

std::optional<std::string> ConfigReader::take(std::string_view name, std::string_view help,
                                              const std::optional<std::string>& fallback) {
  known_.emplace_back(name);
  help_ += "  --" + std::string(name) + "  (" + variable_of(name) + ")  " + std::string(help) +
           (fallback ? fallback->empty() ? " [optional]" : " [default " + *fallback + "]"
                     : " [required]") +
           "\n";
  if (const auto found = options_.find(std::string(name)); found != options_.end()) {
    return found->second;
  }
  const std::string variable = variable_of(name);
  if (environment_from_process_) {
    if (const char* value = std::getenv(variable.c_str())) return std::string(value);
  } else if (const auto found = environment_.find(variable); found != environment_.end()) {
    return found->second;
  }
  if (!fallback) {
    mistakes_.push_back("--" + std::string(name) + " (or " + variable +
                        ") is required: " + std::string(help));
  }
  return fallback;
}

std::string ConfigReader::text(std::string_view name, std::string_view help,
                               std::optional<std::string> fallback) {
  const bool required = !fallback;
  auto value = take(name, help, fallback);
  if (value && value->empty() && required) {
    mistakes_.push_back("--" + std::string(name) + " must not be empty");
  }
  return value.value_or("");
}

std::int64_t ConfigReader::integer(std::string_view name, std::string_view help, std::int64_t low,
                                   std::int64_t high, std::optional<std::int64_t> fallback) {
  const auto value =
      take(name, help, fallback ? std::optional(std::to_string(*fallback)) : std::nullopt);
  if (!value) return low;
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(value->data(), value->data() + value->size(), number);
  if (error != std::errc() || end != value->data() + value->size() || number < low ||
      number > high) {
    mistakes_.push_back("--" + std::string(name) + " must be a whole number from " +
                        std::to_string(low) + " to " + std::to_string(high));
    return low;
  }
  return number;
}

std::uint16_t ConfigReader::port(std::string_view name, std::string_view help,
                                 std::optional<std::uint16_t> fallback) {
  return static_cast<std::uint16_t>(integer(
      name, help, 1, 65535, fallback ? std::optional<std::int64_t>(*fallback) : std::nullopt));
}

std::string ConfigReader::one_of(std::string_view name, std::string_view help,
                                 const std::vector<std::string>& choices,
                                 std::optional<std::string> fallback) {
  std::string listed;
  for (const std::string& choice : choices) listed += (listed.empty() ? "" : " | ") + choice;
  const auto value = take(name, std::string(help) + " (" + listed + ")", fallback);
  if (!value) return choices.front();
  if (std::find(choices.begin(), choices.end(), *value) == choices.end()) {
    mistakes_.push_back("--" + std::string(name) + " must be one of " + listed);
    return choices.front();
  }
  return *value;
}

std::string ConfigReader::directory(std::string_view name, std::string_view help) {
  const auto value = take(name, help, std::nullopt);
  if (!value) return {};
  std::error_code ignored;
  if (!std::filesystem::is_directory(*value, ignored) || access(value->c_str(), R_OK | X_OK) != 0) {
    mistakes_.push_back("--" + std::string(name) +
                        ": the directory does not exist or is not accessible");
  }
  return *value;
}

bool ConfigReader::flag(std::string_view name, std::string_view help) {
  const auto value = take(name, help, "false");
  if (value == "true" || value == "1") return true;
  if (value != "false" && value != "0") {
    mistakes_.push_back("--" + std::string(name) + " must be true or false");
  }
  return false;
}

std::optional<int> ConfigReader::finish(std::string_view about) {
  if (help_requested_) {
    std::printf("%s\n\n%s", std::string(about).c_str(), help_.c_str());
    return 0;
  }
  bool usage = false;
  for (const auto& [name, value] : options_) {
    if (std::find(known_.begin(), known_.end(), name) == known_.end()) {
      mistakes_.push_back("unknown option --" + name + " (see --help)");
      usage = true;
    }
  }
  if (mistakes_.empty()) return std::nullopt;
  for (const std::string& mistake : mistakes_) std::fprintf(stderr, "%s\n", mistake.c_str());
  return usage ? kExitUsage : kExitConfig;
}

}  // namespace diaphane
