#include "ingest/export/surface.h"

#include <vtkCellArray.h>
#include <vtkDecimatePro.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkShortArray.h>
#include <vtkSmartPointer.h>
#include <vtkWindowedSincPolyDataFilter.h>

#include <algorithm>
#include <new>
#include <utility>

#include "ingest/export/placement.h"
#include "ingest/export/sequential_vtk.h"
#include "volume/alignment.h"

namespace diaphane::ingest {
namespace {

using Polygons = vtkSmartPointer<vtkPolyData>;

/// Extracts the surface, with points in units of samples.
Polygons extract(Field& field) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(static_cast<int>(field.size[0]), static_cast<int>(field.size[1]),
                       static_cast<int>(field.size[2]));
  vtkNew<vtkShortArray> scalars;
  constexpr int kDoNotFree = 1;
  scalars->SetArray(field.samples.data(), static_cast<vtkIdType>(field.samples.size()), kDoNotFree);
  image->GetPointData()->SetScalars(scalars);
  vtkNew<vtkFlyingEdges3D> edges;
  edges->SetInputData(image);
  edges->SetValue(0, 0);
  edges->ComputeNormalsOff();
  edges->ComputeGradientsOff();
  edges->ComputeScalarsOff();
  edges->Update();
  return edges->GetOutput();
}

/// Moves the points into the patient's space.
void place(const volume::Header& header, const Field& field, vtkPolyData* surface) {
  const auto origin = volume::first_voxel(header);
  vtkPoints* points = surface->GetPoints();
  for (vtkIdType i = 0; i < points->GetNumberOfPoints(); ++i) {
    std::array<double, 3> at{};
    points->GetPoint(i, at.data());
    for (std::size_t axis = 0; axis < 3; ++axis)
      at[axis] = field.first[axis] + field.step * at[axis];
    at = step_of(header, at);
    for (std::size_t axis = 0; axis < 3; ++axis) at[axis] += origin[axis];
    points->SetPoint(i, at.data());
  }
}

Polygons smooth(vtkPolyData* surface) {
  constexpr int kIterations = 20;
  constexpr double kPassBand = 0.1;  // removes the steps of voxels and keeps larger shapes
  vtkNew<vtkWindowedSincPolyDataFilter> filter;
  filter->SetInputData(surface);
  filter->SetNumberOfIterations(kIterations);
  filter->SetPassBand(kPassBand);
  filter->NonManifoldSmoothingOn();
  filter->NormalizeCoordinatesOn();
  filter->Update();
  return filter->GetOutput();
}

/// Reduces the number of triangles without opening the surface.
Polygons decimate(vtkPolyData* surface, std::uint64_t most) {
  const auto count = static_cast<double>(surface->GetNumberOfPolys());
  vtkNew<vtkDecimatePro> filter;
  filter->SetInputData(surface);
  filter->SetTargetReduction(1 - static_cast<double>(most) / count);
  filter->PreserveTopologyOn();
  filter->Update();
  return filter->GetOutput();
}

Mesh to_mesh(vtkPolyData* surface) {
  Mesh mesh;
  vtkPoints* points = surface->GetPoints();
  mesh.points.reserve(static_cast<std::size_t>(points->GetNumberOfPoints()));
  for (vtkIdType i = 0; i < points->GetNumberOfPoints(); ++i) {
    std::array<double, 3> at{};
    points->GetPoint(i, at.data());
    mesh.points.push_back(
        {static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2])});
  }
  mesh.triangles.reserve(static_cast<std::size_t>(surface->GetNumberOfPolys()));
  vtkCellArray* cells = surface->GetPolys();
  vtkIdType count = 0;
  const vtkIdType* ids = nullptr;
  for (cells->InitTraversal(); cells->GetNextCell(count, ids) != 0;) {
    mesh.triangles.push_back({static_cast<std::uint32_t>(ids[0]),
                              static_cast<std::uint32_t>(ids[1]),
                              static_cast<std::uint32_t>(ids[2])});
  }
  if (enclosed_volume(mesh) < 0) {
    for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  }
  return mesh;
}

/// Returns a mesh within the limits, or no triangles if this grid is too fine for them.
Mesh surface_of(const volume::Header& header, Field& field, bool is_label,
                const SurfaceLimits& limits) {
  // Checked before the triangles exist, which may not fit into memory.
  if (2 * crossings(field) > limits.raw_triangles) return {};
  Polygons surface = extract(field);
  if (static_cast<std::uint64_t>(surface->GetNumberOfPolys()) > limits.raw_triangles) return {};
  place(header, field, surface);
  if (is_label) surface = smooth(surface);
  if (static_cast<std::uint64_t>(surface->GetNumberOfPolys()) > limits.triangles)
    surface = decimate(surface, limits.triangles);
  Mesh mesh = to_mesh(surface);
  return mesh.triangles.size() <= limits.triangles && is_closed(mesh) ? mesh : Mesh();
}

}  // namespace

Result<Mesh> make_surface(const volume::Volume& volume, const Inside& inside,
                          const SurfaceLimits& limits) {
  use_sequential_vtk();
  const auto longest = *std::max_element(volume.header.size.begin(), volume.header.size.end());
  try {
    for (std::uint32_t step = 1; step <= longest; step *= 2) {
      auto field = sample_field(volume, inside, step, limits.samples);
      if (!field) {
        return fail(ErrorCode::kInvalid, inside.label > 0 ? "no voxel has this label"
                                                          : "no voxel has a value this high");
      }
      step = field->step;
      Mesh mesh = surface_of(volume.header, *field, inside.label > 0, limits);
      if (mesh.triangles.empty()) continue;
      if (inside.label > 0) mesh.colour = volume.label_set.table[inside.label - 1U].colour;
      return mesh;
    }
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory, "the surface needs more memory than allowed");
  }
  return fail(ErrorCode::kTooLarge, "the surface needs more triangles than allowed");
}

}  // namespace diaphane::ingest
