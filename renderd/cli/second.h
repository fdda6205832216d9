#pragma once

#include "api/proto/scene.pb.h"
#include "common/result.h"
#include "renderd/cli/options.h"
#include "volume/alignment.h"
#include "volume/volume.h"

namespace diaphane::render::cli {

/// The scan of --over, and how it lies.
struct SecondInput {
  volume::Volume volume;
  volume::Matrix to_first = volume::kIdentity;
};

/// Reads the scan of --over and aligns it as --aligned says. Fails with kUnsupported if the scans
/// share no frame of reference and no alignment is given.
Result<SecondInput> read_second(const Options& options, const volume::Volume& first);

/// Gives the scene a built-in look of the second scan (--over-look) if it has none, and applies
/// --share and --split. Fails with kInvalid for an unknown look.
Result<void> show_second(const Options& options, const volume::Header& first,
                         const volume::Header& second, diaphane::v1::Scene& scene);

}  // namespace diaphane::render::cli
