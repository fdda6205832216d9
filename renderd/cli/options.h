#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "renderd/cli/stop_rule.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::cli {

/// Exit codes (sysexits.h), as `--help` lists them.
inline constexpr int kExitUsage = 64;        ///< wrong command line
inline constexpr int kExitData = 65;         ///< input or scene is wrong
inline constexpr int kExitNoInput = 66;      ///< input or scene cannot be read
inline constexpr int kExitNoDevice = 69;     ///< no device of the engine asked for, or it was lost
inline constexpr int kExitDefect = 70;       ///< a defect of ours
inline constexpr int kExitResources = 71;    ///< not enough memory, on the device or here
inline constexpr int kExitCannotWrite = 73;  ///< picture or report cannot be written

/// What one run of `diaphane-render` was asked to do.
struct Options {
  std::string input;
  std::string scene_file;  ///< this or `preset`, never both
  std::string preset;
  Canvas canvas{512, 512};
  std::optional<std::uint32_t> samples;  ///< per pixel
  std::optional<double> error;           ///< estimated error to reach
  std::optional<double> seconds;         ///< of rendering
  std::optional<std::uint32_t> bounces;  ///< instead of the scene's
  EngineChoice engine = EngineChoice::kAuto;
  unsigned threads = 0;  ///< 0: all cores
  std::uint64_t seed = 1;
  Method method;
  std::string picture;  ///< .png, .exr or .ppm
  std::string report;   ///< JSON; "-" is standard output; empty: none
  bool denoise = false;
  bool quiet = false;

  StopRule stop_rule() const;
};

/// What to do instead of rendering: text for the user and the exit code.
struct Farewell {
  int exit_code = 0;
  std::string text;  ///< on standard output when the code is 0, else on standard error
};

std::variant<Options, Farewell> parse(int argc, const char* const* argv);

/// The exit code for an error while rendering.
int exit_code_of(ErrorCode code);

}  // namespace diaphane::render::cli
