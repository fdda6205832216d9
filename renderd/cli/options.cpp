#include "renderd/cli/options.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <filesystem>
#include <functional>
#include <sstream>

#include "renderd/cli/picture_file.h"

namespace diaphane::render::cli {
namespace {

constexpr std::uint32_t kLongestSide = 8192;
constexpr std::uint32_t kDefaultSamples = 64;

constexpr const char* kAbout =
    "Renders a scan to a picture file, by the same renderer as the server's, without a server.\n"
    "\n"
    "INPUT is a folder of DICOM files, a file .mha, .mhd, .nii, .nii.gz or .nrrd, or a directory "
    "of\n"
    "the volume store (with volume.json). What the picture shows is a scene file (JSON: "
    "docs/scenes.md\n"
    "has every field and an example of each; lengths in millimetres, origin at the centre of the\n"
    "volume's box, x to the patient's left, y to the back, z to the head) or a preset fitted to "
    "the scan.\n"
    "\n"
    "It renders until the first of --samples, --error and --seconds is reached; with none of them, "
    "64\n"
    "samples.";

constexpr const char* kFooter =
    "\nExamples:\n"
    "  diaphane-render head/ --preset bone --out head.png\n"
    "  diaphane-render ct.nii.gz --scene scene.json --size 1920x1080 --samples 256 \\\n"
    "      --out ct.exr --json ct.json\n"
    "  diaphane-render ct.nrrd --scene scene.json --error 0.02 --seconds 60 --out ct.png --json "
    "-\n"
    "\n"
    "The report (--json) holds: samples (per pixel), milliseconds (of rendering alone), "
    "estimated_error\n"
    "(relative RMSE of the picture against the converged one, null below two samples), "
    "stopped_by\n"
    "(samples, error or seconds), dropped_samples (not finite), samples_per_second (of all "
    "pixels),\n"
    "engine, device, features (what the scene needs of the renderer: compiled in), left_out (what "
    "it does\n"
    "not need), kernel (the program's code for it: compiled_in, left_out, registers, empty_cells "
    "skipped,\n"
    "bytes on the device), denoised (whether the picture was smoothed; the error is the raw "
    "one's), "
    "width,\n"
    "height, seed.\n"
    "The same engine, seed, size and samples give the same picture, bit by bit; --seconds depends "
    "on the\n"
    "machine.\n"
    "\n"
    "Exit codes: 0 done, 64 wrong command line, 65 input or scene is wrong, 66 it cannot be read,\n"
    "69 no such device, 70 a defect of ours, 71 not enough memory, 73 cannot write.";

std::string parse_size(const std::string& text, Canvas& canvas) {
  const std::size_t cross = text.find_first_of("xX");
  const auto number = [&](std::size_t from, std::size_t to, std::uint32_t& out) {
    const char* last = text.data() + to;
    const auto [end, error] = std::from_chars(text.data() + from, last, out);
    return error == std::errc{} && end == last && out >= 1 && out <= kLongestSide;
  };
  if (cross == std::string::npos || !number(0, cross, canvas.width) ||
      !number(cross + 1, text.size(), canvas.height)) {
    return "WIDTHxHEIGHT in pixels, each 1 to " + std::to_string(kLongestSide) + ": not '" + text +
           "'";
  }
  return {};
}

/// A validator of its own, because CLI11 takes "-1" for a very large unsigned number.
std::function<std::string(const std::string&)> whole_number(std::uint64_t low, std::uint64_t high) {
  return [low, high](const std::string& text) -> std::string {
    std::uint64_t number = 0;
    const char* last = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data(), last, number);
    if (error == std::errc{} && end == last && number >= low && number <= high) return {};
    return "a whole number from " + std::to_string(low) + " to " + std::to_string(high) +
           ": not '" + text + "'";
  };
}

std::function<std::string(const std::string&)> positive_number(double most) {
  return [most](const std::string& text) -> std::string {
    double number = 0;
    const char* last = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data(), last, number);
    if (error == std::errc{} && end == last && number > 0 && number <= most) return {};
    std::ostringstream out;
    out << "a number above 0, " << most << " at most: not '" << text << "'";
    return out.str();
  };
}

std::string engine_name(const std::string& text) {
  if (text == "auto" || text == "cpu" || text == "cuda") return {};
  return "auto, cpu or cuda: not '" + text + "'";
}

/// The words of an option and what each means.
template <typename T>
using Words = std::vector<std::pair<std::string, T>>;
const Words<Walk> kWalks{
    {"auto", Walk::kAuto}, {"exact", Walk::kExact}, {"tracking", Walk::kTracking}};
const Words<bool> kPoints{{"low-discrepancy", true}, {"independent", false}};
const Words<Mis> kMis{{"both", Mis::kBoth}, {"light", Mis::kLight}, {"scatter", Mis::kScatter}};

template <typename T>
std::function<std::string(const std::string&)> one_of(const Words<T>& words, T& chosen) {
  return [&](const std::string& text) -> std::string {
    std::string known;
    for (const auto& [word, value] : words) {
      if (word == text) {
        chosen = value;
        return {};
      }
      known += (known.empty() ? "" : ", ") + word;
    }
    return known + ": not '" + text + "'";
  };
}

std::string check_picture(const std::string& path) {
  if (auto problem = unwritable_picture(path)) return *problem;
  return {};
}

std::string check_folder_of(const std::string& path) {
  if (path == "-") return {};
  const std::filesystem::path parent = std::filesystem::absolute(path).parent_path();
  std::error_code ignored;
  if (!std::filesystem::is_directory(parent, ignored)) return "no such folder: " + parent.string();
  return {};
}

}  // namespace

std::variant<Options, Farewell> parse(int argc, const char* const* argv) {
  Options options;
  ::CLI::App app(kAbout, "diaphane-render");
  app.footer(kFooter);
  app.get_formatter()->column_width(34);
  app.option_defaults()->multi_option_policy(::CLI::MultiOptionPolicy::Throw);

  app.add_option("INPUT", options.input, "the scan")->required();
  auto* scene =
      app.add_option("--scene", options.scene_file, "scene file (JSON)")->type_name("FILE");
  auto* preset =
      app.add_option("--preset", options.preset, "skin, muscle, vessels, bone or airways")
          ->type_name("NAME")
          ->excludes(scene);
  std::string size;
  app.add_option("--size", size, "picture size in pixels, default 512x512")
      ->type_name("WxH")
      ->check([&](const std::string& text) { return parse_size(text, options.canvas); }, "");
  app.add_option("--samples", options.samples,
                 "samples per pixel at most; default 64, or no limit with --error or --seconds")
      ->type_name("N")
      ->check(whole_number(1, StopRule::kMostSamples), "");
  app.add_option("--error", options.error,
                 "stop when the estimated error is at most this; 0.05 is 5% of the way from black "
                 "to white")
      ->type_name("E")
      ->check(positive_number(1), "");
  app.add_option("--seconds", options.seconds,
                 "stop after so many seconds of rendering (one sample at least)")
      ->type_name("S")
      ->check(positive_number(1e6), "");
  app.add_option("--bounces", options.bounces,
                 "collisions of a light path at most, 1 to 1024, instead of the scene's")
      ->type_name("N")
      ->check(whole_number(1, 1024), "");
  std::string engine = "auto";
  app.add_option("--engine", engine, "auto, cpu or cuda; auto takes CUDA when a device answers")
      ->type_name("NAME")
      ->check(engine_name, "");
  app.add_option("--threads", options.threads, "of the CPU engine; 0, the default: one a core")
      ->type_name("N")
      ->check(whole_number(0, 4096), "");
  app.add_option("--seed", options.seed, "of the random numbers, default 1")
      ->type_name("N")
      ->check(whole_number(0, ~std::uint64_t{0}), "");
  std::string walk, points, mis;
  app.add_option("--estimator", walk,
                 "auto, exact or tracking: how collisions and shadows are found; all have the same "
                 "mean")
      ->type_name("NAME")
      ->check(one_of(kWalks, options.method.walk), "");
  app.add_option("--points", points, "low-discrepancy (default) or independent")
      ->type_name("NAME")
      ->check(one_of(kPoints, options.method.low_discrepancy), "");
  app.add_option("--mis", mis, "direct light from samples of the light, of the scatter or both")
      ->type_name("NAME")
      ->check(one_of(kMis, options.method.mis), "");
  app.add_option(
         "--out", options.picture,
         "picture: .png or .ppm (8 bits, tone-mapped) or .exr (linear radiance, 32-bit float)")
      ->required()
      ->type_name("FILE")
      ->check(check_picture, "")
      ->check(check_folder_of, "");
  app.add_option("--json", options.report, "report; - is standard output")
      ->type_name("FILE")
      ->check(check_folder_of, "");
  app.add_flag(
      "--denoise", options.denoise,
      "smooth what is still noise, as the server does with the first pictures of a session");
  app.add_flag("--quiet", options.quiet, "no progress on standard error");

  try {
    app.parse(argc, argv);
    options.engine = engine == "cuda"  ? EngineChoice::kCuda
                     : engine == "cpu" ? EngineChoice::kCpu
                                       : EngineChoice::kAuto;
    if (!*scene && !*preset) throw ::CLI::RequiredError("--scene or --preset");
  } catch (const ::CLI::ParseError& error) {
    std::ostringstream out, err;
    if (app.exit(error, out, err) == 0) return Farewell{0, out.str()};
    return Farewell{kExitUsage, "diaphane-render: " + err.str()};
  }
  return options;
}

StopRule Options::stop_rule() const {
  StopRule rule{.error = error, .seconds = seconds};
  if (samples) {
    rule.samples = *samples;
  } else if (!error && !seconds) {
    rule.samples = kDefaultSamples;
  }
  return rule;
}

int exit_code_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalid:
    case ErrorCode::kUnsupported:
    case ErrorCode::kTooLarge:
      return kExitData;
    case ErrorCode::kNotFound:
    case ErrorCode::kForbidden:
      return kExitNoInput;
    case ErrorCode::kUnavailable:
    case ErrorCode::kDeviceLost:
      return kExitNoDevice;
    case ErrorCode::kOutOfMemory:
      return kExitResources;
    default:
      return kExitDefect;
  }
}

}  // namespace diaphane::render::cli
