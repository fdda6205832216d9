#pragma once

#include <string>

#include "ingest/build/image_header.h"

namespace diaphane::ingest {

/// Reads an NRRD file, and the files that it names, with the reference library of the format. An
/// axis outside of space, or the last of four axes, counts phases. Returns kInvalid for a damaged
/// file or an unknown encoding, kUnsupported for vectors, colours and 64-bit integers, and
/// kTooLarge for more voxels or phases than a volume may have.
Result<Image> read_nrrd(const std::string& path);

}  // namespace diaphane::ingest
