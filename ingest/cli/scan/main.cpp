#include <array>
#include <charconv>
#include <cstdio>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "common/config.h"
#include "common/try.h"
#include "ingest/build/build_volume.h"
#include "ingest/build/keep_phases.h"
#include "ingest/build/read_image.h"
#include "ingest/cli/scan/report.h"
#include "ingest/dicom/scan.h"
#include "volume/volume.h"

namespace {

using namespace diaphane;

constexpr int kExitData = 65;      // sysexits.h: EX_DATAERR, no file belongs to a series
constexpr int kExitNoInput = 66;   // EX_NOINPUT, the folder is unreadable
constexpr int kExitNoOutput = 73;  // EX_CANTCREAT, the volume cannot be written

constexpr const char* kUsage =
    "diaphane-scan FOLDER|FILE [--json] [--build VOLUME [--phases LIST|--every N]]\n"
    "              [--most-voxels N]\n\n"
    "Lists the DICOM series under FOLDER, or the scan in FILE, a file in a research format "
    "(NIfTI,\n"
    "NRRD or MetaImage). For each series, it shows the modality, the number of slices, the size,\n"
    "the spacing, the orientation and the phases, and which corrections would be made, or why the\n"
    "series cannot become a volume. It does not show patient names.\n\n"
    "  --json           print JSON\n"
    "  --build VOLUME   also build a volume from the suitable series with the most slices and "
    "write\n"
    "                   it to VOLUME, which must be a new folder\n"
    "  --phases LIST    with --build, keep only these phases, for example 0,5,10; the first is 0\n"
    "  --every N        with --build, keep only every Nth phase, beginning with the first\n"
    "  --most-voxels N  maximum number of voxels of a volume\n\n"
    "Exit codes: 0 success, 64 bad command line, 65 no DICOM series found or none that can be "
    "built,\n"
    "66 cannot read FOLDER or FILE, 73 cannot write the volume.\n";

int complain(int exit_code, const std::string& text) {
  std::fprintf(stderr, "diaphane-scan: %s\n", text.c_str());
  return exit_code;
}

/// What the command line says.
struct Options {
  std::string input;   ///< a folder, or a file in a research format
  std::string volume;  ///< where to build a volume, or empty
  ingest::PhaseChoice phases;
  bool json = false;
  dicom::ScanLimits limits;
};

int store(volume::Volume& volume, const Options& options) {
  const auto kept = ingest::chosen_phases(options.phases, volume.header.phase_count());
  if (!kept) return complain(kExitData, options.input + ": " + kept.error().message);
  ingest::keep_phases(volume, *kept);
  auto written = volume::write(volume, options.volume);
  if (written) return 0;
  return complain(kExitNoOutput, options.volume + ": " + written.error().message);
}

int build(dicom::FileSource& source, const dicom::Scan& scan, const Options& options) {
  const dicom::Choice choice = dicom::choose_largest(scan);
  if (!choice.suitable) return complain(kExitData, choice.text);
  auto built = ingest::build_volume(source, scan, choice, options.limits.file);
  if (!built) return complain(kExitData, built.error().message);
  return store(built->volume, options);
}

/// Describes a file in a research format like a series of one file.
dicom::Scan described(const volume::Header& header) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  dicom::Series series;
  series.slices.resize(1);
  dicom::Assessment& a = series.assessment;
  a.suitable = true;
  a.repairs = header.repairs;
  a.order = {0};
  a.phases = header.phases;
  a.size = header.size;
  a.spacing = header.spacing;
  a.direction = header.direction;
  a.origin = header.origin.value_or(std::array{kUnknown, kUnknown, kUnknown});
  a.modality = header.modality;
  dicom::Scan scan;
  scan.files = 1;
  scan.series.push_back(std::move(series));
  return scan;
}

int run_image(const Options& options) {
  auto volume = ingest::read_image(options.input);
  if (!volume) {
    const bool missing = volume.error().code == ErrorCode::kNotFound;
    return complain(missing ? kExitNoInput : kExitData,
                    options.input + ": " + volume.error().message);
  }
  if (volume->header.total_voxel_count() > options.limits.most_voxels)
    return complain(kExitData, options.input + ": the image is too large");
  const dicom::Scan scan = described(volume->header);
  std::fputs((options.json ? scan::as_json(scan) : scan::as_text(scan)).c_str(), stdout);
  return options.volume.empty() ? 0 : store(*volume, options);
}

int run(const Options& options) {
  const std::string& folder = options.input;
  if (ingest::is_image_name(folder)) return run_image(options);
  auto source = dicom::FolderSource::open(folder, options.limits.file.file_bytes);
  if (!source) return complain(kExitNoInput, folder + ": " + source.error().message);
  auto scan = dicom::scan(*source, options.limits);
  if (!scan) return complain(kExitNoInput, folder + ": " + scan.error().message);
  std::fputs((options.json ? scan::as_json(*scan) : scan::as_text(*scan)).c_str(), stdout);
  if (!scan->series.empty()) return options.volume.empty() ? 0 : build(*source, *scan, options);
  return complain(kExitData, folder + ": " + dicom::choose(*scan).text);
}

bool is_with_value(const std::string& word) {
  return word == "--build" || word == "--most-voxels" || word == "--phases" || word == "--every";
}

/// Returns the options, or an error with a message about the command line.
Result<Options> parse(const std::vector<std::string>& words) {
  Options options;
  std::string phases, every, most;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "--json") {
      options.json = true;
    } else if (is_with_value(word)) {
      if (i + 1 == words.size() || words[i + 1].empty())
        return fail(ErrorCode::kInvalid, word + ": missing argument");
      (word == "--build"    ? options.volume
       : word == "--phases" ? phases
       : word == "--every"  ? every
                            : most) = words[i + 1];
      ++i;
    } else if (word.starts_with("--")) {
      return fail(ErrorCode::kInvalid, "unknown option " + word);
    } else if (!options.input.empty()) {
      return fail(ErrorCode::kInvalid, "only one FOLDER or FILE is allowed");
    } else {
      options.input = word;
    }
  }
  if (options.input.empty()) return fail(ErrorCode::kInvalid, "missing argument: FOLDER or FILE");
  const char* end = most.data() + most.size();
  const auto [stop, error] = std::from_chars(most.data(), end, options.limits.most_voxels);
  if (!most.empty() && (error != std::errc() || stop != end))
    return fail(ErrorCode::kInvalid, "--most-voxels: must be a whole number");
  const auto choice = ingest::parse_phases(phases, every);
  DIAPHANE_TRY(choice);
  options.phases = *choice;
  if (!options.phases.is_all() && options.volume.empty())
    return fail(ErrorCode::kInvalid, "--phases and --every require --build");
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  for (const std::string& word : words) {
    if (word == "--help" || word == "-h") {
      std::fputs(kUsage, stdout);
      return 0;
    }
  }
  const auto options = parse(words);
  if (!options) return complain(kExitUsage, options.error().message + " (see --help)");
  return run(*options);
}
