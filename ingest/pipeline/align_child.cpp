#include "ingest/pipeline/align_child.h"

#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <vector>

#include "common/bounded_json.h"
#include "common/sandbox/supervisor.h"
#include "ingest/pipeline/child.h"
#include "ingest/pipeline/report.h"
#include "volume/header.h"

namespace diaphane::ingest {
namespace {

constexpr const char* kNeedsMore = "This alignment needs more memory than allowed.";

enum class Got { kAll, kDamaged, kDiskFails };

Got read_input(char* data, std::size_t bytes) {
  while (bytes > 0) {
    const ssize_t got = read(kChildInput, data, bytes);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return Got::kDiskFails;
    if (got == 0) return Got::kDamaged;
    data += got;
    bytes -= static_cast<std::size_t>(got);
  }
  return Got::kAll;
}

/// Reads the next scan slice by slice, so that its voxels need not fit in memory.
Got read_coarse(const volume::Header& header, CoarseScan& scan) {
  ScanReducer reducer(header);
  std::vector<std::int16_t> slice(std::size_t{header.size[0]} * header.size[1]);
  for (std::uint32_t z = 0; z < header.size[2]; ++z) {
    const Got got =
        read_input(reinterpret_cast<char*>(slice.data()), slice.size() * sizeof(std::int16_t));
    if (got != Got::kAll) return got;
    reducer.add_slice(slice);
  }
  scan = reducer.finish();
  return Got::kAll;
}

/// Aligns the scans. Returns 0 and fills `verdict`, or returns an exit code.
int align(const std::string& fixed_text, const std::string& moving_text, Verdict& verdict) {
  auto fixed = volume::from_json(fixed_text), moving = volume::from_json(moving_text);
  if (!fixed || !moving) {
    verdict = refused("internal", "The scans could not be aligned.");
    return 0;
  }
  CoarseScan one, other;
  Got got = read_coarse(*fixed, one);
  if (got == Got::kAll) got = read_coarse(*moving, other);
  if (got == Got::kDiskFails) return kChildDiskFails;
  if (got == Got::kDamaged) {
    verdict = refused("damaged", "A stored scan cannot be read.");
    return 0;
  }
  const auto found = register_rigid(one, other);
  if (!found) {
    verdict = refused(found.error().field, "The scans could not be aligned.");
    return 0;
  }
  if (const int exit_code = write_output(to_text(*found))) return exit_code;
  return succeed(*std::move(fixed), verdict);
}

}  // namespace

int run_align_child_main(const std::string& fixed, const std::string& moving,
                         const SandboxLimits& sandbox) {
  return run_in_sandbox(sandbox, kNeedsMore,
                        [&](Verdict& verdict) { return align(fixed, moving, verdict); });
}

std::string to_text(const RigidAlignment& found) {
  return nlohmann::json{{"matrix", found.to_fixed},
                        {"residual", found.residual_mm},
                        {"overlap", found.overlap},
                        {"before", found.information_before},
                        {"after", found.information}}
      .dump();
}

std::optional<RigidAlignment> alignment_of(const std::string& text) {
  if (text.size() > kLongestAlignment) return std::nullopt;
  const auto json = parse_json(text, {.values = 100});
  if (!json || !json->is_object() || !json->contains("matrix") || !(*json)["matrix"].is_array())
    return std::nullopt;
  std::vector<double> matrix;
  for (const auto& number : (*json)["matrix"]) {
    if (!number.is_number()) return std::nullopt;
    matrix.push_back(number.get<double>());
  }
  RigidAlignment found;
  for (const auto& [name, out] : {std::pair{"residual", &found.residual_mm},
                                  {"overlap", &found.overlap},
                                  {"before", &found.information_before},
                                  {"after", &found.information}}) {
    if (!json->contains(name) || !(*json)[name].is_number()) return std::nullopt;
    *out = (*json)[name].get<double>();
    if (!std::isfinite(*out)) return std::nullopt;
  }
  const auto rigid = volume::rigid_motion(matrix);
  if (matrix.empty() || !rigid || found.residual_mm < 0 || found.overlap < 0 || found.overlap > 1)
    return std::nullopt;
  found.to_fixed = *rigid;
  return found;
}

}  // namespace diaphane::ingest
