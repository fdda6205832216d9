#pragma once

#include <vtkImageData.h>
#include <vtkSmartPointer.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// The repair note of a file without axes. The page knows this sentence (scan/corrections.ts).
inline constexpr const char* kNoAxes = "the file does not specify its orientation in the patient";

/// Returns an int16 image that borrows the voxels of the phase `index` among those that `volume`
/// holds, with its spacing and direction.
vtkSmartPointer<vtkImageData> borrow(volume::Volume& volume, std::uint32_t index = 0);

/// Converts the scalars of `image` (one component) to a measured volume, to int16 as in read_image.
/// The columns of `axes` are the steps from voxel to voxel in mm in the patient's space (LPS).
/// Left-handed axes are reversed. `origin` is the centre of the first voxel, if known. An image
/// with `phases` has those of all phases one after the other along z. Returns kUnsupported for
/// other scalars or sheared axes.
Result<volume::Volume> to_volume(vtkImageData* image, const std::array<double, 9>& axes,
                                 double slope, double intercept, std::vector<std::string> repairs,
                                 std::optional<std::array<double, 3>> origin = std::nullopt,
                                 std::vector<volume::Phase> phases = {});

}  // namespace diaphane::ingest
