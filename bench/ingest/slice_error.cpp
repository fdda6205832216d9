// diaphane-slice-error measures how well slices are interpolated: it leaves slices out of scans,
// interpolates them, and compares them with the originals.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "common/config.h"
#include "ingest/build/read_scan.h"
#include "volume/slice_interpolation.h"

namespace {

using namespace diaphane;

constexpr int kExitNoInput = 66;    // sysexits.h: EX_NOINPUT
constexpr std::uint32_t kStep = 3;  // every third slice is kept

constexpr const char* kUsage =
    "diaphane-slice-error SCAN...\n\n"
    "Keeps every third slice of each scan, interpolates the others, and compares them with the\n"
    "true ones. A scan is an image file (.nii, .nii.gz, .nrrd, .mha, .mhd), a folder with a DICOM\n"
    "series or a directory of the volume store. Prints one line of JSON per scan: {\"name\",\n"
    "\"size\", \"spacing\", \"linear\", \"cubic\", \"along_motion\", \"seconds\", \"threads\"}.\n"
    "\"linear\", \"cubic\" and \"along_motion\" are root mean square errors in the scan's "
    "units.\n\n"
    "Exit codes: 0 success, 64 bad command line, 66 cannot read a scan.\n";

volume::Volume every_third(const volume::Volume& all) {
  volume::Volume kept;
  kept.header = all.header;
  kept.header.size[2] = (all.header.size[2] - 1) / kStep + 1;
  kept.header.spacing[2] *= kStep;
  const std::size_t pixels = std::size_t{all.header.size[0]} * all.header.size[1];
  for (std::uint32_t z = 0; z < kept.header.size[2]; ++z) {
    const auto from = all.voxels.begin() + static_cast<std::ptrdiff_t>(pixels * kStep * z);
    kept.voxels.insert(kept.voxels.end(), from, from + static_cast<std::ptrdiff_t>(pixels));
  }
  return kept;
}

/// Evaluates Catmull and Rom's spline through four values between the two in the middle.
double cubic(const std::array<double, 4>& v, double t) {
  return v[1] +
         0.5 * t *
             (v[2] - v[0] +
              t * (2 * v[0] - 5 * v[1] + 4 * v[2] - v[3] + t * (3 * (v[1] - v[2]) + v[3] - v[0])));
}

nlohmann::json compare(const volume::Volume& all) {
  const volume::Volume kept = every_third(all);
  volume::Volume refined = kept;
  const unsigned threads = std::thread::hardware_concurrency();
  const auto began = std::chrono::steady_clock::now();
  volume::refine_slices(refined, kStep, threads);
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - began;

  const std::size_t pixels = std::size_t{all.header.size[0]} * all.header.size[1];
  const std::int64_t last = kept.header.size[2] - 1;
  const auto of_kept = [&](std::int64_t z, std::size_t i) -> double {
    return kept.voxels[static_cast<std::size_t>(std::clamp<std::int64_t>(z, 0, last)) * pixels + i];
  };
  double linear = 0, spline = 0, along = 0;
  std::uint64_t count = 0;
  for (std::uint32_t z = 0; z + 1 < kept.header.size[2] * kStep - (kStep - 1); ++z) {
    if (z % kStep == 0) continue;
    const double t = static_cast<double>(z % kStep) / kStep;
    for (std::size_t i = 0; i < pixels; ++i) {
      const std::int64_t at = z / kStep;
      const std::array v{of_kept(at - 1, i), of_kept(at, i), of_kept(at + 1, i),
                         of_kept(at + 2, i)};
      const double truth = all.voxels[z * pixels + i];
      const auto square = [&](double value) { return (value - truth) * (value - truth); };
      linear += square(v[1] + t * (v[2] - v[1]));
      spline += square(cubic(v, t));
      // The refined slices begin a third of a thick slice before the centre of the first one.
      along += square(refined.voxels[(z + kStep / 2) * pixels + i]);
      ++count;
    }
  }
  const auto rmse = [&](double sum) { return std::sqrt(sum / static_cast<double>(count)); };
  return {{"size", all.header.size}, {"spacing", all.header.spacing}, {"linear", rmse(linear)},
          {"cubic", rmse(spline)},   {"along_motion", rmse(along)},   {"seconds", time.count()},
          {"threads", threads}};
}

int complain(int exit_code, const std::string& text) {
  std::fprintf(stderr, "diaphane-slice-error: %s\n", text.c_str());
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> scans(argv + 1, argv + argc);
  if (scans.empty()) return complain(kExitUsage, "missing argument: SCAN (see --help)");
  for (const std::string& scan : scans) {
    if (scan == "--help" || scan == "-h") {
      std::fputs(kUsage, stdout);
      return 0;
    }
    if (scan.starts_with("--")) {
      return complain(kExitUsage, "unknown option " + scan + " (see --help)");
    }
    const auto volume = ingest::read_scan(scan);
    if (!volume) return complain(kExitNoInput, scan + ": " + volume.error().message);
    nlohmann::json line = compare(*volume);
    line["name"] = std::filesystem::path(scan).filename();
    std::printf("%s\n", line.dump().c_str());
    std::fflush(stdout);
  }
  return 0;
}
