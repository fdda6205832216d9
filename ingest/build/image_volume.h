#pragma once

#include <vtkImageData.h>
#include <vtkSmartPointer.h>

#include <array>
#include <string>
#include <vector>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// An image of int16 over the voxels of `volume`, with its spacing and direction. It does not own
/// them.
vtkSmartPointer<vtkImageData> borrow(volume::Volume& volume);

/// Takes the scalars of `image` (one component) as a measured volume with axes given in the
/// patient's space (LPS): columns of `axes` are the steps in mm from voxel to voxel. Left-handed
/// axes are turned. kUnsupported: other scalars or sheared axes; see read_image for how values
/// become int16.
Result<volume::Volume> to_volume(vtkImageData* image, const std::array<double, 9>& axes,
                                 double slope, double intercept, std::vector<std::string> repairs);

}  // namespace diaphane::ingest
