#include <charconv>
#include <cstdio>
#include <string>
#include <vector>

#include "common/config.h"
#include "ingest/build/build_volume.h"
#include "ingest/cli/scan/report.h"
#include "ingest/dicom/scan.h"
#include "volume/volume.h"

namespace {

using namespace diaphane;

constexpr int kExitData = 65;      // sysexits.h: EX_DATAERR, no file belongs to a series
constexpr int kExitNoInput = 66;   // EX_NOINPUT, the folder is unreadable
constexpr int kExitNoOutput = 73;  // EX_CANTCREAT, the volume cannot be written

constexpr const char* kUsage =
    "diaphane-scan FOLDER [--json] [--build VOLUME] [--most-voxels N]\n\n"
    "Lists the DICOM series under FOLDER. For each series, it shows the modality, the number of\n"
    "slices, the size, the spacing and the orientation, and which corrections would be made, or "
    "why\n"
    "the series cannot become a volume. It does not show patient names.\n\n"
    "  --json           print JSON\n"
    "  --build VOLUME   also build a volume from the suitable series with the most slices and "
    "write\n"
    "                   it to VOLUME, which must be a new folder\n"
    "  --most-voxels N  maximum number of voxels of a volume\n\n"
    "Exit codes: 0 success, 64 bad command line, 65 no DICOM series found or none that can be "
    "built,\n"
    "66 cannot read the folder, 73 cannot write the volume.\n";

int complain(int exit_code, const std::string& text) {
  std::fprintf(stderr, "diaphane-scan: %s\n", text.c_str());
  return exit_code;
}

int build(dicom::FileSource& source, const dicom::Scan& scan, const dicom::ScanLimits& limits,
          const std::string& to) {
  const dicom::Choice choice = dicom::choose_largest(scan);
  if (!choice.suitable) return complain(kExitData, choice.text);
  auto built = ingest::build_volume(source, scan, choice, limits.file);
  if (!built) return complain(kExitData, built.error().message);
  auto written = volume::write(built->volume, to);
  return written ? 0 : complain(kExitNoOutput, to + ": " + written.error().message);
}

int run(const std::string& folder, bool json, const std::string& volume,
        const dicom::ScanLimits& limits) {
  auto source = dicom::FolderSource::open(folder, limits.file.file_bytes);
  if (!source) return complain(kExitNoInput, folder + ": " + source.error().message);
  auto scan = dicom::scan(*source, limits);
  if (!scan) return complain(kExitNoInput, folder + ": " + scan.error().message);
  std::fputs((json ? scan::as_json(*scan) : scan::as_text(*scan)).c_str(), stdout);
  if (!scan->series.empty()) return volume.empty() ? 0 : build(*source, *scan, limits, volume);
  return complain(kExitData, folder + ": " + dicom::choose(*scan).text);
}

}  // namespace

int main(int argc, char** argv) {
  std::string folder, volume;
  bool json = false;
  dicom::ScanLimits limits;
  const std::vector<std::string> positional(argv + 1, argv + argc);
  for (std::size_t i = 0; i < positional.size(); ++i) {
    const std::string& word = positional[i];
    if (word == "--help" || word == "-h") {
      std::fputs(kUsage, stdout);
      return 0;
    }
    if (word == "--json") {
      json = true;
    } else if (word == "--build") {
      if (i + 1 == positional.size())
        return complain(kExitUsage, "--build: missing argument VOLUME (see --help)");
      volume = positional[++i];
    } else if (word == "--most-voxels") {
      const std::string text = i + 1 == positional.size() ? "" : positional[++i];
      const auto [stop, error] =
          std::from_chars(text.data(), text.data() + text.size(), limits.most_voxels);
      if (error != std::errc() || stop != text.data() + text.size()) {
        return complain(kExitUsage, "--most-voxels: must be a whole number (see --help)");
      }
    } else if (word.starts_with("--")) {
      return complain(kExitUsage, "unknown option " + word + " (see --help)");
    } else if (!folder.empty()) {
      return complain(kExitUsage, "only one FOLDER is allowed (see --help)");
    } else {
      folder = word;
    }
  }
  if (folder.empty()) return complain(kExitUsage, "missing argument: FOLDER (see --help)");
  return run(folder, json, volume, limits);
}
