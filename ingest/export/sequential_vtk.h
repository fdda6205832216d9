#pragma once

namespace diaphane::ingest {

/// Makes VTK's filters use one thread, because the sandbox allows no others.
void use_sequential_vtk();

}  // namespace diaphane::ingest
