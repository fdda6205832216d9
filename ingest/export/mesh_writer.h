#pragma once

#include "common/result.h"
#include "ingest/export/mesh.h"
#include "ingest/export/sink.h"

namespace diaphane::ingest {

/// Writes binary STL in millimetres with the patient's axes (LPS: x to the left, y to the back, z
/// to the head). The header says so, as 3D Slicer writes and reads it ("SPACE=LPS").
Result<void> write_stl(const Mesh& mesh, const Sink& sink);

/// Writes binary glTF 2.0 (`.glb`) in metres, as the format requires, with the head up (+Y) and the
/// face to the viewer (+Z), so that +X is the patient's left. Points have normals, and the colour
/// of the mesh is its material.
Result<void> write_glb(const Mesh& mesh, const Sink& sink);

}  // namespace diaphane::ingest
