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
    R"(Renders a scan to a picture file with the server's renderer, but needs no server.

INPUT is a folder of DICOM files, a .mha, .mhd, .nii, .nii.gz or .nrrd file, or a directory of the
volume store (with volume.json). Describe the picture with a scene file or choose a preset, which is
fitted to the scan. docs/scenes.md documents every field of a scene file (JSON) with an example.
Lengths are in millimetres. The origin is the centre of the volume's box, x points to the patient's
left, y to the back, z to the head.

Rendering stops at the first of --samples, --error and --seconds that is reached. If none of them is
given, it stops after 64 samples per pixel.)";

constexpr const char* kFooter = R"(
Examples:
  diaphane-render head/ --preset bone --out head.png
  diaphane-render ct.nii.gz --scene scene.json --size 1920x1080 --samples 256 \
      --out ct.exr --json ct.json
  diaphane-render head.nii.gz --preset skin --labels nuclei.nii.gz --label 1=#e04030 \
      --label 2=solo --out nuclei.png
  diaphane-render ct/ --preset skin --over pet/ --share 0.8 --out fused.png
  diaphane-render ct.nrrd --scene scene.json --error 0.02 --seconds 60 --out ct.png --json -

The report (--json) contains these fields:
  samples             samples per pixel
  milliseconds        time spent rendering
  estimated_error     relative RMSE against the converged picture; null below two samples. For a
                      denoised picture, this is the error before denoising
  error_curve         samples, milliseconds and error after each pass, from the first with a known
                      error. Passes within 5% more samples than the one before are left out
  stopped_by          samples, error or seconds
  dropped_samples     samples that were not finite
  samples_per_second  of all pixels together
  engine, device      what rendered the picture
  features            renderer features that the scene needs
  left_out            renderer features that the scene does not need
  kernel              the kernel used: features compiled in and left out, registers, number of empty
                      cells skipped, bytes on the device
  denoised            whether the picture was denoised
  width, height       of the picture, in pixels
  seed                of the random numbers

The same engine, seed, size and number of samples always give the same picture, bit for bit. With
--seconds, the picture depends on the speed of the machine.

Exit codes:
  0   success
  64  invalid command line
  65  invalid input or scene
  66  input or scene cannot be read
  69  device not available
  70  internal error
  71  out of memory
  73  output cannot be written)";

std::string parse_size(const std::string& text, Canvas& canvas) {
  const std::size_t cross = text.find_first_of("xX");
  const auto number = [&](std::size_t from, std::size_t to, std::uint32_t& out) {
    const char* last = text.data() + to;
    const auto [end, error] = std::from_chars(text.data() + from, last, out);
    return error == std::errc{} && end == last && out >= 1 && out <= kLongestSide;
  };
  if (cross == std::string::npos || !number(0, cross, canvas.width) ||
      !number(cross + 1, text.size(), canvas.height)) {
    return "must be WIDTHxHEIGHT in pixels, each from 1 to " + std::to_string(kLongestSide) +
           ", but got '" + text + "'";
  }
  return {};
}

/// Returns a validator. That of CLI11 accepts "-1" as a very large unsigned number.
std::function<std::string(const std::string&)> whole_number(std::uint64_t low, std::uint64_t high) {
  return [low, high](const std::string& text) -> std::string {
    std::uint64_t number = 0;
    const char* last = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data(), last, number);
    if (error == std::errc{} && end == last && number >= low && number <= high) return {};
    return "must be a whole number from " + std::to_string(low) + " to " + std::to_string(high) +
           ", but got '" + text + "'";
  };
}

std::function<std::string(const std::string&)> positive_number(double most) {
  return [most](const std::string& text) -> std::string {
    double number = 0;
    const char* last = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data(), last, number);
    if (error == std::errc{} && end == last && number > 0 && number <= most) return {};
    std::ostringstream out;
    out << "must be a number above 0 and at most " << most << ", but got '" << text << "'";
    return out.str();
  };
}

std::string parse_highlight(const std::string& text,
                            std::optional<std::array<double, 4>>& highlight) {
  std::array<double, 4> numbers{};
  const char* at = text.data();
  const char* last = at + text.size();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto [end, error] = std::from_chars(at, last, numbers[i]);
    const bool ends = i + 1 == numbers.size() ? end == last : end != last && *end == ',';
    if (error != std::errc{} || !ends) {
      return "must be X,Y,Z,RADIUS in mm, for example 10,-20,5,15, but got '" + text + "'";
    }
    at = end + 1;
  }
  highlight = numbers;
  return {};
}

std::string engine_name(const std::string& text) {
  if (text == "auto" || text == "cpu" || text == "cuda") return {};
  return "must be auto, cpu or cuda, but got '" + text + "'";
}

/// The values of an option with their meanings.
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
    return "must be one of " + known + ", but got '" + text + "'";
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

/// Values that are converted after or while they are parsed.
struct Texts {
  std::string size, highlight, engine = "auto", walk, points, mis;
  std::vector<std::string> labels;
};

void add_input(::CLI::App& app, Options& options, Texts& texts) {
  app.add_option("INPUT", options.input, "the scan")->required();
  auto* scene =
      app.add_option("--scene", options.scene_file, "scene file (JSON)")->type_name("FILE");
  app.add_option(
         "--preset", options.preset,
         "preset: skin, muscle, vessels, bone or airways, for a CT through or dense, and for an MR "
         "scan of a head brain or through")
      ->type_name("NAME")
      ->excludes(scene);
  app.add_flag("--list-presets", options.list_presets,
               "print the names of the presets that this scan can show, and render nothing")
      ->excludes(scene);
  app.add_option("--environment", options.environment,
                 "panorama (.hdr or .exr, at most 4 MB) that lights the picture instead of the "
                 "lights of the scene or preset")
      ->type_name("FILE");
  app.add_option("--phase", options.phase,
                 "phase of a scan with several, counted from 0 (default: that of the scene, or 0)")
      ->type_name("N");
  app.add_option("--size", texts.size, "size of the picture in pixels (default: 512x512)")
      ->type_name("WxH")
      ->check([&options](const std::string& text) { return parse_size(text, options.canvas); }, "");
}

std::string check_label(const std::string& text) {
  if (parse_label(text)) return {};
  return "must be NAME=LOOK, for example Liver=#c04030,0.5 or 7=solo, but got '" + text + "'";
}

void add_labels(::CLI::App& app, Options& options, Texts& texts) {
  app.add_option("--labels", options.label_file,
                 "labels of the scan, in their colours: a NIfTI label volume, a DICOM "
                 "segmentation (SEG) or a DICOM structure set (RTSTRUCT)")
      ->type_name("FILE");
  app.add_option("--label", texts.labels,
                 "how to show a label, by name or number (0: all other matter), also of the parts "
                 "that are found in the scan (brain, bone, lungs, airways, vessels): a colour "
                 "(#rrggbb), an opacity (0 hides "
                 "it, 1 shows its matter as it is) and solo (hides all else), separated by commas; "
                 "may be repeated")
      ->type_name("NAME=LOOK")
      ->take_all()
      ->allow_extra_args(false)
      ->check(check_label, "");
  app.add_flag("--list-labels", options.list_labels,
               "print number, colour, volume and name of each label, and render nothing");
}

void add_highlight(::CLI::App& app, Options& options, Texts& texts) {
  app.add_option("--highlight", texts.highlight,
                 "tint the matter in the sphere with this centre and radius (mm) blue")
      ->type_name("X,Y,Z,RADIUS")
      ->check(
          [&options](const std::string& text) { return parse_highlight(text, options.highlight); },
          "");
}

std::function<std::string(const std::string&)> part() {
  return [](const std::string& text) -> std::string {
    double number = 0;
    const char* last = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data(), last, number);
    if (error == std::errc{} && end == last && number >= 0 && number <= 1) return {};
    return "must be a number from 0 to 1, but got '" + text + "'";
  };
}

void add_second(::CLI::App& app, Options& options) {
  auto* over = app.add_option("--over", options.over, "a second scan, shown over the first")
                   ->type_name("SCAN");
  app.add_option("--aligned", options.aligned,
                 "how the second scan lies: auto aligns it by its contents, identity takes the "
                 "positions in both scans, and a file is from diaphane-align --json (default: "
                 "identity if both share a frame of reference)")
      ->type_name("FILE")
      ->needs(over);
  app.add_option("--over-look", options.over_look,
                 "look of the second scan: hot for PET, bone for CT, tint or same")
      ->type_name("NAME")
      ->needs(over);
  app.add_option("--share", options.share,
                 "0 shows the first scan alone, 0.5 both, 1 the second alone")
      ->type_name("S")
      ->check(part(), "")
      ->needs(over);
  app.add_option("--split", options.split,
                 "show the second scan only to the right of this part of the picture's width")
      ->type_name("X")
      ->check(part(), "")
      ->needs(over);
}

void add_stop_rule(::CLI::App& app, Options& options) {
  app.add_option("--samples", options.samples,
                 "maximum samples per pixel (default: 64, or no limit with --error or --seconds)")
      ->type_name("N")
      ->check(whole_number(1, StopRule::kMostSamples), "");
  app.add_option("--error", options.error,
                 "stop at this estimated error; 0.05 is 5% of the range from black to white")
      ->type_name("E")
      ->check(positive_number(1), "");
  app.add_option("--seconds", options.seconds,
                 "stop after this many seconds of rendering (but not before the first sample)")
      ->type_name("S")
      ->check(positive_number(1e6), "");
}

void add_engine(::CLI::App& app, Options& options, Texts& texts) {
  app.add_option("--bounces", options.bounces,
                 "maximum collisions per light path, 1 to 1024 (default: the scene's value)")
      ->type_name("N")
      ->check(whole_number(1, 1024), "");
  app.add_option("--engine", texts.engine,
                 "auto, cpu or cuda; auto uses CUDA if a device is available")
      ->type_name("NAME")
      ->check(engine_name, "");
  app.add_option("--threads", options.threads,
                 "threads of the CPU engine (default: 0, one per core)")
      ->type_name("N")
      ->check(whole_number(0, 4096), "");
  app.add_option("--seed", options.seed, "seed of the random numbers (default: 1)")
      ->type_name("N")
      ->check(whole_number(0, ~std::uint64_t{0}), "");
}

void add_method(::CLI::App& app, Options& options, Texts& texts) {
  app.add_option(
         "--estimator", texts.walk,
         "how collisions and shadows are found: auto, exact or tracking; all converge to the "
         "same picture")
      ->type_name("NAME")
      ->check(one_of(kWalks, options.method.walk), "");
  app.add_option("--points", texts.points,
                 "sample points: low-discrepancy (default) or independent")
      ->type_name("NAME")
      ->check(one_of(kPoints, options.method.low_discrepancy), "");
  app.add_option("--mis", texts.mis, "how direct light is sampled: light, scatter or both")
      ->type_name("NAME")
      ->check(one_of(kMis, options.method.mis), "");
  app.add_flag("--show-table", options.show_table,
               "show the table, headrest or frame and the noise of the air, which are hidden");
  app.add_flag("--stored-slices", options.stored_slices,
               "render the stored slices alone; by default, further ones are interpolated where "
               "they are far apart");
}

void add_output(::CLI::App& app, Options& options) {
  app.add_option("--out", options.picture,
                 "output picture: .png or .ppm (8 bits, tone-mapped), or .exr (linear radiance, "
                 "32-bit float)")
      ->type_name("FILE")
      ->check(check_picture, "")
      ->check(check_folder_of, "");
  app.add_option("--json", options.report, "write a report to FILE; - means standard output")
      ->type_name("FILE")
      ->check(check_folder_of, "");
  app.add_flag("--denoise", options.denoise,
               "denoise the picture, as the server does with the first pictures of a session");
  app.add_flag("--quiet", options.quiet, "show no progress on standard error");
}

EngineChoice engine_choice(const std::string& name) {
  return name == "cuda"  ? EngineChoice::kCuda
         : name == "cpu" ? EngineChoice::kCpu
                         : EngineChoice::kAuto;
}

}  // namespace

std::variant<Options, EarlyExit> parse(int argc, const char* const* argv) {
  Options options;
  ::CLI::App app(kAbout, "diaphane-render");
  app.footer(kFooter);
  app.get_formatter()->column_width(34);
  app.option_defaults()->multi_option_policy(::CLI::MultiOptionPolicy::Throw);

  // The help shows the options in this order.
  Texts texts;
  add_input(app, options, texts);
  add_labels(app, options, texts);
  add_highlight(app, options, texts);
  add_second(app, options);
  add_stop_rule(app, options);
  add_engine(app, options, texts);
  add_method(app, options, texts);
  add_output(app, options);

  try {
    app.parse(argc, argv);
    options.engine = engine_choice(texts.engine);
    for (const std::string& text : texts.labels) options.labels.push_back(*parse_label(text));
    if (!options.list_presets && !options.list_labels) {
      if (app.count("--scene") == 0 && app.count("--preset") == 0) {
        throw ::CLI::RequiredError("--scene or --preset");
      }
      if (app.count("--out") == 0) throw ::CLI::RequiredError("--out");
    }
  } catch (const ::CLI::ParseError& error) {
    std::ostringstream out, err;
    if (app.exit(error, out, err) == 0) return EarlyExit{0, out.str()};
    return EarlyExit{kExitUsage, "diaphane-render: " + err.str()};
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
