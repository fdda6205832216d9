#include "renderd/cli/command.h"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <optional>
#include <sstream>
#include <thread>

#include "common/try.h"
#include "renderd/cli/input.h"
#include "renderd/cli/picture_file.h"
#include "renderd/cli/report.h"
#include "renderd/cli/scan_readers.h"
#include "renderd/cli/second.h"
#include "renderd/cli/stop_rule.h"
#include "renderd/scene/contrast_agent.h"
#include "renderd/scene/presets.h"
#include "scene/environment_import.h"
#include "volume/labels.h"
#include "volume/slice_interpolation.h"

namespace diaphane::render::cli {
namespace {

/// Maximum size of a scene file, which includes its textures.
constexpr std::streamsize kLargestScene = 64 << 20;
/// Seconds between two progress lines.
constexpr double kShowEvery = 0.2;

Result<std::string> read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text;
  if (file) {
    // Reads in pieces, because most files are small.
    char piece[1 << 16];
    while (std::ssize(text) <= kLargestScene && file) {
      file.read(piece, sizeof piece);
      text.append(piece, static_cast<std::size_t>(file.gcount()));
    }
  }
  if (file.bad() || !file.is_open()) return fail(ErrorCode::kNotFound, "cannot read " + path);
  if (std::ssize(text) > kLargestScene) {
    return fail(ErrorCode::kInvalid, path + " is too large to be a scene file");
  }
  return text;
}

/// Replaces the lights of a scene by the panorama of --environment, if there is one.
Result<void> light_by_environment(const Options& options, diaphane::v1::Scene& scene) {
  if (options.environment.empty()) return {};
  const auto file = read_text(options.environment);
  DIAPHANE_TRY(file);
  const auto imported = scene::import_panorama(*file);
  if (!imported) {
    return fail(ErrorCode::kInvalid, scene::sentence_of(imported.error()), "--environment");
  }
  scene.clear_lights();
  auto* light = scene.add_lights()->mutable_environment();
  light->mutable_texture()->set_picture(scene::write_environment(*imported));
  auto* radiance = light->mutable_radiance();
  radiance->set_r(1);
  radiance->set_g(1);
  radiance->set_b(1);
  return {};
}

/// Returns the scene of --scene, or nullopt if there is a preset instead.
Result<std::optional<diaphane::v1::Scene>> scene_from_file(const Options& options) {
  if (options.scene_file.empty()) return std::nullopt;
  auto text = read_text(options.scene_file);
  if (!text) return tl::make_unexpected(text.error());
  return scene_from_json(*text);
}

Result<diaphane::v1::Scene> scene_of_preset(const std::string& name, const volume::Volume& volume) {
  auto preset = preset_for(volume.header, visible_part(volume), name, brain_of(volume));
  // An unknown preset is not a missing file.
  if (!preset) return fail(ErrorCode::kInvalid, preset.error().message, "--preset");
  return preset->scene();
}

/// Adds the labels of --labels and the parts that are found in the scan to its label set.
Result<void> collect_labels(const Options& options, volume::Volume& input) {
  if (!options.label_file.empty()) {
    auto set = read_label_file(options.label_file, input.header);
    DIAPHANE_TRY(set);
    input.label_set = *std::move(set);
  }
  if (input.labels.empty()) cli::add_labels(input);
  volume::list_found_labels(input);
  return {};
}

/// Prints the labels of the scan, one per line.
Result<void> print_labels(const Options& options) {
  auto input = read_input(options.input);
  DIAPHANE_TRY(input);
  DIAPHANE_TRY(collect_labels(options, *input));
  list_labels(input->label_set, input->header, std::cout);
  return {};
}

/// Adds the labels of the scan to the scene.
Result<void> add_marked(const Options& options, volume::Volume& input, diaphane::v1::Scene& scene) {
  if (options.label_file.empty() && options.labels.empty()) return {};
  DIAPHANE_TRY(collect_labels(options, input));
  return show_labels(input.label_set, options.labels, scene);
}

/// Adds the highlight of --highlight to the scene.
void add_highlight(const Options& options, diaphane::v1::Scene& scene) {
  if (!options.highlight) return;
  const auto [x, y, z, radius] = *options.highlight;
  auto& highlight = *scene.mutable_highlight();
  highlight.mutable_centre()->set_x(x);
  highlight.mutable_centre()->set_y(y);
  highlight.mutable_centre()->set_z(z);
  highlight.set_radius(radius);
  // Blue does not occur in the body.
  highlight.mutable_colour()->set_r(0.05);
  highlight.mutable_colour()->set_g(0.25);
  highlight.mutable_colour()->set_b(0.9);
}

/// Prints the presets that the scan can show, one per line.
Result<void> list_presets(const Options& options) {
  auto input = read_input(options.input);
  DIAPHANE_TRY(input);
  if (!options.show_table) DIAPHANE_TRY(show_only_body(*input));
  const bool contrast_agent = shows_contrast_agent(*input);
  for (const auto& preset :
       presets_for(input->header, visible_part(*input), contrast_agent, brain_of(*input))) {
    std::cout << preset.name() << '\n';
  }
  return {};
}

struct Ending {
  std::uint64_t dropped = 0;
  StopReason reason = StopReason::kSamples;
  ErrorCurve curve;
};

/// Renders until a limit of the stop rule is reached and shows progress on a terminal. Measures the
/// error after each pass only for a report, because that takes time.
Result<Ending> render_all(ProgressiveRenderer& renderer, const Options& options) {
  using Clock = std::chrono::steady_clock;
  const bool show = !options.quiet && ::isatty(STDERR_FILENO) == 1;
  const bool reports = !options.report.empty();
  const auto begin = Clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  const StopRule rule = options.stop_rule();
  Pace pace(rule);
  Ending ending;
  std::uint64_t done = 0;
  const auto stop = [&] { return done > 0 && rule.seconds && elapsed() >= *rule.seconds; };
  double last_shown = 0;
  for (;;) {
    auto batch = renderer.render(pace.piece(), stop);
    if (!batch) return tl::make_unexpected(batch.error());
    ending.dropped += batch->dropped_samples;
    done += batch->samples;
    pace.advance(done);
    const double now = elapsed();
    const bool show_now = show && now >= last_shown + kShowEvery;
    std::optional<double> error;
    if (pace.error_is_due() || show_now || reports) {
      const Progress progress = renderer.progress();
      error = progress.error;
      if (reports) ending.curve.add({progress.samples, progress.seconds, progress.error});
    }
    const auto reason = pace.reached(elapsed(), pace.error_is_due() ? error : std::nullopt);
    if (show_now || (show && reason)) {
      if (!error) error = renderer.progress().error;
      std::fprintf(stderr, "\r%llu samples, %.1f s, error %.4f ",
                   static_cast<unsigned long long>(done), now, *error);
      last_shown = now;
    }
    if (!reason) continue;
    if (show) std::fputc('\n', stderr);
    ending.reason = *reason;
    return ending;
  }
}

struct Encoded {
  std::string bytes;
  bool denoised = false;
};

/// Encodes the current picture, denoised if `denoise` is set and the renderer was prepared for it.
Result<Encoded> encode(PictureSource& renderer, PictureFormat format, bool denoise) {
  const auto no = [] { return false; };
  if (format == PictureFormat::kExr) {
    PictureRgbF picture;
    const Result<bool> denoised =
        denoise ? renderer.radiance_denoised(picture) : renderer.radiance(picture).map(no);
    if (!denoised) return tl::make_unexpected(denoised.error());
    return encode_exr(picture).map([&](std::string bytes) {
      return Encoded{std::move(bytes), *denoised};
    });
  }
  PictureRgb8 picture;
  const Result<bool> denoised =
      denoise ? renderer.display_denoised(picture) : renderer.display(picture).map(no);
  if (!denoised) return tl::make_unexpected(denoised.error());
  if (format == PictureFormat::kPpm) return Encoded{encode_ppm(picture), *denoised};
  return encode_png(picture).map([&](std::string bytes) {
    return Encoded{std::move(bytes), *denoised};
  });
}

struct Rendered {
  std::string picture;
  Outcome outcome;
};

/// Reads the scan, or the phase of it that the scene or --phase says, without what surrounds the
/// body.
Result<volume::Volume> read_first(const Options& options,
                                  const std::optional<diaphane::v1::Scene>& given) {
  const std::uint32_t of_scene = given ? given->volume_phase() : 0;
  auto input =
      read_input(options.input, {options.phase.value_or(of_scene), options.phase.has_value()});
  DIAPHANE_TRY(input);
  if (!options.show_table && !(given && given->show_table())) {
    DIAPHANE_TRY(show_only_body(*input));
  }
  return input;
}

/// Applies the options that change the scene.
Result<void> adjust(const Options& options, volume::Volume& input, diaphane::v1::Scene& scene) {
  if (options.bounces) scene.set_bounces(*options.bounces);
  DIAPHANE_TRY(light_by_environment(options, scene));
  DIAPHANE_TRY(add_marked(options, input, scene));
  add_highlight(options, scene);
  return {};
}

/// Interpolates slices, and loads the scan into the engine.
Result<std::shared_ptr<const DeviceVolume>> load(const Options& options, Engine& engine,
                                                 volume::Volume& input) {
  volume::list_found_labels(input);
  volume::widen_dense_parts(input);
  if (!options.stored_slices) {
    volume::refine_slices(
        input, volume::refinement_of(input.header),
        options.threads > 0 ? options.threads : std::thread::hardware_concurrency());
  }
  return engine.load(input);
}

/// Reads the scan of --over and shows it, if there is one.
Result<void> add_second(const Options& options, Engine& engine, const volume::Volume& first,
                        FrameRenderer& renderer, diaphane::v1::Scene& scene) {
  if (options.over.empty()) return {};
  auto second = read_second(options, first);
  DIAPHANE_TRY(second);
  DIAPHANE_TRY(show_second(options, first.header, second->volume.header, scene));
  auto volume = load(options, engine, second->volume);
  DIAPHANE_TRY(volume);
  return renderer.set_second(*volume, second->to_first);
}

Result<Rendered> render(const Options& options) {
  // Makes the engine first: a missing device is found at once, while reading a series takes
  // seconds.
  auto engine = make_engine(options.engine, options.threads);
  DIAPHANE_TRY(engine);
  const auto given = scene_from_file(options);
  DIAPHANE_TRY(given);
  auto input = read_first(options, *given);
  DIAPHANE_TRY(input);
  auto scene =
      *given ? Result<diaphane::v1::Scene>(**given) : scene_of_preset(options.preset, *input);
  DIAPHANE_TRY(scene);
  DIAPHANE_TRY(adjust(options, *input, *scene));
  auto volume = load(options, **engine, *input);
  DIAPHANE_TRY(volume);
  auto renderer = (*engine)->renderer(*volume, options.seed, 0, options.method);
  DIAPHANE_TRY(renderer);
  (*renderer)->prepare_denoising(options.denoise);
  DIAPHANE_TRY(add_second(options, **engine, *input, **renderer, *scene));
  DIAPHANE_TRY((*renderer)->set_scene(*scene, options.canvas));
  auto ending = render_all(**renderer, options);
  DIAPHANE_TRY(ending);
  auto picture = encode(**renderer, *picture_format(options.picture), options.denoise);
  DIAPHANE_TRY(picture);
  return Rendered{std::move(picture->bytes),
                  {(*engine)->info(), (*renderer)->progress(), ending->dropped, ending->reason,
                   (*renderer)->features(), (*renderer)->report(), picture->denoised,
                   std::move(ending->curve)}};
}

int complain(const Error& error, int exit_code) {
  const bool named = error.message.find(error.field) != std::string::npos;
  std::cerr << "diaphane-render: " << (named ? "" : error.field + ": ") << error.message << '\n';
  return exit_code;
}

}  // namespace

int run(const Options& options) {
  if (options.list_presets) {
    const auto listed = list_presets(options);
    return listed ? 0 : complain(listed.error(), exit_code_of(listed.error().code));
  }
  if (options.list_labels) {
    const auto listed = print_labels(options);
    return listed ? 0 : complain(listed.error(), exit_code_of(listed.error().code));
  }
  auto rendered = render(options);
  if (!rendered) return complain(rendered.error(), exit_code_of(rendered.error().code));
  if (auto done = write_file(options.picture, rendered->picture); !done) {
    return complain(done.error(), kExitCannotWrite);
  }
  if (options.report.empty()) return 0;
  const std::string report = report_json(options, rendered->outcome);
  if (options.report == "-") {
    std::cout << report << std::flush;
    return std::cout ? 0 : kExitCannotWrite;
  }
  if (auto done = write_file(options.report, report); !done) {
    return complain(done.error(), kExitCannotWrite);
  }
  return 0;
}

}  // namespace diaphane::render::cli
