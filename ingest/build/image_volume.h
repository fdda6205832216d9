#pragma once

#include <vtkImageData.h>
#include <vtkSmartPointer.h>

#include <cstddef>
#include <span>

#include "common/result.h"
#include "ingest/build/image_header.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// The repair note of a file without axes. The page knows this sentence (scan/corrections.ts).
inline constexpr const char* kNoAxes = "the file does not specify its orientation in the patient";

/// Returns an int16 image that borrows the voxels of the phase `index` among those that `volume`
/// holds, with its spacing and direction.
vtkSmartPointer<vtkImageData> borrow(volume::Volume& volume, std::uint32_t index = 0);

/// Converts voxels to a measured volume, to int16 as in read_image. Left-handed axes are reversed.
/// Returns kUnsupported for sheared axes. Precondition: `voxels` has header.voxels_bytes() bytes.
Result<volume::Volume> to_volume(std::span<const std::byte> voxels, const ImageHeader& header);

}  // namespace diaphane::ingest
