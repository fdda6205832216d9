#include <vtkImageData.h>
#include <vtkImageImport.h>
#include <vtkNew.h>

#include <algorithm>
#include <vector>

#include "ingest/build/image_volume.h"
#include "ingest/build/nifti.h"

namespace diaphane::ingest {
namespace {

using Bytes = std::span<const std::byte>;

int vtk_type(NiftiType type) {
  switch (type) {
    case NiftiType::kUint8:
      return VTK_UNSIGNED_CHAR;
    case NiftiType::kInt8:
      return VTK_SIGNED_CHAR;
    case NiftiType::kUint16:
      return VTK_UNSIGNED_SHORT;
    case NiftiType::kInt16:
      return VTK_SHORT;
    case NiftiType::kUint32:
      return VTK_UNSIGNED_INT;
    case NiftiType::kInt32:
      return VTK_INT;
    case NiftiType::kFloat:
      return VTK_FLOAT;
    case NiftiType::kDouble:
      break;
  }
  return VTK_DOUBLE;
}

/// Returns the voxels in the byte order of this machine.
std::vector<std::byte> in_native_order(Bytes voxels, std::size_t width) {
  std::vector<std::byte> native(voxels.begin(), voxels.end());
  for (std::size_t i = 0; i + width <= native.size(); i += width) {
    std::reverse(native.begin() + static_cast<std::ptrdiff_t>(i),
                 native.begin() + static_cast<std::ptrdiff_t>(i + width));
  }
  return native;
}

}  // namespace

Result<volume::Volume> read_nifti_voxels(Bytes file, const NiftiHeader& header) {
  const std::size_t depth = header.size[2] * std::max<std::size_t>(header.phases.size(), 1);
  const std::size_t bytes =
      std::size_t{header.size[0]} * header.size[1] * depth * header.voxel_bytes;
  Bytes voxels = file.subspan(header.voxels_begin, bytes);
  std::vector<std::byte> native;
  // VTK needs numbers at their natural alignment.
  if (header.swapped || reinterpret_cast<std::uintptr_t>(voxels.data()) % header.voxel_bytes != 0) {
    native = in_native_order(voxels, header.swapped ? header.voxel_bytes : 1);
    voxels = native;
  }
  vtkNew<vtkImageImport> import;
  // VTK borrows the voxels and only reads them.
  import->SetImportVoidPointer(const_cast<std::byte*>(voxels.data()), 1);
  import->SetDataScalarType(vtk_type(header.type));
  import->SetNumberOfScalarComponents(1);
  import->SetWholeExtent(0, static_cast<int>(header.size[0]) - 1, 0,
                         static_cast<int>(header.size[1]) - 1, 0, static_cast<int>(depth) - 1);
  import->SetDataExtentToWholeExtent();
  import->Update();
  std::vector<std::string> repairs;
  if (!header.has_axes) repairs.emplace_back(kNoAxes);
  auto volume = to_volume(
      import->GetOutput(), header.axes, header.slope, header.intercept, std::move(repairs),
      header.has_axes ? std::optional(header.origin) : std::nullopt, header.phases);
  if (volume) volume->header.modality = header.modality;
  return volume;
}

}  // namespace diaphane::ingest
