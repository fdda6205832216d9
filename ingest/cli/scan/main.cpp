#include <cstdio>
#include <string>
#include <vector>

#include "common/config.h"
#include "ingest/cli/scan/report.h"
#include "ingest/dicom/scan.h"

namespace {

using namespace diaphane;

constexpr int kExitData = 65;     // sysexits.h: EX_DATAERR, nothing in it is a series
constexpr int kExitNoInput = 66;  // EX_NOINPUT, the folder cannot be read

constexpr const char* kUsage =
    "diaphane-scan FOLDER [--json]\n\n"
    "Lists the DICOM series under FOLDER: whether each can become a volume, or why not; its kind, "
    "slices,\n"
    "size, spacing and direction, and what would be mended. Names of patients are not shown.\n\n"
    "  --json   for programs\n\n"
    "Exit: 0 listed, 64 bad command line, 65 no series in it, 66 the folder cannot be read.\n";

int complain(int exit_code, const std::string& text) {
  std::fprintf(stderr, "diaphane-scan: %s\n", text.c_str());
  return exit_code;
}

int run(const std::string& folder, bool json) {
  const dicom::ScanLimits limits;
  auto source = dicom::FolderSource::open(folder, limits.file.file_bytes);
  if (!source) return complain(kExitNoInput, folder + ": " + source.error().message);
  auto scan = dicom::scan(*source, limits);
  if (!scan) return complain(kExitNoInput, folder + ": " + scan.error().message);
  std::fputs((json ? scan::as_json(*scan) : scan::as_text(*scan)).c_str(), stdout);
  if (!scan->series.empty()) return 0;
  return complain(kExitData, folder + ": " + dicom::choose(*scan).text);
}

}  // namespace

int main(int argc, char** argv) {
  std::string folder;
  bool json = false;
  for (const std::string& word : std::vector<std::string>(argv + 1, argv + argc)) {
    if (word == "--help" || word == "-h") {
      std::fputs(kUsage, stdout);
      return 0;
    }
    if (word == "--json") {
      json = true;
    } else if (word.starts_with("--")) {
      return complain(kExitUsage, "unknown option " + word + " (try --help)");
    } else if (!folder.empty()) {
      return complain(kExitUsage, "one folder at a time");
    } else {
      folder = word;
    }
  }
  if (folder.empty()) return complain(kExitUsage, "which folder? (try --help)");
  return run(folder, json);
}
