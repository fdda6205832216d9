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

constexpr int kExitData = 65;      // sysexits.h: EX_DATAERR, nothing in it is a series
constexpr int kExitNoInput = 66;   // EX_NOINPUT, the folder cannot be read
constexpr int kExitNoOutput = 73;  // EX_CANTCREAT, the volume cannot be written

constexpr const char* kUsage =
    "diaphane-scan FOLDER [--json] [--build VOLUME] [--most-voxels N]\n\n"
    "Lists the DICOM series under FOLDER: whether each can become a volume, or why not; its kind, "
    "slices,\n"
    "size, spacing and direction, and what would be mended. Names of patients are not shown.\n\n"
    "  --json           for programs\n"
    "  --build VOLUME   also makes the volume of the suitable series with the most slices, in a "
    "new "
    "folder\n"
    "  --most-voxels N  the quota of a volume\n\n"
    "Exit: 0 listed, 64 bad command line, 65 no series in it or none to build, 66 the folder "
    "cannot "
    "be read,\n73 the volume cannot be written.\n";

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
  const std::vector<std::string> words(argv + 1, argv + argc);
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "--help" || word == "-h") {
      std::fputs(kUsage, stdout);
      return 0;
    }
    if (word == "--json") {
      json = true;
    } else if (word == "--build") {
      if (i + 1 == words.size()) return complain(kExitUsage, "--build where? (try --help)");
      volume = words[++i];
    } else if (word == "--most-voxels") {
      const std::string text = i + 1 == words.size() ? "" : words[++i];
      const auto [stop, error] =
          std::from_chars(text.data(), text.data() + text.size(), limits.most_voxels);
      if (error != std::errc() || stop != text.data() + text.size()) {
        return complain(kExitUsage, "--most-voxels how many? (try --help)");
      }
    } else if (word.starts_with("--")) {
      return complain(kExitUsage, "unknown option " + word + " (try --help)");
    } else if (!folder.empty()) {
      return complain(kExitUsage, "one folder at a time");
    } else {
      folder = word;
    }
  }
  if (folder.empty()) return complain(kExitUsage, "which folder? (try --help)");
  return run(folder, json, volume, limits);
}
