#include "ingest/build/resample.h"

#include <vtkImageData.h>
#include <vtkImageReslice.h>
#include <vtkImageStencilData.h>
#include <vtkNew.h>

#include <algorithm>
#include <cmath>

#include "ingest/build/image_volume.h"

namespace diaphane::ingest {
namespace {

bool is_integer(double value) { return std::abs(value - std::round(value)) < 1e-6; }

/// Returns the number of output pixels that lie on the slice, according to the filter.
std::uint64_t covered(vtkImageStencilData* stencil, int width, int height) {
  std::uint64_t count = 0;
  for (int y = 0; y < height; ++y) {
    int from = 0, to = 0, next = 0;
    while (stencil->GetNextExtent(from, to, 0, width - 1, y, 0, next) != 0) {
      count += static_cast<std::uint64_t>(to - from) + 1;
    }
  }
  return count;
}

}  // namespace

void resample(const dicom::Assessment& found, std::int16_t air, Built& built) {
  volume::Volume& slices = built.volume;
  const auto [low, high] = std::minmax_element(slices.voxels.begin(), slices.voxels.end());
  const std::int16_t least = *low, most = *high;

  volume::Volume straight;
  straight.header = slices.header;
  straight.header.size = found.size;
  straight.voxels.resize(straight.header.total_voxel_count());
  const auto width = found.size[0], height = found.size[1];
  const std::size_t picture = std::size_t{width} * height;

  vtkNew<vtkImageReslice> reslice;
  reslice->SetEnableSMP(false);
  reslice->SetNumberOfThreads(1);
  reslice->SetBackgroundLevel(air);
  reslice->GenerateStencilOutputOn();
  reslice->SetBorder(false);  // no extrapolation beyond the centres of the outermost pixels
  reslice->SetOutputSpacing(1, 1, 1);
  reslice->SetOutputExtent(0, static_cast<int>(width) - 1, 0, static_cast<int>(height) - 1, 0, 0);
  std::int16_t* to = straight.voxels.data();
  const std::size_t depth = found.sources.size();
  for (std::size_t k = 0; k < depth * straight.header.phase_count(); ++k, to += picture) {
    if (k % depth == 0) {
      const auto image = borrow(slices, static_cast<std::uint32_t>(k / depth));
      image->SetSpacing(1, 1, 1);  // the plan counts in pixels and slices
      image->SetDirectionMatrix(1, 0, 0, 0, 1, 0, 0, 0, 1);
      reslice->SetInputData(image);
    }
    const dicom::Source& source = found.sources[k % depth];
    std::array<double, 2> from{};  // position of the slice's first pixel
    for (std::size_t axis = 0; axis < 2; ++axis) {
      from[axis] = source.shift[axis] / found.spacing[axis] - found.corner[axis];
    }
    if (is_integer(source.slice)) {
      reslice->SetInterpolationModeToCubic();
    } else {
      reslice->SetInterpolationModeToLinear();
    }
    reslice->SetOutputOrigin(-from[0], -from[1], source.slice);
    reslice->Update();
    const auto* values = static_cast<const std::int16_t*>(reslice->GetOutput()->GetScalarPointer());
    std::transform(values, values + picture, to, [&](std::int16_t value) {
      return value == air ? air : std::clamp(value, least, most);
    });
    built.filler.count += picture - covered(reslice->GetStencilOutput(), static_cast<int>(width),
                                            static_cast<int>(height));
  }
  slices = std::move(straight);
}

}  // namespace diaphane::ingest
