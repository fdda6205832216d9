#pragma once

#include <array>
#include <optional>
#include <string>

#include "common/result.h"

namespace diaphane::ingest {

/// The steps from voxel to voxel in mm (LPS), as columns, that the text header of a MetaImage gives
/// (TransformMatrix, ElementSpacing); VTK's reader passes over the directions.
/// Nothing where the file says none; kInvalid for numbers that make no sense.
Result<std::optional<std::array<double, 9>>> meta_image_axes(const std::string& path);

/// The same of an NRRD ("space", "space directions"; RAS is turned to LPS). kUnsupported for a
/// left-handed or unknown space, whose rows VTK's reader may or may not turn.
Result<std::optional<std::array<double, 9>>> nrrd_axes(const std::string& path);

/// From the right-anterior frame of NIfTI and of NRRD's RAS to the left-posterior one.
std::array<double, 9> ras_to_lps(std::array<double, 9> axes);

}  // namespace diaphane::ingest
