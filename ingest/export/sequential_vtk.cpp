// Compiled as C++17, because GCC refuses VTK 9.1's header in C++20.
#include "ingest/export/sequential_vtk.h"

#include <vtkSMPTools.h>

namespace diaphane::ingest {

void use_sequential_vtk() { vtkSMPTools::SetBackend("Sequential"); }

}  // namespace diaphane::ingest
