#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "renderd/cli/labels.h"
#include "renderd/cli/stop_rule.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::cli {

/// Exit codes (sysexits.h), as `--help` lists them.
inline constexpr int kExitUsage = 64;    ///< wrong command line
inline constexpr int kExitData = 65;     ///< invalid input or scene
inline constexpr int kExitNoInput = 66;  ///< unreadable input or scene
/// The requested engine has no device, or the device was lost.
inline constexpr int kExitNoDevice = 69;
inline constexpr int kExitDefect = 70;       ///< internal error
inline constexpr int kExitResources = 71;    ///< not enough memory on the device or the host
inline constexpr int kExitCannotWrite = 73;  ///< the picture or report cannot be written

/// The options of one run of `diaphane-render`.
struct Options {
  std::string input;
  std::string scene_file;  ///< excludes `preset`
  std::string preset;
  std::string environment;             ///< panorama that replaces the lights; empty: none
  std::optional<std::uint32_t> phase;  ///< overrides the scene's
  std::string label_file;              ///< empty: none
  std::vector<LabelOption> labels;     ///< requires `label_file`
  /// Centre and radius of the sphere that is highlighted, mm.
  std::optional<std::array<double, 4>> highlight;
  std::string over;             ///< the second scan; empty: none
  std::string aligned;          ///< auto, identity or a file; empty: by the frame of reference
  std::string over_look;        ///< empty: the scene's, or the default for the two scans
  std::optional<double> share;  ///< overrides that of the scene or the look
  std::optional<double> split;  ///< shows the second scan to the right of it
  Canvas canvas{512, 512};
  std::optional<std::uint32_t> samples;  ///< per pixel
  std::optional<double> error;           ///< estimated error at which to stop
  std::optional<double> seconds;         ///< rendering time
  std::optional<std::uint32_t> bounces;  ///< overrides the scene's
  EngineChoice engine = EngineChoice::kAuto;
  unsigned threads = 0;  ///< 0: all cores
  std::uint64_t seed = 1;
  Method method;
  bool show_table = false;     ///< shows everything around the body, too
  bool stored_slices = false;  ///< does not interpolate slices
  std::string picture;         ///< .png, .exr or .ppm
  std::string report;          ///< path for JSON; "-" is standard output; empty: none
  bool denoise = false;
  bool list_labels = false;   ///< prints the labels of `label_file`, and renders nothing
  bool list_presets = false;  ///< prints the presets that the scan can show, and renders nothing
  bool quiet = false;

  StopRule stop_rule() const;
};

/// Text and exit code for a run that ends without rendering.
struct EarlyExit {
  int exit_code = 0;
  std::string text;  ///< text for standard output if the code is 0, else for standard error
};

std::variant<Options, EarlyExit> parse(int argc, const char* const* argv);

/// Returns the exit code for an error during rendering.
int exit_code_of(ErrorCode code);

}  // namespace diaphane::render::cli
