#include "renderd/cli/second.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "common/bounded_json.h"
#include "common/try.h"
#include "renderd/cli/input.h"
#include "renderd/cli/scan_readers.h"
#include "renderd/scene/overlay_looks.h"

namespace diaphane::render::cli {
namespace {

/// Reads the matrix from the output of `diaphane-align --json`.
Result<volume::Matrix> read_alignment(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  constexpr std::size_t kLongest = 1 << 16;
  std::string text(kLongest, '\0');
  file.read(text.data(), kLongest);
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  if (!file.is_open() || file.bad()) return fail(ErrorCode::kNotFound, "cannot read " + path);
  const auto json = parse_json(text, {.values = 1000});
  const auto invalid = [&] {
    return fail(ErrorCode::kInvalid, path + " is not an alignment of diaphane-align", "--aligned");
  };
  if (!json || !json->is_object() || !json->contains("matrix") || !(*json)["matrix"].is_array())
    return invalid();
  std::vector<double> numbers;
  for (const auto& number : (*json)["matrix"]) {
    if (!number.is_number()) return invalid();
    numbers.push_back(number.get<double>());
  }
  if (numbers.empty()) return invalid();
  return volume::rigid_motion(numbers);
}

Result<volume::Matrix> alignment_of(const Options& options, const volume::Volume& first,
                                    const volume::Volume& second) {
  if (options.aligned == "auto") return align_scans(first, second);
  if (options.aligned == "identity") return volume::kIdentity;
  if (!options.aligned.empty()) return read_alignment(options.aligned);
  if (volume::share_frame_of_reference(first.header, second.header)) return volume::kIdentity;
  return fail(
      ErrorCode::kUnsupported,
      "the two scans share no frame of reference; use --aligned auto, --aligned identity or "
      "--aligned FILE",
      "--over");
}

}  // namespace

Result<SecondInput> read_second(const Options& options, const volume::Volume& first) {
  SecondInput second;
  auto input = read_input(options.over, {0, false});
  DIAPHANE_TRY(input);
  second.volume = *std::move(input);
  auto to_first = alignment_of(options, first, second.volume);
  DIAPHANE_TRY(to_first);
  second.to_first = *to_first;
  if (!options.show_table && second.volume.header.modality != volume::Modality::kPt)
    DIAPHANE_TRY(show_only_body(second.volume));
  return second;
}

Result<void> show_second(const Options& options, const volume::Header& first,
                         const volume::Header& second, diaphane::v1::Scene& scene) {
  if (!scene.overlay().has_transfer_function() || !options.over_look.empty()) {
    const auto looks = overlay_looks(first, second);
    std::string known;
    const auto found = std::find_if(looks.begin(), looks.end(), [&](const auto& look) {
      known += (known.empty() ? "" : ", ") + look.name();
      return options.over_look.empty() || look.name() == options.over_look;
    });
    if (found == looks.end()) {
      return fail(ErrorCode::kInvalid, "--over-look must be one of " + known, "--over-look");
    }
    *scene.mutable_overlay() = found->overlay();
  }
  if (options.share) scene.mutable_overlay()->set_share(*options.share);
  if (options.split) {
    scene.mutable_overlay()->set_mode(diaphane::v1::Overlay::SPLIT);
    scene.mutable_overlay()->set_split(*options.split);
  }
  return {};
}

}  // namespace diaphane::render::cli
