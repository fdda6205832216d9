#include "renderd/cli/command.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>

#include "renderd/cli/input.h"
#include "renderd/cli/picture_file.h"
#include "renderd/cli/report.h"
#include "renderd/scene/presets.h"

namespace diaphane::render::cli {
namespace {

/// A scene file larger than this is none.
constexpr std::streamsize kLargestScene = 8 << 20;

Result<std::string> read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text;
  if (file) {
    text.resize(static_cast<std::size_t>(kLargestScene) + 1);
    file.read(text.data(), std::ssize(text));
    text.resize(static_cast<std::size_t>(file.gcount()));
  }
  if (file.bad() || !file.is_open()) return fail(ErrorCode::kNotFound, "cannot read " + path);
  if (std::ssize(text) > kLargestScene) {
    return fail(ErrorCode::kInvalid, path + " is too large for a scene file");
  }
  return text;
}

Result<diaphane::v1::Scene> scene_of(const Options& options, const volume::Header& header) {
  if (!options.preset.empty()) {
    auto preset = preset_for(header, options.preset);
    // Wrong words are no missing file.
    if (!preset) return fail(ErrorCode::kInvalid, preset.error().message, "--preset");
    return preset->scene();
  }
  auto text = read_text(options.scene_file);
  if (!text) return tl::make_unexpected(text.error());
  return scene_from_json(*text);
}

/// In pieces of a size that depends on nothing measured, since it can decide how sums are rounded.
constexpr std::uint32_t kPiece = 32;

/// Shows progress where a person looks on.
Result<std::uint64_t> render_all(FrameRenderer& renderer, const Options& options) {
  const bool show = !options.quiet && ::isatty(STDERR_FILENO) == 1;
  std::uint64_t dropped = 0;
  std::uint32_t done = 0;
  while (done < options.samples) {
    auto batch = renderer.render(std::min(kPiece, options.samples - done), [] { return false; });
    if (!batch) return tl::make_unexpected(batch.error());
    dropped += batch->dropped_samples;
    done += batch->samples;
    if (show) {
      const Progress progress = renderer.progress();
      std::fprintf(stderr, "\r%u of %u samples, %.1f s, error %.4f ", done, options.samples,
                   progress.seconds, progress.error);
    }
  }
  if (show) std::fputc('\n', stderr);
  return dropped;
}

Result<std::string> encode(FrameRenderer& renderer, PictureFormat format) {
  if (format == PictureFormat::kExr) {
    PictureRgbF picture;
    if (auto done = renderer.radiance(picture); !done) return tl::make_unexpected(done.error());
    return encode_exr(picture);
  }
  PictureRgb8 picture;
  if (auto done = renderer.display(picture); !done) return tl::make_unexpected(done.error());
  if (format == PictureFormat::kPpm) return encode_ppm(picture);
  return encode_png(picture);
}

struct Rendered {
  std::string picture;
  Outcome outcome;
};

Result<Rendered> render(const Options& options) {
  // The engine before the input: that there is no device is known at once, a series takes seconds
  // to read.
  auto engine = make_engine(options.engine, options.threads);
  if (!engine) return tl::make_unexpected(engine.error());
  auto input = read_input(options.input);
  if (!input) return tl::make_unexpected(input.error());
  auto scene = scene_of(options, input->header);
  if (!scene) return tl::make_unexpected(scene.error());
  auto volume = (*engine)->load(*input);
  if (!volume) return tl::make_unexpected(volume.error());
  auto renderer = (*engine)->renderer(*volume, options.seed, 0, options.method);
  if (!renderer) return tl::make_unexpected(renderer.error());
  if (auto set = (*renderer)->set_scene(*scene, options.canvas); !set) {
    return tl::make_unexpected(set.error());
  }
  auto dropped = render_all(**renderer, options);
  if (!dropped) return tl::make_unexpected(dropped.error());
  auto picture = encode(**renderer, *picture_format(options.picture));
  if (!picture) return tl::make_unexpected(picture.error());
  return Rendered{std::move(*picture),
                  {(*engine)->info(), (*renderer)->progress(), *dropped, (*renderer)->features()}};
}

int complain(const Error& error, int exit_code) {
  const bool named = error.message.find(error.field) != std::string::npos;
  std::cerr << "diaphane-render: " << (named ? "" : error.field + ": ") << error.message << '\n';
  return exit_code;
}

}  // namespace

int run(const Options& options) {
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
