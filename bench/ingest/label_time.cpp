// diaphane-labels distinguishes body and support in scans and phantoms, and measures the time.
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/config.h"
#include "ingest/body/brain.h"
#include "ingest/body/label_body.h"
#include "ingest/body/structures.h"
#include "ingest/build/read_folder.h"
#include "ingest/build/read_image.h"
#include "tests/support/ingest/phantoms.h"

namespace {

using namespace diaphane;

constexpr int kExitNoInput = 66;   // sysexits.h: EX_NOINPUT
constexpr int kExitNoOutput = 73;  // EX_CANTCREAT

constexpr const char* kUsage =
    "diaphane-labels [--phantoms] [--large] [--write FOLDER] SCAN...\n\n"
    "Labels the body, its support (table, headrest, frame), metal and the parts of the body that\n"
    "ingest finds in each scan: an image file (.nii, .nii.gz, .nrrd, .mha, .mhd) or a folder with "
    "a\n"
    "DICOM series. Prints one line of JSON\n"
    "per scan: {\"name\", \"size\", \"spacing\", \"axes\", \"shares\": [outside, body, support,\n"
    "metal, brain, bone, lungs, airways, vessels], \"build_s\", \"label_s\", \"brain_s\", "
    "\"parts_s\",\n"
    "\"kept\", \"hidden\"}. The last two are for phantoms only.\n\n"
    "  --phantoms       also label all phantoms\n"
    "  --large          also label the large phantoms, which serve to measure times\n"
    "  --write FOLDER   write values (NAME.i16) and encoded labels (NAME.labels), one byte per\n"
    "                   voxel after decoding, to an existing folder\n\n"
    "Exit codes: 0 success, 64 bad command line, 66 cannot read a scan, 73 cannot write.\n";

/// Returns processor time in seconds, which other programs on the machine do not change.
double processor_time() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Returns the voxel axis along each axis of the patient, as "+x" or "-z", for x, y and z.
nlohmann::json axes_of(const std::array<double, 9>& direction) {
  nlohmann::json axes;
  for (std::size_t p = 0; p < 3; ++p) {
    std::size_t most = 0;
    for (std::size_t v = 1; v < 3; ++v) {
      if (std::abs(direction[3 * p + v]) > std::abs(direction[3 * p + most])) most = v;
    }
    axes.push_back(std::string(direction[3 * p + most] < 0 ? "-" : "+") + "xyz"[most]);
  }
  return axes;
}

bool write_raw(const std::filesystem::path& to, const void* bytes, std::size_t n) {
  std::ofstream out(to, std::ios::binary);
  out.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(n));
  return out.flush().good();
}

struct Labelled {
  nlohmann::json line;
  volume::Labels labels;
};

Labelled label(const std::string& name, const volume::Volume& volume) {
  const double began = processor_time();
  Labelled result{{}, ingest::label_body(volume)};
  result.line = {{"name", name},
                 {"size", volume.header.size},
                 {"spacing", volume.header.spacing},
                 {"axes", axes_of(volume.header.direction)},
                 {"label_s", processor_time() - began}};
  const double labelled = processor_time();
  ingest::mark_brain(volume, result.labels);
  result.line["brain_s"] = processor_time() - labelled;
  const double with_brain = processor_time();
  ingest::mark_structures(volume, result.labels);
  result.line["parts_s"] = processor_time() - with_brain;
  std::array<double, static_cast<std::size_t>(volume::kLastLabel) + 1> shares{};
  for (const std::uint8_t one : result.labels.voxels) ++shares[one];
  for (double& share : shares) share /= static_cast<double>(volume.voxels.size());
  result.line["shares"] = shares;
  return result;
}

bool report(const Labelled& labelled, const volume::Volume& volume, const std::string& folder) {
  std::printf("%s\n", labelled.line.dump().c_str());
  std::fflush(stdout);
  if (folder.empty()) return true;
  const std::filesystem::path to =
      std::filesystem::path(folder) / labelled.line["name"].get<std::string>();
  const std::string encoded = volume::encode(labelled.labels);
  const auto with = [&](const char* ending) { return to.string() + ending; };
  return write_raw(with(".i16"), volume.voxels.data(),
                   volume.voxels.size() * sizeof(std::int16_t)) &&
         write_raw(with(".labels"), encoded.data(), encoded.size());
}

int complain(int exit_code, const std::string& text) {
  std::fprintf(stderr, "diaphane-labels: %s\n", text.c_str());
  return exit_code;
}

int label_scans(const std::vector<std::string>& scans, const std::string& folder) {
  for (const std::string& scan : scans) {
    const double began = processor_time();
    const auto volume =
        ingest::is_image_name(scan) ? ingest::read_image(scan) : ingest::read_folder(scan);
    if (!volume) return complain(kExitNoInput, scan + ": " + volume.error().message);
    const double build_s = processor_time() - began;
    const std::string file = std::filesystem::path(scan).filename();
    Labelled labelled = label(file.substr(0, file.find('.')), *volume);
    labelled.line["build_s"] = build_s;
    if (!report(labelled, *volume, folder)) return complain(kExitNoOutput, folder);
  }
  return 0;
}

int label_phantoms(const std::vector<std::string>& names, const std::string& folder) {
  for (const std::string& name : names) {
    const ingest::Phantom phantom = ingest::make_phantom(name);
    Labelled labelled = label(name, phantom.volume);
    const ingest::Agreement found = ingest::agreement(phantom, labelled.labels.voxels);
    labelled.line["kept"] = found.kept;
    labelled.line["hidden"] = found.hidden;
    if (!report(labelled, phantom.volume, folder)) return complain(kExitNoOutput, folder);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> positional(argv + 1, argv + argc);
  std::vector<std::string> scans;
  std::string folder;
  std::vector<std::string> phantoms;
  for (std::size_t i = 0; i < positional.size(); ++i) {
    if (positional[i] == "--help" || positional[i] == "-h") {
      std::fputs(kUsage, stdout);
      return 0;
    }
    if (positional[i] == "--phantoms" || positional[i] == "--large") {
      const auto more =
          positional[i] == "--large" ? ingest::large_phantom_names() : ingest::phantom_names();
      phantoms.insert(phantoms.end(), more.begin(), more.end());
    } else if (positional[i] == "--write" && i + 1 < positional.size()) {
      folder = positional[++i];
    } else if (positional[i].starts_with("--")) {
      return complain(kExitUsage, "unknown option " + positional[i] + " (see --help)");
    } else {
      scans.push_back(positional[i]);
    }
  }
  if (scans.empty() && phantoms.empty()) {
    return complain(kExitUsage, "missing argument: SCAN (see --help)");
  }
  const int failed = label_scans(scans, folder);
  return failed != 0 ? failed : label_phantoms(phantoms, folder);
}
