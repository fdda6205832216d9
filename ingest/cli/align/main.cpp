#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/try.h"
#include "ingest/build/read_scan.h"
#include "ingest/registration/register.h"
#include "volume/volume.h"

namespace {

using namespace diaphane;

constexpr int kExitUsage = 64, kExitData = 65, kExitNoInput = 66, kExitNoOutput = 73;

constexpr const char* kUsage =
    "diaphane-align FIXED MOVING [--json FILE]\n\n"
    "Aligns two scans by a rotation and a shift, so that their values have the most mutual\n"
    "information. Each scan is a stored volume, a folder of DICOM files, or a file in a research\n"
    "format (NIfTI, NRRD, MetaImage). Of a scan with several phases, the first is used.\n\n"
    "Prints the matrix from positions in MOVING to positions in FIXED (mm, LPS), the overlap of "
    "both\n"
    "scans, and the residual: how far an alignment from one half of the data puts a place from "
    "where\n"
    "the alignment from all of it puts it (root mean square). It contains no error that both "
    "halves\n"
    "share, such as organs that have moved. Not for diagnosis.\n\n"
    "  --json FILE      also write the result to FILE, for diaphane-render --aligned; - is "
    "standard\n"
    "                   output, and then nothing else is printed\n\n"
    "Exit codes: 0 success, 64 bad command line, 65 the scans cannot be aligned, 66 cannot read a\n"
    "scan, 73 cannot write FILE.\n";

int complain(int exit_code, const std::string& text) {
  std::fprintf(stderr, "diaphane-align: %s\n", text.c_str());
  return exit_code;
}

struct Options {
  std::string fixed, moving, json;
};

/// Returns what is wrong with the command line, or an empty string.
std::string read_options(const std::vector<std::string>& words, Options& options) {
  std::vector<std::string> scans;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "--json") {
      if (++i == words.size() || words[i].empty()) return "--json: missing value (see --help)";
      options.json = words[i];
    } else if (words[i].starts_with("--")) {
      return "unknown option " + words[i] + " (see --help)";
    } else {
      scans.push_back(words[i]);
    }
  }
  if (scans.size() != 2) return "give one FIXED and one MOVING scan (see --help)";
  options.fixed = scans[0];
  options.moving = scans[1];
  return {};
}

Result<ingest::CoarseScan> read_coarse(const std::string& path) {
  auto scan = ingest::read_scan(path);
  DIAPHANE_TRY(scan);
  DIAPHANE_TRY(volume::keep_phase(*scan, 0));
  return ingest::reduced(*scan);
}

nlohmann::ordered_json json_of(const ingest::RigidAlignment& found) {
  return {{"matrix", found.to_fixed},
          {"residual_mm", found.residual_mm},
          {"overlap", found.overlap},
          {"information_before", found.information_before},
          {"information", found.information}};
}

void print(const ingest::RigidAlignment& found) {
  for (std::size_t row = 0; row < 4; ++row) {
    for (std::size_t column = 0; column < 4; ++column) {
      std::printf("%13.6f", found.to_fixed[4 * row + column]);
    }
    std::printf("\n");
  }
  std::printf("residual            %.2f mm\noverlap             %.0f %%\n", found.residual_mm,
              100 * found.overlap);
  std::printf("mutual information  %.3f nats (%.3f before)\n", found.information,
              found.information_before);
}

bool write(const std::string& path, const ingest::RigidAlignment& found) {
  const std::string text = json_of(found).dump(2) + "\n";
  if (path == "-") {
    std::cout << text << std::flush;
    return static_cast<bool>(std::cout);
  }
  std::ofstream file(path, std::ios::binary);
  file << text << std::flush;
  return static_cast<bool>(file);
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() == 1 && (words[0] == "--help" || words[0] == "-h")) {
    std::fputs(kUsage, stdout);
    return 0;
  }
  Options options;
  if (const std::string wrong = read_options(words, options); !wrong.empty())
    return complain(kExitUsage, wrong);
  const auto fixed = read_coarse(options.fixed);
  if (!fixed) return complain(kExitNoInput, options.fixed + ": " + fixed.error().message);
  const auto moving = read_coarse(options.moving);
  if (!moving) return complain(kExitNoInput, options.moving + ": " + moving.error().message);
  const auto found = ingest::register_rigid(*fixed, *moving);
  if (!found) return complain(kExitData, found.error().message);
  if (options.json != "-") print(*found);
  if (!options.json.empty() && !write(options.json, *found))
    return complain(kExitNoOutput, "cannot write " + options.json);
  return 0;
}
